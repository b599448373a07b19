/// From Bullet's collision shapes to solids in the body's frame.
#pragma once

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <cstdint>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/result.h"
#include "grid_ball.h"

namespace bsoil::bullet {

/// The solids a shape consists of. Collision margins are kept as Bullet keeps them: inside the
/// extents of a box and a cylinder, equal to the radius of a sphere and a capsule, added outside of
/// a cone and a convex hull (ConvexShape::rounding_m) and of triangles. A multi-sphere is, as in
/// Bullet, the hull of its spheres; a Minkowski sum is the set {a - b}. These, and custom convex
/// shapes, are polyhedra where they have at most limits::kHullPlaneCapacity faces; else lattices
/// (DistanceLattice) of a polyhedron within 0.05 % of their radius, whose edges the lattice rounds
/// by up to a quarter of a voxel. Where they are smaller than two voxels, and a hull with more
/// faces than that always, a polyhedron of at most 252 faces that touch the shape: it contains the
/// shape and exceeds it by less than 3 % of its radius. Meshes, heightfields and distance fields
/// become lattices, see mesh_conversion.h. Of what is cut to the grid and lies beside it there are
/// none. The error names the shape and what is wrong: a type without a solid (empty,
/// two-dimensional, soft), an extent that is zero, negative or not finite, a hull without volume, a
/// broken mesh.
Result<std::vector<ConvexShape>> convert_shape(const btCollisionShape& shape, const GridBall& grid);

/// Changes whenever the result of convert_shape does, with two exceptions. It misses a change of a
/// hull's points that keeps their number, its box and its first and last point. It misses single
/// corners of a mesh or heightfield with more than 20,000 of them. Walks compounds and up to 20,000
/// corners and indices of each mesh (some 0.1 ms), not the points of hulls.
uint64_t shape_fingerprint(const btCollisionShape& shape, const GridBall& grid);

}  // namespace bsoil::bullet
