#include "bsoil/contact/trapped_soil.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bsoil {

double trapped_share(const ToothRow& teeth, double friction_angle_rad) {
    if (!(teeth.pitch_m > 0)) return 0;
    const double wedge_m = teeth.height_m * std::tan(std::numbers::pi / 4 + friction_angle_rad / 2);
    return std::min(1.0, (wedge_m + teeth.thickness_m) / teeth.pitch_m);
}

double filled_share(const ToothRow& teeth, double depth_m, Vec3 up) {
    const double rise = dot(teeth.outward, up);
    const double root_m = depth_m + teeth.above_m * rise, tip_m = root_m - teeth.height_m * rise;
    const double low_m = std::min(root_m, tip_m), high_m = std::max(root_m, tip_m);
    if (low_m >= 0) return 1;
    return high_m > 0 ? high_m / (high_m - low_m) : 0;
}

double pushed_share(const ToothRow& teeth, Vec3 motion, double creep) {
    const double pressed = dot(motion, teeth.outward), all = dot(motion, motion);
    return (std::max(0.0, all - pressed * pressed) + creep * creep) / (all + creep * creep);
}

double area_share_of(const ContactVoxel& contact, Vec3 motion, double friction_angle_rad,
                     const ContactLawDef& law, Vec3 up) {
    const ToothRow& teeth = contact.teeth;
    if (!(teeth.pitch_m > 0)) return 1;
    const double trapped = law.trapped_soil ? trapped_share(teeth, friction_angle_rad) *
                                                  filled_share(teeth, contact.depth_m, up) *
                                                  pushed_share(teeth, motion, law.creep)
                                            : 0;
    return teeth.is_over_tips ? trapped : 1 - trapped;
}

}  // namespace bsoil
