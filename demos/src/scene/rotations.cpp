#include "rotations.h"

#include <cmath>

namespace bsoil::scene {

Quat axis_rotation(Vec3 axis, double angle_rad) {
    const Vec3 u = axis * (std::sin(angle_rad / 2) / length(axis));
    return {u.x, u.y, u.z, std::cos(angle_rad / 2)};
}

Quat fixed_axes_rotation(Vec3 angles_rad) {
    return axis_rotation({0, 0, 1}, angles_rad.z) * axis_rotation({0, 1, 0}, angles_rad.y) *
           axis_rotation({1, 0, 0}, angles_rad.x);
}

}  // namespace bsoil::scene
