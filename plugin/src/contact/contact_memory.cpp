#include "bsoil/contact/contact_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "bsoil/contact/orientation.h"

namespace bsoil {
namespace {

/// A surface that has drawn back further than this [voxels] has left its soil: how far, nobody
/// asks. Ours: unloaded_share() is 0 long before that, down to a depth of ten voxels. Larger: a
/// body that comes back has further to go before soil far below it bears in full; smaller: a deep
/// sole that has left its soil still bears.
constexpr double kRetreatMostVoxels = 1;

/// An entry of the soil beside a contact is mostly no further off along each axis [voxels]. It is
/// looked for there first. Ours, as a matter of cost: what a body moves in a step. Larger: more
/// entries are looked at; smaller: more contacts are looked for twice.
constexpr double kNearVoxels = 0.25;
/// Width of a cell [voxels]. Ours, as a matter of cost: what is looked for near the middle of a
/// voxel, where most entries lie in the middle of a cell, is in one. Larger: entries of voxels
/// beside are looked at; smaller: more cells are.
constexpr double kCellVoxels = 1;
/// No more cells than so many for each entry, but for a factor of less than 8. Ours, as a matter of
/// cost: the surface of a cube of 50 voxels keeps cells of one. Larger: more empty cells are
/// cleared; smaller: more entries are looked at.
constexpr double kCellsPerEntry = 8;
/// Of fewer entries one thread makes both indices. Ours, as a matter of cost: some hundredths of a
/// millisecond. Larger: one thread waits; smaller: sharing the work takes longer than the work.
constexpr size_t kSharedEntries = 2048;
/// A box is wider by this than what it is to hold. Ours: for the rounding. Larger: more entries are
/// looked at; smaller: one on the border is missed.
constexpr double kRoundingAdds = 1 + 1e-6;

/// The part of a sorted list from `x` on.
std::span<const PressedSoil> from_x(std::span<const PressedSoil> soil, double x) {
    const auto first =
        std::lower_bound(soil.begin(), soil.end(), x,
                         [](const PressedSoil& entry, double at) { return entry.center_m.x < at; });
    return soil.subspan(static_cast<size_t>(first - soil.begin()));
}

Aabb around_both(const Aabb& a, const Aabb& b) {
    return {{std::min(a.min.x, b.min.x), std::min(a.min.y, b.min.y), std::min(a.min.z, b.min.z)},
            {std::max(a.max.x, b.max.x), std::max(a.max.y, b.max.y), std::max(a.max.z, b.max.z)}};
}

/// Of the middles.
Aabb box_of(std::span<const PressedSoil> soil) {
    if (soil.empty()) return {};
    Aabb box{soil.front().center_m, soil.front().center_m};
    for (const PressedSoil& entry : soil) box = around_both(box, {entry.center_m, entry.center_m});
    return box;
}

/// How far a surface has drawn back that passes over its soil for a while. Speeds along the normal
/// go evenly from that of the surface that was there at first to that of the one that is there now:
/// a wheel that rolls on goes down and up again within a step. before: the soil as it was, or null.
double retreat_after(const ContactVoxel& v, const PressedSoil* before, const BodyMotion& motion,
                     double duration_s) {
    const Vec3 velocity = motion.velocity_at(v.position_m);
    const double last_m_s = -dot(velocity, v.normal);
    if (!before) return duration_s * last_m_s;
    const Vec3 first =
        velocity + cross(motion.angular_velocity_rad_s, duration_s * motion.linear_velocity_m_s);
    const double first_m_s = -dot(first, before->normal);
    const double moved_m = before->retreat_m + 0.5 * duration_s * (first_m_s + last_m_s);
    if (first_m_s >= 0 || last_m_s <= 0) return moved_m;
    // Since it went down furthest.
    return std::max(moved_m, 0.5 * duration_s * last_m_s * last_m_s / (last_m_s - first_m_s));
}

/// The direction in which the soil beside a contact goes with it.
Vec3 way_of(const ContactVoxel& v, const ContactLaw& law) {
    return looks_down(v.normal, law.up()) > law.def().looks_down_cosine ? law.up() : v.normal;
}

}  // namespace

void ContactMemory::Index::make(std::span<const PressedSoil> soil, const Aabb& box, double voxel_m,
                                const WorkThreads* threads) {
    soil_ = soil;
    const double cell_m = kCellVoxels * voxel_m;
    if (soil.empty()) return;
    box_ = box;
    // Middles of voxels lie in the middles of cells.
    low_ = box_.min - 0.5 * Vec3{cell_m, cell_m, cell_m};
    const Vec3 size = box_.max - low_;
    const double most = kCellsPerEntry * static_cast<double>(soil.size());
    const double area = std::max({size.x * size.y, size.y * size.z, size.z * size.x});
    per_cell_ = std::min({1 / cell_m, std::cbrt(most / (size.x * size.y * size.z)),
                          std::sqrt(most / area), most / std::max({size.x, size.y, size.z})});
    constexpr int kAny = std::numeric_limits<int>::max();
    last_ = {cell_at(size.x, kAny), cell_at(size.y, kAny), cell_at(size.z, kAny)};
    const auto count = [this](int axis) { return static_cast<size_t>(last_[axis]) + 1; };
    cells_.resize(soil.size());
    const WorkThreads* sharers = soil.size() < kSharedEntries ? nullptr : threads;
    for_ranges(sharers, soil.size(), kRangeVoxels, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const Vec3 off = soil[i].center_m - low_;
            cells_[i] = row_of(cell_at(off.y, last_[1]), cell_at(off.z, last_[2])) +
                        static_cast<size_t>(cell_at(off.x, last_[0]));
        }
    });
    // A cell's start stands one behind its place while its entries move it on to the next one's.
    starts_.assign(count(0) * count(1) * count(2) + 2, 0);
    for (const size_t cell : cells_) ++starts_[cell + 2];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    spots_.resize(soil.size());
    for (size_t i = 0; i < soil.size(); ++i) {
        spots_[static_cast<size_t>(starts_[cells_[i] + 1]++)] = {soil[i].center_m, i};
    }
}

