#include "bsoil/contact/contact_motion.h"

#include <algorithm>
#include <cmath>

namespace bsoil {

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
                            const MotionSource& source) {
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
    double extent_m = 0;
    for (const ContactVoxel& v : voxels) {
        if (v.carrier == carrier) {
            extent_m = std::max(extent_m, length(v.position_m - motion.center_of_mass_m));
        }
    }
    direction = motion;
    direction.linear_velocity_m_s = linear_m_s;
    direction.angular_velocity_rad_s = angular_rad_s;
    direction = as_share(direction, extent_m, source);
}

}  // namespace bsoil
