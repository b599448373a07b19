/// From shapes known by their corners, or by their farthest points, to polyhedra.
#pragma once

#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>

#include "grid_ball.h"
#include "shape_facts.h"

namespace bsoil::bullet {

/// What each becomes: convert_shape() of shape_conversion.h.
/// @{
Result<Shapes> convex_hull(const btConvexHullShape& shape);
Result<Shapes> point_cloud(const btConvexPointCloudShape& shape);
Result<Shapes> polyhedron(const btPolyhedralConvexShape& shape);
Result<Shapes> convex_mesh(const btConvexTriangleMeshShape& shape);
Result<Shapes> multi_sphere(const btMultiSphereShape& shape, const GridBall& grid);
/// @}
/// Any convex shape, by what it answers for its farthest point along a direction.
Result<Shapes> support_solid(const btConvexShape& shape, const GridBall& grid);

/// Convex shapes known by their support alone.
bool is_support_shape(const btCollisionShape& shape);
/// Whether support_solid() makes it, by itself or scaled: it may become a lattice, and be cut.
bool has_support_solid(const btCollisionShape& shape);

/// Points on such a shape that are looked at.
inline constexpr int kSphereDirectionCount = 600;
/// Directions spread evenly over the sphere (a Fibonacci lattice).
Vec3 sphere_direction(int index);

}  // namespace bsoil::bullet