bool ContactMemory::Index::may_hold(Vec3 middle, double half_m) const {
    const Vec3 half{half_m, half_m, half_m}, from = middle - half, to = middle + half;
    return from.x <= box_.max.x && to.x >= box_.min.x && from.y <= box_.max.y &&
           to.y >= box_.min.y && from.z <= box_.max.z && to.z >= box_.min.z;
}

template <typename Visit>
void ContactMemory::Index::visit_box(Vec3 middle, Vec3 half, const Visit& visit) const {
    const Vec3 low = middle - half - low_, high = middle + half - low_;
    const int x0 = cell_at(low.x, last_[0]), x1 = cell_at(high.x, last_[0]);
    const int y0 = cell_at(low.y, last_[1]), y1 = cell_at(high.y, last_[1]);
    const int z0 = cell_at(low.z, last_[2]), z1 = cell_at(high.z, last_[2]);
    const auto visit_row = [&](size_t row) {
        const auto end = static_cast<size_t>(starts_[row + static_cast<size_t>(x1) + 1]);
        for (auto i = static_cast<size_t>(starts_[row + static_cast<size_t>(x0)]); i < end; ++i) {
            const Vec3 apart = spots_[i].center_m - middle;
            const bool is_in[] = {std::abs(apart.x) <= half.x, std::abs(apart.y) <= half.y,
                                  std::abs(apart.z) <= half.z};
            // One branch for the three: which of them fails, the processor cannot guess.
            if (is_in[0] + is_in[1] + is_in[2] == 3) visit(soil_[spots_[i].place], apart);
        }
    };
    for (int z = z0; z <= z1; ++z) {
        for (int y = y0; y <= y1; ++y) visit_row(row_of(y, z));
    }
}

