#include "contact/wall_thickness.h"

#include <algorithm>
#include <cmath>

#include "bsoil/limits.h"

namespace bsoil {
namespace {

/// Two faces of a hull no further from parallel than this cosine are those of a sheet. Ours: 10
/// deg, the taper of cast and bent plate. Larger: tapered plates leak; smaller: wedges are
/// thickened.
constexpr double kParallelCosine = 0.985;
/// A second thin direction further than this cosine from the first makes a bar of it. Ours: 60 deg,
/// as edges of a bar are square to each other. Larger: bars pass for sheets and get wider.
constexpr double kAcrossCosine = 0.5;

SheetGrowth thin_along(Vec3 normal, double thickness_m, double wall_m) {
    return thickness_m < wall_m ? SheetGrowth{normal, thickness_m, wall_m - thickness_m}
                                : SheetGrowth{};
}

SheetGrowth box_growth(const ConvexShape& box, double wall_m) {
    const Vec3 half = box.half_extents_m;
    const double width[3] = {2 * (half.x + box.rounding_m), 2 * (half.y + box.rounding_m),
                             2 * (half.z + box.rounding_m)};
    const auto thin = std::min_element(width, width + 3) - width;
    if (width[(thin + 1) % 3] < wall_m || width[(thin + 2) % 3] < wall_m) return {};
    constexpr Vec3 kAxes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    return thin_along(kAxes[thin], width[thin], wall_m);
}

SheetGrowth hull_growth(const ConvexShape& hull, double wall_m) {
    SheetGrowth found;
    for (size_t i = 0; i < hull.planes.size(); ++i) {
        for (size_t j = i + 1; j < hull.planes.size(); ++j) {
            const Plane &a = hull.planes[i], &b = hull.planes[j];
            if (dot(a.normal, b.normal) > -kParallelCosine) continue;
            const double thickness = std::max(0.0, a.offset + b.offset) + 2 * hull.rounding_m;
            if (thickness >= wall_m) continue;
            if (found.is_thin() && std::abs(dot(found.normal, a.normal)) < kAcrossCosine) {
                return {};  // thin along two axes
            }
            if (!found.is_thin() || thickness < found.thickness_m) {
                found = thin_along(a.normal, thickness, wall_m);
            }
        }
    }
    return found;
}

}  // namespace

SheetGrowth sheet_growth(const ConvexShape& shape, double voxel_m) {
    const double wall_m = limits::kThinnestWallVoxels * voxel_m;
    switch (shape.kind) {
        case ConvexShape::Kind::box:
            return box_growth(shape, wall_m);
        case ConvexShape::Kind::cylinder:
            return 2 * (shape.radius_m + shape.rounding_m) < wall_m
                       ? SheetGrowth{}
                       : thin_along({0, 0, 1}, 2 * (shape.half_height_m + shape.rounding_m),
                                    wall_m);
        case ConvexShape::Kind::hull:
            return hull_growth(shape, wall_m);
        case ConvexShape::Kind::sphere:
        case ConvexShape::Kind::capsule:
        case ConvexShape::Kind::cone:
        case ConvexShape::Kind::lattice:  // has been given its walls when it was made
            return {};
    }
    return {};
}

ConvexShape thickened(ConvexShape shape, const SheetGrowth& growth) {
    const double face_m = growth.growth_m / 2;
    if (shape.kind == ConvexShape::Kind::box) {
        shape.half_extents_m += face_m * growth.normal;
    } else if (shape.kind == ConvexShape::Kind::cylinder) {
        shape.half_height_m += face_m;
    } else if (shape.kind == ConvexShape::Kind::hull && growth.is_thin()) {
        for (Plane& plane : shape.planes) {
            if (std::abs(dot(plane.normal, growth.normal)) >= kParallelCosine) {
                plane.offset += face_m;
            }
        }
        shape.bound_m += growth.growth_m;  // corners move along faces that are not upright
    }
    return shape;
}

void WallShapes::make(const std::vector<ConvexShape>& body_shapes, double voxel_m) {
    growth.clear();
    for (const ConvexShape& shape : body_shapes) growth.push_back(sheet_growth(shape, voxel_m));
    shapes.clear();
    if (std::any_of(growth.begin(), growth.end(),
                    [](const SheetGrowth& g) { return g.is_thin(); })) {
        for (size_t i = 0; i < body_shapes.size(); ++i) {
            shapes.push_back(thickened(body_shapes[i], growth[i]));
        }
    }
}

}  // namespace bsoil
