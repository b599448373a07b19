/// The convex hull of a point cloud.
#pragma once

#include <vector>

#include "bsoil/soil_def.h"

namespace bsoil::scene {

struct ConvexHull {
    TriangleMesh surface;  ///< outward, empty where the points are too few or in one plane
    double volume_m3 = 0;
};

ConvexHull convex_hull(const std::vector<Vec3>& points);

}  // namespace bsoil::scene
