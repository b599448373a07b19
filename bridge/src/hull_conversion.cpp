#include "hull_conversion.h"

#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>

#include <algorithm>
#include <numbers>

#include "bsoil/limits.h"
#include "convex_solid.h"
#include "mesh_conversion.h"

namespace bsoil::bullet {
namespace {

/// A hull of this many points has at most 2 n - 4 = 252 faces, within limits::kHullPlaneCapacity.
constexpr int kSpreadPointCount = 128;
/// A solid that planes do not make is known to this share of its radius.
constexpr double kSolidGap = 1e-3;
/// Smaller than this, a lattice's spacing costs more than the 3 % of a touching hull.
constexpr double kSmallSolidVoxels = 2;
/// A hull thinner than this fraction of its width has no inside a voxel could find.
constexpr double kFlatHullFraction = 1e-5;

/// The points of a set that lie farthest from each other, greedily.
std::vector<btVector3> spread_points(const std::vector<btVector3>& points, int count) {
    std::vector<btVector3> out{points.front()};
    std::vector<btScalar> distance2(points.size(), BT_LARGE_FLOAT);
    while (static_cast<int>(out.size()) < count) {
        for (size_t i = 0; i < points.size(); ++i) {
            distance2[i] = std::min(distance2[i], points[i].distance2(out.back()));
        }
        const auto farthest = std::max_element(distance2.begin(), distance2.end());
        if (*farthest <= 0) break;
        out.push_back(points[static_cast<size_t>(farthest - distance2.begin())]);
    }
    return out;
}

/// The hull of a solid with the given points on its surface, as half spaces that touch it: exact
/// for a polyhedron of few faces, else an enclosing solid whose faces are those of a well-spread
/// choice of the points. `support(n)` is the largest n . p of the solid.
template <typename Support>
ConvexShape touching_hull(const std::vector<btVector3>& points, const Support& support) {
    Vec3 center;
    for (const btVector3& p : points) center += from_bullet(p);
    center = center * (1.0 / static_cast<double>(points.size()));
    ConvexShape out = of_kind(ConvexShape::Kind::hull);
    out.local.position = center;
    for (const btVector3& p : points) {
        out.bound_m = std::max(out.bound_m, length(from_bullet(p) - center));
    }
    std::vector<Plane> faces = hull_faces(points, out.bound_m);
    if (faces.size() > static_cast<size_t>(limits::kHullPlaneCapacity)) {
        faces = hull_faces(spread_points(points, kSpreadPointCount), out.bound_m);
    }
    for (const Plane& face : faces) {
        out.planes.push_back({face.normal, support(face.normal) - dot(face.normal, center)});
    }
    return out;
}

/// The same; error: the points span no volume.
template <typename Support>
Result<Shapes> touching_hull_or_error(const btCollisionShape& shape,
                                      const std::vector<btVector3>& points,
                                      const Support& support) {
    ConvexShape out = touching_hull(points, support);
    const bool is_flat = std::any_of(out.planes.begin(), out.planes.end(), [&](const Plane& plane) {
        const double width =
            plane.offset + support(-plane.normal) + dot(plane.normal, out.local.position);
        return width < kFlatHullFraction * out.bound_m;
    });
    if (out.planes.size() < 4 || is_flat) {
        return Error{shape_name(shape) +
                     ": its points span no volume; make it a thin box, or a mesh"};
    }
    return Shapes{out};
}

Result<Shapes> hull(const btCollisionShape& shape, const std::vector<btVector3>& points,
                    double margin_m) {
    if (points.empty()) {
        return Error{shape_name(shape) +
                     ": has no points; add them before the body joins the world"};
    }
    for (const btVector3& p : points) {
        if (!is_finite(from_bullet(p))) {
            return Error{shape_name(shape) +
                         ": has a point that is not finite; look for a division by zero "
                         "where it was made"};
        }
    }
    if (const Status s = check_margin(shape, margin_m); !s) return Error{s.error()};

    const auto support = [&points](Vec3 n) {
        double most = -std::numeric_limits<double>::infinity();
        for (const btVector3& p : points) most = std::max(most, dot(n, from_bullet(p)));
        return most;
    };
    Result<Shapes> out = touching_hull_or_error(shape, points, support);
    if (out) out->front().rounding_m = margin_m;
    return out;
}

}  // namespace

Result<Shapes> convex_hull(const btConvexHullShape& shape) {
    std::vector<btVector3> points;
    for (int i = 0; i < shape.getNumPoints(); ++i) points.push_back(shape.getScaledPoint(i));
    return hull(shape, points, static_cast<double>(shape.getMargin()));
}

Result<Shapes> point_cloud(const btConvexPointCloudShape& shape) {
    std::vector<btVector3> points;
    for (int i = 0; i < shape.getNumPoints(); ++i) points.push_back(shape.getScaledPoint(i));
    return hull(shape, points, static_cast<double>(shape.getMargin()));
}

Result<Shapes> polyhedron(const btPolyhedralConvexShape& shape) {
    std::vector<btVector3> points(static_cast<size_t>(shape.getNumVertices()));
    for (size_t i = 0; i < points.size(); ++i) shape.getVertex(static_cast<int>(i), points[i]);
    return hull(shape, points, static_cast<double>(shape.getMargin()));
}

Result<Shapes> convex_mesh(const btConvexTriangleMeshShape& shape) {
    const Result<std::vector<btVector3>> points =
        mesh_points(*shape.getMeshInterface(), shape.getLocalScaling());
    if (!points) return Error{shape_name(shape) + ": " + points.error()};
    return hull(shape, *points, static_cast<double>(shape.getMargin()));
}

Vec3 sphere_direction(int index) {
    const double z = 1 - (2.0 * index + 1) / kSphereDirectionCount;
    const double r = std::sqrt(1 - z * z);
    const double angle = index * std::numbers::pi * (3 - std::sqrt(5.0));
    return {r * std::cos(angle), r * std::sin(angle), z};
}

Result<Shapes> support_solid(const btConvexShape& shape, const GridBall& grid) {
    if (const Status s = check_margin(shape, static_cast<double>(shape.getMargin())); !s) {
        return Error{s.error()};
    }
    const auto touch = [&shape](Vec3 n) { return shape.localGetSupportingVertex(to_bullet(n)); };
    std::vector<btVector3> points;
    for (int i = 0; i < kSphereDirectionCount; ++i) {
        points.push_back(touch(sphere_direction(i)));
        if (!is_finite(from_bullet(points.back()))) {
            return Error{shape_name(shape) +
                         ": reaches infinitely far; cut it to the world's size"};
        }
    }
    Result<Shapes> hull = touching_hull_or_error(
        shape, points, [&](Vec3 n) { return dot(n, from_bullet(touch(n))); });
    if (!hull) return hull;
    const double bound_m = hull->front().bound_m;
    const std::vector<Plane> faces = faces_within(kSolidGap * bound_m, points, bound_m, touch);
    if (faces.size() <= static_cast<size_t>(limits::kHullPlaneCapacity)) {
        ConvexShape& exact = hull->front();
        exact.planes.clear();
        for (const Plane& face : faces) {
            exact.planes.push_back(
                {face.normal, face.offset - dot(face.normal, exact.local.position)});
        }
        return hull;
    }
    if (bound_m < kSmallSolidVoxels * grid.voxel_m) return hull;
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    PolyhedronDistance distance_m(faces, grid.voxel_m);
    return named(shape, convert_distance(
                            shape, [&](Vec3 p) { return distance_m(p); },
                            {from_bullet(low), from_bullet(high)}, grid));
}

Result<Shapes> multi_sphere(const btMultiSphereShape& shape, const GridBall& grid) {
    for (int i = 0; i < shape.getSphereCount(); ++i) {
        if (!is_finite(from_bullet(shape.getSpherePosition(i)))) {
            return Error{shape_name(shape) +
                         ": has a sphere whose centre is not finite; look for a "
                         "division by zero where it was made"};
        }
        if (const Status s =
                check_extent(shape, "radius", static_cast<double>(shape.getSphereRadius(i)));
            !s) {
            return Error{s.error()};
        }
    }
    return support_solid(shape, grid);
}

bool is_support_shape(const btCollisionShape& shape) {
    const int type = shape.getShapeType();
    return type == MINKOWSKI_SUM_SHAPE_PROXYTYPE || type == MINKOWSKI_DIFFERENCE_SHAPE_PROXYTYPE ||
           type == CUSTOM_CONVEX_SHAPE_TYPE || type == CONVEX_SHAPE_PROXYTYPE;
}

bool has_support_solid(const btCollisionShape& shape) {
    if (shape.getShapeType() == UNIFORM_SCALING_SHAPE_PROXYTYPE) {
        return has_support_solid(*static_cast<const btUniformScalingShape&>(shape).getChildShape());
    }
    return is_support_shape(shape) || shape.getShapeType() == MULTI_SPHERE_SHAPE_PROXYTYPE;
}

}  // namespace bsoil::bullet
