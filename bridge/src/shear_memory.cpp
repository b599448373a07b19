#include "shear_memory.h"

#include <algorithm>
#include <cmath>

namespace bsoil::bullet {
namespace {

/// A contact further than this across the normal is another piece of soil; along it, the same soil
/// pushed on. Voxels.
constexpr double kSameAcross = 0.75, kSameAlong = 1.75;

}  // namespace

std::span<const double> ShearMemory::advance(std::span<const ContactVoxel> voxels,
                                             const BodyMotion& motion, double voxel_m,
                                             double duration_s) {
    previous_.swap(entries_);
    entries_.clear();
    displacement_m_.clear();
    const double reach_m = kSameAlong * voxel_m;
    for (const ContactVoxel& v : voxels) {
        const Vec3 velocity = motion.velocity_at(v.position_m);
        Vec3 slid = duration_s * (velocity - dot(velocity, v.normal) * v.normal);
        const Entry* same = nullptr;
        double nearest = kSameAcross * kSameAcross * voxel_m * voxel_m;
        for (auto it = std::lower_bound(
                 previous_.begin(), previous_.end(), v.position_m.x - reach_m,
                 [](const Entry&entry, double x) { return entry.position_m.x < x; });
             it != previous_.end() && it->position_m.x <= v.position_m.x + reach_m; ++it) {
            const Vec3 apart = it->position_m - v.position_m;
            const double along = dot(apart, v.normal);
            const double across = dot(apart, apart) - along * along;
            if (std::abs(along) > reach_m || across >= nearest) continue;
            nearest = across;
            same = &*it;
        }
        if (same) slid += same->slid_m;
        entries_.push_back({v.position_m, slid});
        displacement_m_.push_back(length(slid));
    }
    std::stable_sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
        return a.position_m.x < b.position_m.x;
    });
    return displacement_m_;
}

}  // namespace bsoil::bullet
