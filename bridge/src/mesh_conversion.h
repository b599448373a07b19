/// From Bullet's triangle meshes, heightfields and distance fields to solids. What they have in
/// common: they become lattices of distances.
#pragma once

#include <BulletCollision/CollisionShapes/btCollisionShape.h>
#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>

#include <functional>
#include <vector>

#include "fingerprint.h"
#include "grid_ball.h"
#include "shape_facts.h"

namespace bsoil::bullet {

/// Whether convert_mesh knows the shape: btBvhTriangleMeshShape (also with materials), the scaled
/// one, btGImpactMeshShape and its parts, btHeightfieldTerrainShape, btSdfCollisionShape.
bool is_mesh(const btCollisionShape& shape);

/// The solid of such a shape. Closed parts of a mesh are solid, open ones plates (see
/// DistanceLattice::from_mesh); a heightfield is solid from its surface down; a distance field
/// where it is negative, within its own box. Margins as Bullet's triangles have them; that of a
/// distance field does not count in Bullet either. None where nothing of a shape that is cut to the
/// grid lies there. Errors say what is wrong, without the shape's name.
Result<Shapes> convert_mesh(const btCollisionShape& shape, const GridBall& grid);

/// The solid where a distance is negative (see DistanceLattice::from_distance), of a shape that is
/// cut to the grid as meshes are.
Result<Shapes> convert_distance(const btCollisionShape& shape,
                                const std::function<double(Vec3)>& distance_m, const Aabb& bounds,
                                const GridBall& grid);

/// A triangle, scaled about the origin, as a plate of its margin.
Result<Shapes> convert_triangle(const btVector3* corners, double margin_m, double scale,
                                const GridBall& grid);

/// The corners that a mesh's triangles use, scaled. Error: an index out of range, an unknown type.
Result<std::vector<btVector3>> mesh_points(const btStridingMeshInterface& mesh,
                                           const btVector3& scaling);

/// Adds what the result of convert_mesh depends on: all of the corners and indices of a mesh with
/// up to 20,000 of either, else 20,000 of them, evenly spread.
void add_mesh(Fingerprint& print, const btCollisionShape& shape, const GridBall& grid);
void add_mesh(Fingerprint& print, const btStridingMeshInterface& mesh);

/// Adds what a lattice depends on besides the solid: its box, the voxels and, where it is cut, the
/// grid.
void add_grid(Fingerprint& print, const btCollisionShape& shape, const GridBall& grid);

}  // namespace bsoil::bullet
