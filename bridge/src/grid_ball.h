/// GridBall: how much of a shape without bounds counts.
#pragma once

#include "bsoil/geometry.h"

namespace bsoil::bullet {

/// A ball in the body's frame that holds the soil's whole grid, and the edge of the grid's voxels.
/// A shape without bounds, or larger than the ball, is cut to it.
struct GridBall {
    Vec3 center_m;
    double radius_m = 1;
    double voxel_m = 0.05;
};

}  // namespace bsoil::bullet
