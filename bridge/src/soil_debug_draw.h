/// The soil in Bullet's own debug drawing.
#pragma once

#include <LinearMath/btIDebugDraw.h>

#include <span>

#include "bsoil/soil.h"

namespace bsoil::bullet {

/// A force of the soil on a body, and where it acts. World axes.
struct DrawnForce {
    Vec3 point_m, force_n;
};

/// Draws what the drawer's mode asks for:
///
///     DBG_DrawAabb        the grid's box
///     DBG_DrawWireframe   the height spans of the columns in the tiles that bodies touch
///     DBG_DrawNormals     each contact voxel with its normal, and the forces as arrows: the
///     largest
///                         ten voxels long
///
/// Costs nothing without a mode; with spans it reads the tiles concerned.
void draw_soil(btIDebugDraw& drawer, const Soil& soil, std::span<const ContactVoxel> contacts,
               std::span<const DrawnForce> forces);

}  // namespace bsoil::bullet
