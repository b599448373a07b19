/// A concave mesh as a union of convex solids.
#pragma once

#include <vector>

#include "convex_hull.h"

namespace bsoil::scene {

/// The hull of each connected component of a mesh (vertices closer than a millionth of the mesh's
/// size are one), largest first. Components that lie inside another one's hull, and flat ones, are
/// left out.
std::vector<ConvexHull> component_hulls(const TriangleMesh& mesh);

/// Cuts a closed mesh with planes until the hulls of the pieces hold at most 3 % more than the mesh
/// does, or there are `part_capacity` of them. The planes are those of the mesh's own faces, where
/// they serve: a bucket falls into its plates. Splinters below a ten-thousandth of the whole are
/// left out. A mesh with holes is cut too, with more or fewer pieces than it needs. Cost: half a
/// second for 1000 triangles and 40 pieces.
std::vector<ConvexHull> convex_parts(const TriangleMesh& mesh, int part_capacity);

/// Makes a solid that is thinner than `thickness_m` in some direction so thick, on the side away
/// from `middle_m`. Plates grow outwards, what they enclose keeps its volume.
ConvexHull thickened(const ConvexHull& hull, double thickness_m, Vec3 middle_m);

/// Volume [m3] of a closed mesh with outward triangles.
double mesh_volume_m3(const TriangleMesh& mesh);

}  // namespace bsoil::scene
