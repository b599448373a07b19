/// Underside: what a body's lower side meets of a level or inclined surface of soil, from its
/// shapes alone.
#pragma once

#include <span>
#include <vector>

#include "bsoil/body.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// A place of the soil's surface, taken as a plane, and what lies there.
struct SurfaceSoil {
    SurfacePoint plane;
    int material = 0;              ///< index into SoilDef::material_list()
    double relative_density = -1;  ///< as ContactVoxel has it
    double saturation = 0;         ///< as ContactVoxel has it
    double undisturbed = 1;        ///< as ContactVoxel has it
};

/// Elements of the body's lower side that lie below the plane, one for each of some columns that
/// cover the part of it. `out` is cleared. box: the body's, world axes, as large or larger. Only
/// what can be seen from below counts, so that upright walls bear nothing. Returns how far the
/// columns are apart [m]. Cost: about 150 lines through the shapes, of a large body one a voxel.
double sample_underside(std::span<const ConvexShape> shapes, const Pose& pose, const Aabb& box,
                        const SurfaceSoil& surface, Vec3 up, double voxel_m, int body,
                        std::vector<ContactVoxel>& out);

}  // namespace bsoil
#pragma GCC visibility pop
