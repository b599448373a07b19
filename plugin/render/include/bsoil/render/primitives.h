/// Meshes of simple solids, for bodies in pictures.
#pragma once

#include <array>
#include <span>

#include "bsoil/body.h"
#include "bsoil/soil_def.h"
#include "bsoil/surface_mesh.h"

#pragma GCC visibility push(default)
namespace bsoil::render {

using Color = std::array<float, 3>;  ///< linear RGB, 0..1

/// Centred at the origin; axes as for ConvexShape: local z. Metres.
/// @{
/// bevel_m: how far edges are cut off at 45 degrees; no more than a third of the thinnest extent
/// is.
Mesh box_mesh(Vec3 half_extents_m, Color color, double bevel_m = 0);
Mesh sphere_mesh(double radius_m, Color color);
Mesh capsule_mesh(double radius_m, double half_height_m, Color color);
Mesh cylinder_mesh(double radius_m, double half_height_m, Color color, double bevel_m = 0);
/// @}
/// Apex at +z.
Mesh cone_mesh(double radius_m, double half_height_m, Color color);
/// Intersection of half spaces. They have to enclose a body, with no point further than `bound_m`
/// from the origin: what reaches further may be left open. Empty when nothing is left.
Mesh hull_mesh(std::span<const Plane> planes, double bound_m, Color color);
/// Flat-shaded triangles.
Mesh triangle_mesh(const TriangleMesh& triangles, Color color);
/// A body's shape, in the body's frame. The rounding is added to the sizes.
Mesh convex_mesh(const ConvexShape& shape, Color color);
/// Moves all vertices and turns the normals.
void transform_mesh(Mesh& mesh, const Pose& pose);

}  // namespace bsoil::render
#pragma GCC visibility pop
