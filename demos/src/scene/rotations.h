/// Rotations as people write them.
#pragma once

#include <numbers>

#include "bsoil/geometry.h"

namespace bsoil::scene {

inline constexpr double kDegree = std::numbers::pi / 180;

/// A turn by `angle_rad` about `axis`, which need not be a unit vector.
Quat axis_rotation(Vec3 axis, double angle_rad);
/// Turns about the fixed axes x, then y, then z (roll, pitch, yaw as in URDF).
Quat fixed_axes_rotation(Vec3 angles_rad);

}  // namespace bsoil::scene
