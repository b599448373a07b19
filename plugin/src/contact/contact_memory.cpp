#include "bsoil/contact/contact_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bsoil {
namespace {

/// The part of a sorted list from `x` on.
std::span<const PressedSoil> from_x(std::span<const PressedSoil> soil, double x) {
    const auto first =
        std::lower_bound(soil.begin(), soil.end(), x,
                         [](const PressedSoil& entry, double at) { return entry.center_m.x < at; });
    return soil.subspan(static_cast<size_t>(first - soil.begin()));
}

/// The soil of a contact voxel in a list sorted by center_m.x, null where it is not there: the
/// nearest; of an edge's two faces in one voxel the one that looks the same way.
const PressedSoil* find(std::span<const PressedSoil> soil, const ContactVoxel& v, Vec3 way,
                        const ContactLaw& law, double cosine_least) {
    const double voxel_m = law.voxel_m(), far_m = law.def().memory_reach_voxels * voxel_m;
    const double reach_m = law.def().same_along_voxels * voxel_m;
    const double across_m = law.def().same_across_voxels * voxel_m;
    const PressedSoil* same = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (const PressedSoil& entry : from_x(soil, v.center_m.x - reach_m)) {
        if (entry.center_m.x > v.center_m.x + reach_m) break;
        const Vec3 apart = entry.center_m - v.center_m;
        if (std::abs(apart.y) > far_m || std::abs(apart.z) > far_m) continue;
        const double along = dot(apart, way);
        const double square = dot(apart, apart), cosine = dot(entry.normal, v.normal);
        if (std::abs(along) > reach_m || square - along * along > across_m * across_m) continue;
        const double unlike = square + (1 - cosine) * across_m * across_m;
        if (cosine < cosine_least || unlike >= least) continue;
        least = unlike;
        same = &entry;
    }
    return same;
}

/// The direction in which the soil beside a contact goes with it.
Vec3 way_of(const ContactVoxel& v, const ContactLaw& law) {
    return dot(v.normal, law.up()) < -law.def().looks_down_cosine ? law.up() : v.normal;
}

}  // namespace

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
            c.z >= box.min.z - reach_m && c.z <= box.max.z + reach_m)
            out.push_back(entry);
    }
}

std::span<const ContactHistory> ContactMemory::advance(std::span<const ContactVoxel> voxels,
                                                       const BodyMotion& motion,
                                                       const ContactLaw& law, double duration_s,
                                                       std::span<const PressedSoil> around,
                                                       std::span<const ContactMotion> relative) {
    const double voxel_m = law.voxel_m();
    previous_.swap(entries_);
    entries_.clear();
    history_.clear();
    for (const ContactVoxel& v : voxels) {
        const Vec3 own = motion.velocity_at(v.position_m);
        const Vec3 velocity =
            relative.empty() ? own
                             : motion_for(relative, v.carrier).motion.velocity_at(v.position_m);
        // Soil that only brushes the body, with no depth to it or a gap before it, is not sheared.
        const bool is_pressed = bearing_depth_m(v) > 0 && law.touching_share(v) > 0;
        Vec3 slid =
            is_pressed ? duration_s * (velocity - dot(velocity, v.normal) * v.normal) : Vec3{};
        double retreat_m = -duration_s * dot(velocity, v.normal);
        const Vec3 way = way_of(v, law);
        const PressedSoil* same = find(previous_, v, way, law, -1);
        if (same) retreat_m += same->retreat_m;
        const PressedSoil* others = find(around, v, way, law, law.def().same_contact_cosine);
        if (others && (!same || length(others->slid_m) > length(same->slid_m))) same = others;
        if (same) slid += same->slid_m;
        retreat_m = std::clamp(retreat_m, 0.0, voxel_m);
        entries_.push_back({v.center_m + duration_s * (own - velocity), v.normal, slid, retreat_m});
        history_.push_back({length(slid), retreat_m});
    }
    std::stable_sort(entries_.begin(), entries_.end(), lies_before);
    return history_;
}

std::span<const ContactHistory> ContactMemory::recall(std::span<const ContactVoxel> voxels,
                                                      const ContactLaw& law) {
    history_.clear();
    for (const ContactVoxel& v : voxels) {
        const PressedSoil* same = find(entries_, v, way_of(v, law), law, -1);
        history_.push_back(same ? ContactHistory{length(same->slid_m), same->retreat_m}
                                : ContactHistory{});
    }
    return history_;
}

void ContactMemory::set_soil(std::span<const PressedSoil> soil) {
    entries_.assign(soil.begin(), soil.end());
}

}  // namespace bsoil
