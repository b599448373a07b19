#include "bsoil/contact/contact_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "bsoil/contact/orientation.h"

namespace bsoil {
namespace {

/// A surface that has drawn back further than this [voxels] has left its soil: how far, nobody
/// asks. Ours: unloaded_share() is 0 long before that, down to a depth of ten voxels. Larger: a
/// body that comes back has further to go before soil far below it bears in full; smaller: a deep
/// sole that has left its soil still bears.
constexpr double kRetreatMostVoxels = 1;

/// The part of a sorted list from `x` on.
std::span<const PressedSoil> from_x(std::span<const PressedSoil> soil, double x) {
    const auto first =
        std::lower_bound(soil.begin(), soil.end(), x,
                         [](const PressedSoil& entry, double at) { return entry.center_m.x < at; });
    return soil.subspan(static_cast<size_t>(first - soil.begin()));
}

/// The direction in which the soil beside a contact goes with it.
Vec3 way_of(const ContactVoxel& v, const ContactLaw& law) {
    return looks_down(v.normal, law.up()) > law.def().looks_down_cosine ? law.up() : v.normal;
}

}  // namespace

void ContactMemory::Index::make(std::span<const PressedSoil> soil, double width_m) {
    soil_ = soil;
    if (soil.empty()) return;
    const auto [low, high] = std::minmax_element(
        soil.begin(), soil.end(),
        [](const auto& a, const auto& b) { return a.center_m.y < b.center_m.y; });
    const double range_m = high->center_m.y - low->center_m.y;
    low_y_ = low->center_m.y;
    width_m_ = std::max(width_m, range_m / static_cast<double>(soil.size()));
    starts_.assign(static_cast<size_t>(range_m / width_m_) + 2, 0);
    for (const PressedSoil& entry : soil) {
        ++starts_[static_cast<size_t>(strip_at(entry.center_m.y))];
    }
    int before = 0;
    for (int& start : starts_) before += std::exchange(start, before);
    spots_.resize(soil.size());
    for (size_t i = 0; i < soil.size(); ++i) {
        int& next = starts_[static_cast<size_t>(strip_at(soil[i].center_m.y))];
        spots_[static_cast<size_t>(next++)] = {soil[i].center_m, i};
    }
    // Each start has moved on to the next one.
    std::rotate(starts_.begin(), starts_.end() - 1, starts_.end());
    starts_.front() = 0;
}

int ContactMemory::Index::strip_at(double y) const {
    const double strip = std::floor((y - low_y_) / width_m_);
    return static_cast<int>(std::clamp(strip, 0.0, static_cast<double>(starts_.size() - 2)));
}

const PressedSoil* ContactMemory::Index::find(const ContactVoxel& v, const ContactLaw& law,
                                              double cosine_least) const {
    if (soil_.empty()) return nullptr;
    const double voxel_m = law.voxel_m(), far_m = law.def().memory_reach_voxels * voxel_m;
    const double reach_m = law.def().same_along_voxels * voxel_m;
    const double across_m = law.def().same_across_voxels * voxel_m;
    const Vec3 way = way_of(v, law);
    // What is far along the way and far off it: no more than that along an axis, but for rounding.
    const auto reach_along = [&](double way_part) {
        const double off_part = std::sqrt(std::max(0.0, 1 - way_part * way_part));
        return (reach_m * std::abs(way_part) + across_m * off_part) * (1 + 1e-6);
    };
    const double x0 = v.center_m.x - reach_along(way.x), x1 = v.center_m.x + reach_along(way.x);
    const PressedSoil* same = nullptr;
    double least = std::numeric_limits<double>::infinity();
    const int last = strip_at(v.center_m.y + reach_along(way.y));
    for (int strip = strip_at(v.center_m.y - reach_along(way.y)); strip <= last; ++strip) {
        const auto begin = spots_.begin() + starts_[static_cast<size_t>(strip)];
        const auto end = spots_.begin() + starts_[static_cast<size_t>(strip) + 1];
        const auto first = std::lower_bound(
            begin, end, x0, [](const Spot& spot, double at) { return spot.center_m.x < at; });
        for (auto spot = first; spot != end; ++spot) {
            if (spot->center_m.x > x1) break;
            const Vec3 apart = spot->center_m - v.center_m;
            if (std::abs(apart.y) > far_m || std::abs(apart.z) > far_m) continue;
            const double square = dot(apart, apart);
            if (square > least) continue;  // farther alone is worse than another in all
            const double along = dot(apart, way);
            if (std::abs(along) > reach_m || square - along * along > across_m * across_m) continue;
            const PressedSoil& entry = soil_[spot->place];
            const double cosine = dot(entry.normal, v.normal);
            if (cosine < cosine_least) continue;
            const double unlike = square + (1 - cosine) * across_m * across_m;
            // Of two that are as near the first in the list.
            if (unlike < least || (unlike == least && &entry < same)) {
                least = unlike;
                same = &entry;
            }
        }
    }
    return same;
}

void ContactMemory::near(std::span<const PressedSoil> soil, std::span<const ContactVoxel> voxels,
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
    for (const PressedSoil& entry : from_x(soil, box.min.x - reach_m)) {
        const Vec3 c = entry.center_m;
        if (c.x > box.max.x + reach_m) break;
        if (entry.body == body) continue;
        if (c.y >= box.min.y - reach_m && c.y <= box.max.y + reach_m &&
            c.z >= box.min.z - reach_m && c.z <= box.max.z + reach_m) {
            out.push_back(entry);
        }
    }
}

std::span<const ContactHistory> ContactMemory::advance(std::span<const ContactVoxel> voxels,
                                                       const BodyMotion& motion,
                                                       const ContactLaw& law, double duration_s,
                                                       std::span<const PressedSoil> around,
                                                       std::span<const ContactMotion> relative,
                                                       const WorkThreads* threads) {
    const double voxel_m = law.voxel_m();
    previous_.swap(entries_);
    entries_.resize(voxels.size());
    history_.resize(voxels.size());
    own_index_.make(previous_, voxel_m);
    around_index_.make(around, voxel_m);
    const auto advance_one = [&](size_t i) {
        const ContactVoxel& v = voxels[i];
        const Vec3 own = motion.velocity_at(v.position_m);
        const Vec3 velocity =
            relative.empty() ? own
                             : motion_for(relative, v.carrier).motion.velocity_at(v.position_m);
        // Soil that only brushes the body, with no depth to it or a gap before it, is not sheared.
        const bool is_pressed = v.bearing_depth_m > 0 && v.touching > 0;
        Vec3 slid =
            is_pressed ? duration_s * (velocity - dot(velocity, v.normal) * v.normal) : Vec3{};
        double retreat_m = -duration_s * dot(velocity, v.normal);
        const PressedSoil* same = own_index_.find(v, law, -1);
        if (same) retreat_m += same->retreat_m;
        const PressedSoil* others = around_index_.find(v, law, law.def().same_contact_cosine);
        if (others && (!same || length(others->slid_m) > length(same->slid_m))) same = others;
        if (same) slid += same->slid_m;
        retreat_m = std::clamp(retreat_m, 0.0, kRetreatMostVoxels * voxel_m);
        entries_[i] = {v.center_m + duration_s * (own - velocity), v.normal, slid, retreat_m};
        history_[i] = {length(slid), retreat_m};
    };
    for_ranges(threads, voxels.size(), kRangeVoxels, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) advance_one(i);
    });
    std::stable_sort(entries_.begin(), entries_.end(), lies_before);
    return history_;
}

std::span<const ContactHistory> ContactMemory::recall(std::span<const ContactVoxel> voxels,
                                                      const ContactLaw& law,
                                                      const WorkThreads* threads) {
    own_index_.make(entries_, law.voxel_m());
    history_.resize(voxels.size());
    for_ranges(threads, voxels.size(), kRangeVoxels, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const PressedSoil* same = own_index_.find(voxels[i], law, -1);
            history_[i] =
                same ? ContactHistory{length(same->slid_m), same->retreat_m} : ContactHistory{};
        }
    });
    return history_;
}

void ContactMemory::set_soil(std::span<const PressedSoil> soil) {
    entries_.assign(soil.begin(), soil.end());
}

}  // namespace bsoil
