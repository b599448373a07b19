#include "bsoil/contact/contact_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace bsoil {
namespace {

/// Parts in which voxels are looked at. Ours: one for each thread of a large machine. Larger: more
/// lists of nothing; smaller: threads wait.
constexpr size_t kExtentParts = 16;
/// Of fewer voxels one thread looks at all. Ours, as a matter of cost: some hundredths of a
/// millisecond. Larger: one thread looks at a machine's; smaller: sharing them out takes longer.
constexpr size_t kExtentVoxels = 4096;

/// How far a carrier's voxels are from a point at most. The root rises with what it is of: that of
/// the largest square is the largest.
double extent_of(std::span<const ContactVoxel> voxels, int carrier, Vec3 middle_m,
                 const WorkThreads* threads) {
    std::array<double, kExtentParts> squares{};
    const WorkThreads* sharers = voxels.size() < kExtentVoxels ? nullptr : threads;
    for_ranges(sharers, kExtentParts, 1, [&](size_t first, size_t last) {
        for (size_t part = first; part < last; ++part) {
            const size_t begin = part * voxels.size() / kExtentParts,
                         end = (part + 1) * voxels.size() / kExtentParts;
            double most = 0;
            for (const ContactVoxel& v : voxels.subspan(begin, end - begin)) {
                if (v.carrier != carrier) continue;
                const Vec3 off_m = v.position_m - middle_m;
                most = std::max(most, dot(off_m, off_m));
            }
            squares[part] = most;
        }
    });
    return std::sqrt(*std::max_element(squares.begin(), squares.end()));
}

}  // namespace

BodyMotion as_share(const BodyMotion& motion, double extent_m, const MotionSource& source) {
    const double speed_m_s = length(motion.linear_velocity_m_s) +
                             extent_m * length(motion.angular_velocity_rad_s) + source.rest_m_s();
    BodyMotion out = motion;
    out.linear_velocity_m_s = motion.linear_velocity_m_s * (1 / speed_m_s);
    out.angular_velocity_rad_s = motion.angular_velocity_rad_s * (1 / speed_m_s);
    return out;
}

void ContactMotion::advance(const BodyMotion& body, const BodyMotion* under,
                            std::span<const ContactVoxel> voxels, double duration_s,
                            const MotionSource& source, const WorkThreads* threads) {
    motion = body;
    if (under) {
        motion.linear_velocity_m_s =
            motion.linear_velocity_m_s - under->velocity_at(motion.center_of_mass_m);
        motion.angular_velocity_rad_s =
            motion.angular_velocity_rad_s - under->angular_velocity_rad_s;
    }
    const double share =
        source.is_averaged ? -std::expm1(-duration_s / kContactMotion.yield_memory_s) : 1;
    linear_m_s += share * (motion.linear_velocity_m_s - linear_m_s);
    angular_rad_s += share * (motion.angular_velocity_rad_s - angular_rad_s);
    direction = motion;
    direction.linear_velocity_m_s = linear_m_s;
    direction.angular_velocity_rad_s = angular_rad_s;
    direction =
        as_share(direction, extent_of(voxels, carrier, motion.center_of_mass_m, threads), source);
}

}  // namespace bsoil
