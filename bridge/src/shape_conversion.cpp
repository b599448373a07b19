#include "shape_conversion.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "hull_conversion.h"
#include "mesh_conversion.h"
#include "shape_facts.h"

namespace bsoil::bullet {
namespace {

/// Half the diagonal of a grid is this much longer in the ball an unbounded shape is cut to.
constexpr double kPlaneBoxSlack = 1.01;
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

Result<Shapes> box(const btBoxShape& shape) {
    ConvexShape out = of_kind(ConvexShape::Kind::box);
    out.half_extents_m = from_bullet(shape.getHalfExtentsWithMargin());
    for (const auto& [field, metres] : {std::pair{"half extent x", out.half_extents_m.x},
                                        std::pair{"half extent y", out.half_extents_m.y},
                                        std::pair{"half extent z", out.half_extents_m.z}}) {
        if (const Status s = check_extent(shape, field, metres); !s) return Error{s.error()};
    }
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
    if (const Status s = check_extent(shape, "half height", out.half_height_m, 0); !s) {
        return Error{s.error()};
    }
    return Shapes{out};
}

Result<Shapes> cylinder(const btCylinderShape& shape) {
    ConvexShape out = of_kind(ConvexShape::Kind::cylinder);
    const int up = shape.getUpAxis();
    out.local.rotation = from_z_to_axis(up);
    out.radius_m = static_cast<double>(shape.getRadius());
    out.half_height_m = static_cast<double>(shape.getHalfExtentsWithMargin()[up]);
    if (const Status s = check_extent(shape, "radius", out.radius_m); !s) return Error{s.error()};
    if (const Status s = check_extent(shape, "half height", out.half_height_m); !s) {
        return Error{s.error()};
    }
    return Shapes{out};
}

Result<Shapes> cone(const btConeShape& shape) {
    ConvexShape out = of_kind(ConvexShape::Kind::cone);
    out.local.rotation = from_z_to_axis(shape.getConeUpIndex());
    out.radius_m = static_cast<double>(shape.getRadius());
    out.half_height_m = static_cast<double>(shape.getHeight()) / 2;
    out.rounding_m = static_cast<double>(shape.getMargin());
    if (const Status s = check_extent(shape, "radius", out.radius_m); !s) return Error{s.error()};
    if (const Status s = check_extent(shape, "half height", out.half_height_m); !s) {
        return Error{s.error()};
    }
    if (const Status s = check_margin(shape, out.rounding_m); !s) return Error{s.error()};
    return Shapes{out};
}

Result<Shapes> triangle(const btTriangleShape& shape, double scale, const GridBall& grid) {
    return named(shape, convert_triangle(shape.m_vertices1, static_cast<double>(shape.getMargin()),
                                         scale, grid));
}

/// The part of the half space within reach of the grid, as a box whose top is the plane.
Result<Shapes> static_plane(const btStaticPlaneShape& shape, const GridBall& grid) {
    const Vec3 normal = from_bullet(shape.getPlaneNormal());
    const double norm = length(normal);
    const double constant = static_cast<double>(shape.getPlaneConstant());
    if (!(std::isfinite(norm) && norm > 0 && std::isfinite(constant))) {
        return Error{shape_name(shape) +
                     ": normal or constant is zero or not finite; give the "
                     "plane a unit normal"};
    }
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
    if (!(std::isfinite(s) && s > 0)) {
        return Error{shape_name(shape) + ": scaling factor is " + std::to_string(s) +
                     ", must be finite and above 0"};
    }
    const btConvexShape& scaled = *shape.getChildShape();
    if (scaled.getShapeType() == TRIANGLE_SHAPE_PROXYTYPE) {
        return triangle(static_cast<const btTriangleShape&>(scaled), s, grid);
    }
    Result<Shapes> child = convert_shape(scaled, grid);
    // How fine it has to be goes by its own size, not the child's.
    if (child && (has_support_solid(scaled) || child->front().kind == ConvexShape::Kind::lattice)) {
        return support_solid(shape, grid);
    }
    if (child) {
        for (ConvexShape& c : *child) scale_about_origin(c, s);
    }
    return child;
}

/// Children of a compound; `child(i)` is the pose and the shape of one.
template <typename Child>
Result<Shapes> union_of(const btCollisionShape& shape, int count, const GridBall& grid,
                        Child&& child) {
    Shapes out;
    for (int i = 0; i < count; ++i) {
        const auto [local, child_shape] = child(i);
        if (!is_rigid(local)) {
            return Error{shape_name(shape) + ": the transform of child " + std::to_string(i) +
                         " is not finite, or no rotation; normalize its quaternion"};
        }
        const GridBall grid_in_child{transform(inverse(local), grid.center_m), grid.radius_m,
                                     grid.voxel_m};
        Result<Shapes> converted = convert_shape(*child_shape, grid_in_child);
        if (!converted) {
            return Error{shape_name(shape) + ", child " + std::to_string(i) + ": " +
                         converted.error()};
        }
        for (ConvexShape& c : *converted) {
            c.local = local * c.local;
            out.push_back(std::move(c));
        }
    }
    if (count == 0) {
        return Error{shape_name(shape) + ": has no children; add one, or ignore the body"};
    }
    return out;
}

Result<Shapes> compound(const btCompoundShape& shape, const GridBall& grid) {
    return union_of(shape, shape.getNumChildShapes(), grid, [&shape](int i) {
        return std::pair(from_bullet(shape.getChildTransform(i)), shape.getChildShape(i));
    });
}

Result<Shapes> gimpact_compound(const btGImpactCompoundShape& shape, const GridBall& grid) {
    return union_of(shape, shape.getNumChildShapes(), grid, [&shape](int i) {
        return std::pair(child_pose(shape, i), shape.getChildShape(i));
    });
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
    if (is_support_shape(shape)) {
        return support_solid(static_cast<const btConvexShape&>(shape), grid);
    }
    if (is_gimpact_compound(shape)) {
        return gimpact_compound(static_cast<const btGImpactCompoundShape&>(shape), grid);
    }
    if (is_mesh(shape)) return named(shape, convert_mesh(shape, grid));
    return Error{shape_name(shape) +
                 ": this type is not supported by the soil; it has no solid, or none that Bullet "
                 "tells; give it a hull or a mesh, or ignore the body"};
}

}  // namespace bsoil::bullet
