#include "shape_conversion.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "bsoil/limits.h"
#include "bullet_types.h"
#include "convex_solid.h"
#include "fingerprint.h"
#include "mesh_conversion.h"

namespace bsoil::bullet {
namespace {

/// A hull of this many points has at most 2 n - 4 = 252 faces, within limits::kHullPlaneCapacity.
constexpr int kSpreadPointCount = 128;
/// Points on a multi-sphere from which those are chosen.
constexpr int kSphereDirectionCount = 600;
/// A solid that planes do not make is known to this share of its radius.
constexpr double kSolidGap = 1e-3;
/// Smaller than this, a lattice's spacing costs more than the 3 % of a touching hull.
constexpr double kSmallSolidVoxels = 2;
/// Half the diagonal of a grid is this much longer in the ball an unbounded shape is cut to.
constexpr double kPlaneBoxSlack = 1.01;
/// A hull thinner than this fraction of its width has no inside a voxel could find.
constexpr double kFlatHullFraction = 1e-5;

using Shapes = std::vector<ConvexShape>;

ConvexShape of_kind(ConvexShape::Kind kind) {
    ConvexShape out;
    out.kind = kind;
    return out;
}

/// Rotation that takes the local z axis to the given axis of Bullet's frame (0, 1, 2 = X, Y, Z).
Quat from_z_to_axis(int axis) {
    const double h = std::numbers::sqrt2 / 2;
    if (axis == 0) return {0, h, 0, h};
    if (axis == 1) return {-h, 0, 0, h};
    return {};
}

/// Rotation that takes the local z axis to a unit vector.
Quat from_z_to(Vec3 n) {
    if (n.z < -1 + 1e-12) return {1, 0, 0, 0};
    const Quat q{-n.y, n.x, 0, 1 + n.z};
    const double s = 1 / std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return {q.x * s, q.y * s, q.z * s, q.w * s};
}

std::string shape_name(const btCollisionShape& shape) {
    return std::string("shape '") + shape.getName() + "'";
}

Status check_extent(const btCollisionShape& shape, const char* field, double metres,
                    double smallest_m = std::numeric_limits<double>::min()) {
    if (std::isfinite(metres) && metres >= smallest_m) return Done{};
    return Error{shape_name(shape) + ": " + field + " is " + std::to_string(metres) +
                 " m, must be finite and above 0"};
}

Status check_margin(const btCollisionShape& shape, double metres) {
    if (std::isfinite(metres) && metres >= 0) return Done{};
    return Error{shape_name(shape) + ": margin is " + std::to_string(metres) +
                 " m, must be finite and not negative"};
}

Result<Shapes> box(const btBoxShape& shape) {
    ConvexShape out = of_kind(ConvexShape::Kind::box);
    out.half_extents_m = from_bullet(shape.getHalfExtentsWithMargin());
    for (const auto& [field, metres] : {std::pair{"half extent x", out.half_extents_m.x},
                                        std::pair{"half extent y", out.half_extents_m.y},
                                        std::pair{"half extent z", out.half_extents_m.z}})
        if (const Status s = check_extent(shape, field, metres); !s) return Error{s.error()};
    return Shapes{out};
}

Result<Shapes> sphere(const btSphereShape& shape) {
    ConvexShape out = of_kind(ConvexShape::Kind::sphere);
    out.radius_m = static_cast<double>(shape.getRadius());
    if (const Status s = check_extent(shape, "radius", out.radius_m); !s) return Error{s.error()};
    return Shapes{out};
}

Result<Shapes> capsule(const btCapsuleShape& shape) {
    ConvexShape out = of_kind(ConvexShape::Kind::capsule);
    out.local.rotation = from_z_to_axis(shape.getUpAxis());
    out.radius_m = static_cast<double>(shape.getRadius());
    out.half_height_m = static_cast<double>(shape.getHalfHeight());
    if (const Status s = check_extent(shape, "radius", out.radius_m); !s) return Error{s.error()};
    // A capsule of no length is a sphere.
    if (const Status s = check_extent(shape, "half height", out.half_height_m, 0); !s)
        return Error{s.error()};
    return Shapes{out};
}

Result<Shapes> cylinder(const btCylinderShape& shape) {
    ConvexShape out = of_kind(ConvexShape::Kind::cylinder);
    const int up = shape.getUpAxis();
    out.local.rotation = from_z_to_axis(up);
    out.radius_m = static_cast<double>(shape.getRadius());
    out.half_height_m = static_cast<double>(shape.getHalfExtentsWithMargin()[up]);
    if (const Status s = check_extent(shape, "radius", out.radius_m); !s) return Error{s.error()};
    if (const Status s = check_extent(shape, "half height", out.half_height_m); !s)
        return Error{s.error()};
    return Shapes{out};
}

Result<Shapes> cone(const btConeShape& shape) {
    ConvexShape out = of_kind(ConvexShape::Kind::cone);
    out.local.rotation = from_z_to_axis(shape.getConeUpIndex());
    out.radius_m = static_cast<double>(shape.getRadius());
    out.half_height_m = static_cast<double>(shape.getHeight()) / 2;
    out.rounding_m = static_cast<double>(shape.getMargin());
    if (const Status s = check_extent(shape, "radius", out.radius_m); !s) return Error{s.error()};
    if (const Status s = check_extent(shape, "half height", out.half_height_m); !s)
        return Error{s.error()};
    if (const Status s = check_margin(shape, out.rounding_m); !s) return Error{s.error()};
    return Shapes{out};
}

/// The points of a set that lie farthest from each other, greedily.
std::vector<btVector3> spread_points(const std::vector<btVector3>& points, int count) {
    std::vector<btVector3> out{points.front()};
    std::vector<btScalar> distance2(points.size(), BT_LARGE_FLOAT);
    while (static_cast<int>(out.size()) < count) {
        for (size_t i = 0; i < points.size(); ++i)
            distance2[i] = std::min(distance2[i], points[i].distance2(out.back()));
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
    for (const btVector3& p : points)
        out.bound_m = std::max(out.bound_m, length(from_bullet(p) - center));
    std::vector<Plane> faces = hull_faces(points, out.bound_m);
    if (faces.size() > static_cast<size_t>(limits::kHullPlaneCapacity))
        faces = hull_faces(spread_points(points, kSpreadPointCount), out.bound_m);
    for (const Plane& face : faces)
        out.planes.push_back({face.normal, support(face.normal) - dot(face.normal, center)});
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
    if (out.planes.size() < 4 || is_flat)
        return Error{shape_name(shape) + ": its points span no volume"};
    return Shapes{out};
}

Result<Shapes> hull(const btCollisionShape& shape, const std::vector<btVector3>& points,
                    double margin_m) {
    if (points.empty()) return Error{shape_name(shape) + ": has no points"};
    for (const btVector3& p : points)
        if (!is_finite(from_bullet(p)))
            return Error{shape_name(shape) + ": has a point that is not finite"};
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

Result<Shapes> named(const btCollisionShape& shape, Result<ConvexShape>&& converted) {
    if (!converted) return Error{shape_name(shape) + ": " + converted.error()};
    return Shapes{std::move(*converted)};
}

Result<Shapes> triangle(const btTriangleShape& shape, double scale, const GridBall& grid) {
    return named(shape, convert_triangle(shape.m_vertices1, static_cast<double>(shape.getMargin()),
                                         scale, grid));
}

/// Directions spread evenly over the sphere (a Fibonacci lattice).
Vec3 sphere_direction(int index) {
    const double z = 1 - (2.0 * index + 1) / kSphereDirectionCount;
    const double r = std::sqrt(1 - z * z);
    const double angle = index * std::numbers::pi * (3 - std::sqrt(5.0));
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// Any convex shape, by what it answers for its farthest point along a direction.
Result<Shapes> support_solid(const btConvexShape& shape, const GridBall& grid) {
    if (const Status s = check_margin(shape, static_cast<double>(shape.getMargin())); !s)
        return Error{s.error()};
    const auto touch = [&shape](Vec3 n) { return shape.localGetSupportingVertex(to_bullet(n)); };
    std::vector<btVector3> points;
    for (int i = 0; i < kSphereDirectionCount; ++i) {
        points.push_back(touch(sphere_direction(i)));
        if (!is_finite(from_bullet(points.back())))
            return Error{shape_name(shape) + ": reaches infinitely far"};
    }
    Result<Shapes> hull = touching_hull_or_error(
        shape, points, [&](Vec3 n) { return dot(n, from_bullet(touch(n))); });
    if (!hull) return hull;
    const double bound_m = hull->front().bound_m;
    const std::vector<Plane> faces = faces_within(kSolidGap * bound_m, points, bound_m, touch);
    if (faces.size() <= static_cast<size_t>(limits::kHullPlaneCapacity)) {
        ConvexShape& exact = hull->front();
        exact.planes.clear();
        for (const Plane& face : faces)
            exact.planes.push_back(
                {face.normal, face.offset - dot(face.normal, exact.local.position)});
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
        if (!is_finite(from_bullet(shape.getSpherePosition(i))))
            return Error{shape_name(shape) + ": has a sphere whose centre is not finite"};
        if (const Status s =
                check_extent(shape, "radius", static_cast<double>(shape.getSphereRadius(i)));
            !s)
            return Error{s.error()};
    }
    return support_solid(shape, grid);
}

/// The part of the half space within reach of the grid, as a box whose top is the plane.
Result<Shapes> static_plane(const btStaticPlaneShape& shape, const GridBall& grid) {
    const Vec3 normal = from_bullet(shape.getPlaneNormal());
    const double norm = length(normal);
    const double constant = static_cast<double>(shape.getPlaneConstant());
    if (!(std::isfinite(norm) && norm > 0 && std::isfinite(constant)))
        return Error{shape_name(shape) + ": normal or constant is zero or not finite"};
    const Vec3 n = normal * (1 / norm);
    const double radius = kPlaneBoxSlack * grid.radius_m;
    const double above = dot(n, grid.center_m) - constant;
    // Below the plane the box reaches as deep as the ball does, and is never thinner than a tenth
    // of it.
    const double half_depth = 0.5 * std::max(radius - above, 0.1 * radius);
    ConvexShape out = of_kind(ConvexShape::Kind::box);
    out.half_extents_m = {radius, radius, half_depth};
    out.local = {grid.center_m - (above + half_depth) * n, from_z_to(n)};
    return Shapes{out};
}

void scale_about_origin(ConvexShape& shape, double s) {
    shape.local.position = shape.local.position * s;
    shape.half_extents_m = shape.half_extents_m * s;
    shape.radius_m *= s;
    shape.half_height_m *= s;
    for (Plane& p : shape.planes) p.offset *= s;
    shape.bound_m *= s;
    shape.rounding_m *= s;
}

Result<Shapes> uniform_scaling(const btUniformScalingShape& shape, const GridBall& grid) {
    const double s = static_cast<double>(shape.getUniformScalingFactor());
    if (!(std::isfinite(s) && s > 0))
        return Error{shape_name(shape) + ": scaling factor is " + std::to_string(s) +
                     ", must be finite and above 0"};
    const btConvexShape& scaled = *shape.getChildShape();
    if (scaled.getShapeType() == TRIANGLE_SHAPE_PROXYTYPE)
        return triangle(static_cast<const btTriangleShape&>(scaled), s, grid);
    Result<Shapes> child = convert_shape(scaled, grid);
    if (child && child->front().kind == ConvexShape::Kind::lattice)
        return support_solid(shape, grid);
    if (child)
        for (ConvexShape& c : *child) scale_about_origin(c, s);
    return child;
}

/// Children of a compound; `child(i)` is the pose and the shape of one.
template <typename Child>
Result<Shapes> union_of(const btCollisionShape& shape, int count, const GridBall& grid,
                        Child&& child) {
    Shapes out;
    for (int i = 0; i < count; ++i) {
        const auto [local, child_shape] = child(i);
        if (!is_finite(local))
            return Error{shape_name(shape) + ": the transform of child " + std::to_string(i) +
                         " is not finite"};
        const GridBall grid_in_child{transform(inverse(local), grid.center_m), grid.radius_m,
                                     grid.voxel_m};
        Result<Shapes> converted = convert_shape(*child_shape, grid_in_child);
        if (!converted)
            return Error{shape_name(shape) + ", child " + std::to_string(i) + ": " +
                         converted.error()};
        for (ConvexShape& c : *converted) {
            c.local = local * c.local;
            out.push_back(std::move(c));
        }
    }
    if (out.empty()) return Error{shape_name(shape) + ": has no children"};
    return out;
}

Result<Shapes> compound(const btCompoundShape& shape, const GridBall& grid) {
    return union_of(shape, shape.getNumChildShapes(), grid, [&shape](int i) {
        return std::pair(from_bullet(shape.getChildTransform(i)), shape.getChildShape(i));
    });
}

bool is_gimpact_compound(const btCollisionShape& shape) {
    return shape.getShapeType() == GIMPACT_SHAPE_PROXYTYPE &&
           static_cast<const btGImpactShapeInterface&>(shape).getGImpactShapeType() ==
               CONST_GIMPACT_COMPOUND_SHAPE;
}

Pose child_pose(const btGImpactCompoundShape& shape, int child) {
    return shape.childrenHasTransform() ? from_bullet(shape.getChildTransform(child)) : Pose{};
}

Result<Shapes> gimpact_compound(const btGImpactCompoundShape& shape, const GridBall& grid) {
    return union_of(shape, shape.getNumChildShapes(), grid, [&shape](int i) {
        return std::pair(child_pose(shape, i), shape.getChildShape(i));
    });
}

/// Convex shapes known by their support alone.
bool is_support_shape(const btCollisionShape& shape) {
    const int type = shape.getShapeType();
    return type == MINKOWSKI_SUM_SHAPE_PROXYTYPE || type == MINKOWSKI_DIFFERENCE_SHAPE_PROXYTYPE ||
           type == CUSTOM_CONVEX_SHAPE_TYPE || type == CONVEX_SHAPE_PROXYTYPE;
}

template <typename PointShape>
void add_points(Fingerprint& print, const PointShape& shape) {
    const int count = shape.getNumPoints();
    print.add(static_cast<uint64_t>(count));
    if (count == 0) return;
    print.add(shape.getScaledPoint(0));
    print.add(shape.getScaledPoint(count - 1));
}

void add_shape(Fingerprint& print, const btCollisionShape& shape, const GridBall& grid) {
    const int type = shape.getShapeType();
    print.add(static_cast<uint64_t>(type));
    if (type == STATIC_PLANE_PROXYTYPE) {
        const auto& plane = static_cast<const btStaticPlaneShape&>(shape);
        print.add(plane.getPlaneNormal());
        print.add(static_cast<double>(plane.getPlaneConstant()));
        print.add(grid.center_m);
        print.add(grid.radius_m);
        return;
    }
    if (type == COMPOUND_SHAPE_PROXYTYPE) {
        const auto& compound = static_cast<const btCompoundShape&>(shape);
        for (int i = 0; i < compound.getNumChildShapes(); ++i) {
            const btTransform& local = compound.getChildTransform(i);
            print.add(local.getOrigin());
            for (int row = 0; row < 3; ++row) print.add(local.getBasis()[row]);
            const Vec3 center = transform(inverse(from_bullet(local)), grid.center_m);
            add_shape(print, *compound.getChildShape(i), {center, grid.radius_m, grid.voxel_m});
        }
        return;
    }
    if (type == UNIFORM_SCALING_SHAPE_PROXYTYPE) {
        const auto& scaled = static_cast<const btUniformScalingShape&>(shape);
        print.add(static_cast<double>(scaled.getUniformScalingFactor()));
        add_shape(print, *scaled.getChildShape(), grid);
        return;
    }
    if (is_mesh(shape)) {
        add_mesh(print, shape, grid);
        return;
    }
    if (is_gimpact_compound(shape)) {
        const auto& compound = static_cast<const btGImpactCompoundShape&>(shape);
        for (int i = 0; i < compound.getNumChildShapes(); ++i) {
            const Pose local = child_pose(compound, i);
            print.add(local.position);
            print.add(local.rotation.x);
            print.add(local.rotation.y);
            print.add(local.rotation.z);
            print.add(local.rotation.w);
            add_shape(print, *compound.getChildShape(i), grid);
        }
        return;
    }
    if (!shape.isConvex()) return;  // refused whatever its dimensions are
    if (type == TRIANGLE_SHAPE_PROXYTYPE || type == TETRAHEDRAL_SHAPE_PROXYTYPE ||
        type == CUSTOM_POLYHEDRAL_SHAPE_TYPE) {
        const auto& polyhedron = static_cast<const btPolyhedralConvexShape&>(shape);
        for (int i = 0; i < polyhedron.getNumVertices(); ++i) {
            btVector3 vertex;
            polyhedron.getVertex(i, vertex);
            print.add(vertex);
        }
        print.add(grid.voxel_m);
    }
    if (type == CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE)
        add_mesh(print, *static_cast<const btConvexTriangleMeshShape&>(shape).getMeshInterface());
    if (is_support_shape(shape) || type == MULTI_SPHERE_SHAPE_PROXYTYPE)
        add_grid(print, shape, grid);
    if (is_support_shape(shape)) {
        const auto& convex = static_cast<const btConvexShape&>(shape);
        for (int i = 0; i < kSphereDirectionCount; i += kSphereDirectionCount / 50)
            print.add(convex.localGetSupportingVertex(to_bullet(sphere_direction(i))));
    }
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    print.add(low);
    print.add(high);
    print.add(shape.getLocalScaling());
    print.add(static_cast<double>(shape.getMargin()));
    if (type == CONVEX_HULL_SHAPE_PROXYTYPE)
        add_points(print, static_cast<const btConvexHullShape&>(shape));
    if (type == CONVEX_POINT_CLOUD_SHAPE_PROXYTYPE)
        add_points(print, static_cast<const btConvexPointCloudShape&>(shape));
}

}  // namespace

Result<Shapes> convert_shape(const btCollisionShape& shape, const GridBall& grid) {
    switch (shape.getShapeType()) {
        case BOX_SHAPE_PROXYTYPE:
            return box(static_cast<const btBoxShape&>(shape));
        case SPHERE_SHAPE_PROXYTYPE:
            return sphere(static_cast<const btSphereShape&>(shape));
        case CAPSULE_SHAPE_PROXYTYPE:
            return capsule(static_cast<const btCapsuleShape&>(shape));
        case CYLINDER_SHAPE_PROXYTYPE:
            return cylinder(static_cast<const btCylinderShape&>(shape));
        case CONE_SHAPE_PROXYTYPE:
            return cone(static_cast<const btConeShape&>(shape));
        case CONVEX_HULL_SHAPE_PROXYTYPE:
            return convex_hull(static_cast<const btConvexHullShape&>(shape));
        case CONVEX_POINT_CLOUD_SHAPE_PROXYTYPE:
            return point_cloud(static_cast<const btConvexPointCloudShape&>(shape));
        case MULTI_SPHERE_SHAPE_PROXYTYPE:
            return multi_sphere(static_cast<const btMultiSphereShape&>(shape), grid);
        case UNIFORM_SCALING_SHAPE_PROXYTYPE:
            return uniform_scaling(static_cast<const btUniformScalingShape&>(shape), grid);
        case COMPOUND_SHAPE_PROXYTYPE:
            return compound(static_cast<const btCompoundShape&>(shape), grid);
        case STATIC_PLANE_PROXYTYPE:
            return static_plane(static_cast<const btStaticPlaneShape&>(shape), grid);
        case CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE:
            return convex_mesh(static_cast<const btConvexTriangleMeshShape&>(shape));
        case TETRAHEDRAL_SHAPE_PROXYTYPE:
        case CUSTOM_POLYHEDRAL_SHAPE_TYPE:
            return polyhedron(static_cast<const btPolyhedralConvexShape&>(shape));
        case TRIANGLE_SHAPE_PROXYTYPE:
            return triangle(static_cast<const btTriangleShape&>(shape), 1, grid);
        default:
            break;
    }
    if (is_support_shape(shape))
        return support_solid(static_cast<const btConvexShape&>(shape), grid);
    if (is_gimpact_compound(shape))
        return gimpact_compound(static_cast<const btGImpactCompoundShape&>(shape), grid);
    if (is_mesh(shape)) return named(shape, convert_mesh(shape, grid));
    return Error{shape_name(shape) +
                 ": this type is not supported by the soil; it has no solid, or none that Bullet "
                 "tells"};
}

uint64_t shape_fingerprint(const btCollisionShape& shape, const GridBall& grid) {
    Fingerprint print;
    add_shape(print, shape, grid);
    return print.value;
}

}  // namespace bsoil::bullet