const PressedSoil* ContactMemory::Index::find(const ContactVoxel& v, const ContactLaw& law,
                                              double cosine_least, bool is_own) const {
    if (soil_.empty()) return nullptr;
    const double voxel_m = law.voxel_m(), far_m = law.def().memory_reach_voxels * voxel_m;
    const double reach_m = law.def().same_along_voxels * voxel_m;
    const double across_m = law.def().same_across_voxels * voxel_m;
    // No entry that counts is further off than both together.
    if (!may_hold(v.center_m, (reach_m + across_m) * kRoundingAdds)) return nullptr;
    const Vec3 way = way_of(v, law);
    const PressedSoil* same = nullptr;
    double least = std::numeric_limits<double>::infinity();
    const auto look_at = [&](const PressedSoil& entry, Vec3 apart) {
        if (std::abs(apart.y) > far_m || std::abs(apart.z) > far_m) return;
        const double square = dot(apart, apart);
        if (square > least) return;  // farther alone is worse than another in all
        const double along = dot(apart, way);
        if (std::abs(along) > reach_m || square - along * along > across_m * across_m) return;
        const double cosine = dot(entry.normal, v.normal);
        if (cosine < cosine_least) return;
        const double unlike = square + (1 - cosine) * across_m * across_m;
        // Of two that are as near the first in the list.
        if (unlike < least || (unlike == least && &entry < same)) {
            least = unlike;
            same = &entry;
        }
    };
    // Mostly the voxel's own entry is there. Nothing outside of the box around it is nearer.
    if (is_own) {
        const double near_m = kNearVoxels * voxel_m, wide_m = near_m * kRoundingAdds;
        visit_box(v.center_m, {wide_m, wide_m, wide_m}, look_at);
        if (least < near_m * near_m) return same;
    }
    // What is far along the way and far off it: no more than that along an axis, but for rounding.
    const auto reach_along = [&](double way_part) {
        const double off_part = std::sqrt(std::max(0.0, 1 - way_part * way_part));
        return (reach_m * std::abs(way_part) + across_m * off_part) * kRoundingAdds;
    };
    visit_box(v.center_m, {reach_along(way.x), reach_along(way.y), reach_along(way.z)}, look_at);
    return same;
}

PressedList::PressedList(std::span<const PressedSoil> sorted_soil, int of_body)
    : PressedList(sorted_soil, of_body, box_of(sorted_soil)) {}

void ContactMemory::near(std::span<const PressedList> lists, std::span<const ContactVoxel> voxels,
                         int body, const ContactLaw& law, std::vector<PressedSoil>& out) {
    out.clear();
    if (voxels.empty()) return;
    Aabb box{voxels.front().center_m, voxels.front().center_m};
    for (const ContactVoxel& v : voxels) {
        box.min = {std::min(box.min.x, v.center_m.x), std::min(box.min.y, v.center_m.y),
                   std::min(box.min.z, v.center_m.z)};
        box.max = {std::max(box.max.x, v.center_m.x), std::max(box.max.y, v.center_m.y),
                   std::max(box.max.z, v.center_m.z)};
    }
    const double reach_m = law.def().memory_reach_voxels * law.voxel_m();
    const Vec3 reach{reach_m, reach_m, reach_m}, low = box.min - reach, high = box.max + reach;
    std::vector<std::pair<double, const PressedSoil*>> beside;
    for (const PressedList& list : lists) {
        const Aabb& of = list.box;
        if (list.body == body || list.soil.empty() || of.max.x < low.x || of.min.x > high.x ||
            of.max.y < low.y || of.min.y > high.y || of.max.z < low.z || of.min.z > high.z) {
            continue;
        }
        for (const PressedSoil& entry : from_x(list.soil, low.x)) {
            const Vec3 c = entry.center_m;
            if (c.x > high.x) break;
            if (c.y >= low.y && c.y <= high.y && c.z >= low.z && c.z <= high.z) {
                beside.emplace_back(c.x, &entry);
            }
        }
    }
    // What is moved to its place is a fifth of an entry.
    const auto lies_first = [](const auto& a, const auto& b) { return a.first < b.first; };
    if (!std::ranges::is_sorted(beside, lies_first)) std::ranges::stable_sort(beside, lies_first);
    for (const auto& [x, entry] : beside) out.push_back(*entry);
}

void ContactMemory::look_around(std::span<const PressedSoil> around, const ContactLaw& law,
                                const WorkThreads* threads) {
    previous_.swap(entries_);
    const double voxel_m = law.voxel_m();
    const WorkThreads* sharers = previous_.size() < kSharedEntries ? nullptr : threads;
    for_ranges(sharers, 2, 1, [&](size_t first, size_t last) {
        if (first == 0) own_index_.make(previous_, box_, voxel_m, threads);
        if (last == 2) around_index_.make(around, box_of(around), voxel_m, threads);
    });
    has_looked_ = true;
}

