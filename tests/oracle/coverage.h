/// Step 1 of Algorithm 1: how much of a voxel a convex shape covers.
#pragma once

#include "oracle/field.h"

namespace oracle {

/// Whether a point in the shape's own frame (lengths in voxels) lies in it. Rounding moves every
/// face out by as much, so that the edges of a rounded box stay sharp: that is how the soil reads
/// ConvexShape::rounding_m.
bool inside_shape(const bsoil::ConvexShape& shape, Vec3 point);

/// Share of 16 x 16 x 16 points of the voxel (x, y, z) that lie in the shape; `grid_to_shape` in
/// voxels.
double coverage(const bsoil::ConvexShape& shape, const bsoil::Pose& grid_to_shape, int x, int y,
                int z);

}  // namespace oracle
