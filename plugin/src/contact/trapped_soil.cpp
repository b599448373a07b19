#include "bsoil/contact/trapped_soil.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bsoil {

double trapped_share(const ToothRow& teeth, double friction_angle_rad) {
    const double between_m = teeth.pitch_m - teeth.thickness_m;
    const double wedge_m = teeth.height_m * std::tan(std::numbers::pi / 4 + friction_angle_rad / 2);
    if (!(teeth.pitch_m > 0)) return 0;
    return wedge_m < between_m ? wedge_m / between_m : 1;
}

double filled_share(const ToothRow& teeth, double depth_m, Vec3 up) {
    const double rise = dot(teeth.outward, up);
    const double root_m = depth_m + teeth.above_m * rise, tip_m = root_m - teeth.height_m * rise;
    const double low_m = std::min(root_m, tip_m), high_m = std::max(root_m, tip_m);
    if (low_m >= 0) return 1;
    return high_m > 0 ? high_m / (high_m - low_m) : 0;
}

double bearing_depth_of(const ContactVoxel& contact, Vec3 up) {
    const ToothRow& teeth = contact.teeth;
    if (teeth.part != ToothPart::over_tips) return contact.bearing_depth_m;
    const double below_root_m = std::max(0.0, -teeth.above_m * dot(teeth.outward, up));
    return std::max(0.0, contact.bearing_depth_m - below_root_m);
}

double area_share_of(const ContactVoxel& contact, double friction_angle_rad,
                     const ContactLawDef& law, Vec3 up) {
    const ToothRow& teeth = contact.teeth;
    if (!(teeth.pitch_m > 0)) return 1;
    if (!law.trapped_soil) return teeth.part == ToothPart::over_tips ? 0 : 1;
    const double filled = filled_share(teeth, contact.depth_m, up);
    const double trapped = filled * trapped_share(teeth, friction_angle_rad);
    switch (teeth.part) {
        case ToothPart::base:
            return 1 - trapped;
        case ToothPart::tooth:
            return 1 - filled;
        case ToothPart::over_tips:
            break;
    }
    // It goes all the way round, over the tips as well.
    return trapped * (1 - std::min(1.0, teeth.thickness_m / teeth.pitch_m));
}

}  // namespace bsoil
