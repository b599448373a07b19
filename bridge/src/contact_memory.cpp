#include "contact_memory.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bsoil::bullet {
namespace {

/// Distances between voxels' centres, in voxels. Less than this far across the normal it is the
/// same column of soil, less than this far along it the same soil pushed on. A neighbour beside it,
/// on a face tilted by up to 50 degrees, is further across than that.
constexpr double kSameAcross = 0.6, kSameAlong = 1.75;

}  // namespace

std::span<const ContactHistory> ContactMemory::advance(std::span<const ContactVoxel> voxels,
                                                       const BodyMotion& motion, double voxel_m,
                                                       double duration_s) {
    previous_.swap(entries_);
    entries_.clear();
    history_.clear();
    const double reach_m = kSameAlong * voxel_m, across_m = kSameAcross * voxel_m;
    for (const ContactVoxel& v : voxels) {
        const Vec3 velocity = motion.velocity_at(v.position_m);
        // Soil that only brushes the body, with no depth to it, is not sheared.
        const bool is_pressed = bearing_depth_m(v) > 0;
        Vec3 slid =
            is_pressed ? duration_s * (velocity - dot(velocity, v.normal) * v.normal) : Vec3{};
        const Entry* same = nullptr;
        double least = std::numeric_limits<double>::infinity();
        for (auto it =
                 std::lower_bound(previous_.begin(), previous_.end(), v.center_m.x - reach_m,
                                  [](const Entry&entry, double x) { return entry.center_m.x < x; });
             it != previous_.end() && it->center_m.x <= v.center_m.x + reach_m; ++it) {
            const Vec3 apart = it->center_m - v.center_m;
            const double along = dot(apart, v.normal);
            const double square = dot(apart, apart);
            if (std::abs(along) > reach_m || square - along * along > across_m * across_m) continue;
            // The nearest; of an edge's two faces in one voxel the one that looks the same way.
            const double unlike = square + (1 - dot(it->normal, v.normal)) * across_m * across_m;
            if (unlike >= least) continue;
            least = unlike;
            same = &*it;
        }
        double retreat_m = -duration_s * dot(velocity, v.face_normal);
        if (same) {
            slid += same->slid_m;
            retreat_m += same->retreat_m;
        }
        retreat_m = std::clamp(retreat_m, 0.0, voxel_m);
        entries_.push_back({v.center_m, v.normal, slid, retreat_m});
        history_.push_back({length(slid), retreat_m});
    }
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.center_m.x < b.center_m.x; });
    return history_;
}

}  // namespace bsoil::bullet
