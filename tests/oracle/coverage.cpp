#include "oracle/coverage.h"

#include <algorithm>

namespace oracle {

using bsoil::ConvexShape;

bool inside_shape(const ConvexShape& s, Vec3 p) {
    const double grown = s.rounding_m;
    const double from_axis = std::hypot(p.x, p.y);
    switch (s.kind) {
        case ConvexShape::Kind::box:
            return std::abs(p.x) <= s.half_extents_m.x + grown &&
                   std::abs(p.y) <= s.half_extents_m.y + grown &&
                   std::abs(p.z) <= s.half_extents_m.z + grown;
        case ConvexShape::Kind::sphere:
            return length(p) <= s.radius_m + grown;
        case ConvexShape::Kind::capsule: {
            const Vec3 nearest{0, 0, std::clamp(p.z, -s.half_height_m, s.half_height_m)};
            return length(p - nearest) <= s.radius_m + grown;
        }
        case ConvexShape::Kind::cylinder:
            return from_axis <= s.radius_m + grown && std::abs(p.z) <= s.half_height_m + grown;
        case ConvexShape::Kind::cone: {
            // The mantle is the line from (radius, -half height) to the apex (0, half height),
            // moved out by `grown`.
            const double slant = std::hypot(s.radius_m, 2 * s.half_height_m);
            const double beyond_mantle =
                (from_axis * 2 * s.half_height_m + (p.z - s.half_height_m) * s.radius_m) / slant;
            return p.z >= -s.half_height_m - grown && beyond_mantle <= grown;
        }
        case ConvexShape::Kind::hull:
            return std::all_of(s.planes.begin(), s.planes.end(), [&](const bsoil::Plane& plane) {
                return dot(plane.normal, p) - plane.offset <= grown;
            });
        case ConvexShape::Kind::lattice:
            break;  // compared with other shapes, see distance_lattice_test.cpp
    }
    return false;
}

double coverage(const ConvexShape& shape, const bsoil::Pose& grid_to_shape, int x, int y, int z) {
    constexpr int kPoints = 16;
    int count = 0;
    for (int k = 0; k < kPoints; ++k) {
        for (int j = 0; j < kPoints; ++j) {
            for (int i = 0; i < kPoints; ++i) {
                const Vec3 point{x + (i + 0.5) / kPoints, y + (j + 0.5) / kPoints,
                                 z + (k + 0.5) / kPoints};
                count += inside_shape(shape, transform(grid_to_shape, point));
            }
        }
    }
    return static_cast<double>(count) / (kPoints * kPoints * kPoints);
}

}  // namespace oracle