std::span<const ContactHistory> ContactMemory::advance(std::span<const ContactVoxel> voxels,
                                                       const BodyMotion& motion,
                                                       const ContactLaw& law, double duration_s,
                                                       std::span<const PressedSoil> around,
                                                       std::span<const ContactMotion> relative,
                                                       const WorkThreads* threads) {
    const double voxel_m = law.voxel_m();
    if (!std::exchange(has_looked_, false)) {
        look_around(around, law, threads);
        has_looked_ = false;
    }
    entries_.resize(voxels.size());
    history_.resize(voxels.size());
    const auto advance_one = [&](size_t i) {
        const ContactVoxel& v = voxels[i];
        const Vec3 own = motion.velocity_at(v.position_m);
        const BodyMotion& past_soil =
            relative.empty() ? motion : motion_for(relative, v.carrier).motion;
        const Vec3 velocity = past_soil.velocity_at(v.position_m);
        // Soil that only brushes the body, with no depth to it or a gap before it, is not sheared.
        const bool is_pressed = v.bearing_depth_m > 0 && v.touching > 0;
        Vec3 slid = is_pressed ? duration_s * law.slide_m_s(v, velocity) : Vec3{};
        const PressedSoil* same = own_index_.find(v, law, -1, true);
        double retreat_m = retreat_after(v, same, past_soil, duration_s);
        const PressedSoil* others =
            around_index_.find(v, law, law.def().same_contact_cosine, false);
        if (others && (!same || length(others->slid_m) > length(same->slid_m))) same = others;
        if (same) slid += same->slid_m;
        retreat_m = std::clamp(retreat_m, 0.0, kRetreatMostVoxels * voxel_m);
        entries_[i] = {v.center_m + duration_s * (own - velocity), v.normal, slid, retreat_m};
        history_[i] = {length(slid), retreat_m};
    };
    for_ranges(threads, voxels.size(), kRangeVoxels, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) advance_one(i);
    });
    sort_entries(threads);
    return history_;
}

// On the ground they are sorted as the voxels are. What was known before is not needed any more,
// and has room for them in their order.
void ContactMemory::sort_entries(const WorkThreads* threads) {
    const size_t count = entries_.size();
    stretches_.resize((count + kSharedEntries - 1) / kSharedEntries);
    for_ranges(threads, stretches_.size(), 1, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const size_t begin = i * kSharedEntries, own = std::min(kSharedEntries, count - begin);
            const auto with_next =
                std::span(entries_).subspan(begin, std::min(own + 1, count - begin));
            stretches_[i] = {std::ranges::is_sorted(with_next, lies_before),
                             box_of(with_next.first(own))};
        }
    });
    box_ = stretches_.empty() ? Aabb{} : stretches_.front().box;
    for (const Stretch& stretch : stretches_) box_ = around_both(box_, stretch.box);
    if (std::ranges::all_of(stretches_, &Stretch::is_sorted)) return;
    order_.clear();
    for (size_t i = 0; i < entries_.size(); ++i) order_.emplace_back(entries_[i].center_m.x, i);
    std::ranges::sort(order_);
    previous_.clear();
    for (const auto& [x, place] : order_) previous_.push_back(entries_[place]);
    previous_.swap(entries_);
}

std::span<const ContactHistory> ContactMemory::recall(std::span<const ContactVoxel> voxels,
                                                      const ContactLaw& law,
                                                      const WorkThreads* threads) {
    own_index_.make(entries_, box_, law.voxel_m(), threads);
    history_.resize(voxels.size());
    for_ranges(threads, voxels.size(), kRangeVoxels, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const PressedSoil* same = own_index_.find(voxels[i], law, -1, true);
            history_[i] =
                same ? ContactHistory{length(same->slid_m), same->retreat_m} : ContactHistory{};
        }
    });
    return history_;
}

void ContactMemory::set_soil(std::span<const PressedSoil> soil) {
    entries_.assign(soil.begin(), soil.end());
    box_ = box_of(soil);
}

}  // namespace bsoil
