/// Boxes around shapes, and which shapes are sound.
#pragma once

#include "bsoil/body.h"

namespace bsoil {

/// Axis-aligned box, in voxels of the grid, around a shape of a body at `body_to_grid` (metres).
Aabb shape_bounds(const ConvexShape& shape, const Pose& body_to_grid, double voxel_m);

/// False for zero-size, inverted, unbounded and NaN shapes.
bool is_valid_shape(const ConvexShape& shape);

/// Whether a point of the shape's frame lies inside.
bool contains(const ConvexShape& shape, Vec3 point);

/// The box around both.
Aabb merge(const Aabb& a, const Aabb& b);

/// The whole number below a value, within low..high.
int clamped_floor(double value, int low, int high);

}  // namespace bsoil
