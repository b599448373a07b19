/// From Bullet's collision shapes to convex solids in the body's frame.
#pragma once

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <cstdint>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/result.h"

namespace bsoil::bullet {

/// A ball in the body's frame that holds the soil's whole grid. An unbounded shape is cut to it.
struct GridBall {
    Vec3 center_m;
    double radius_m = 1;
};

/// The convex solids a shape consists of. Collision margins are kept as Bullet keeps them: inside
/// the extents of a box and a cylinder, equal to the radius of a sphere and a capsule, added
/// outside of a cone and a convex hull (ConvexShape::rounding_m). A multi-sphere is, as in Bullet,
/// the hull of its spheres. It, and a hull with more faces than limits::kHullPlaneCapacity, becomes
/// a polyhedron of at most 252 faces that touch the shape: it contains the shape and exceeds it by
/// less than 3 % of the largest sphere's radius, or of the hull's radius. The error names the shape
/// and what is wrong: a type without an inside (triangle meshes, heightfields), an extent that is
/// zero, negative or not finite, a hull without volume.
Result<std::vector<ConvexShape>> convert_shape(const btCollisionShape& shape, const GridBall& grid);

/// Changes whenever the result of convert_shape does, up to a change of a hull's points that keeps
/// their number, its box and its first and last point. Cheap: walks compounds, not points.
uint64_t shape_fingerprint(const btCollisionShape& shape, const GridBall& grid);

}  // namespace bsoil::bullet
