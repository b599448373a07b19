/// How much of a tile's surface is lost at a coarse level.
#pragma once

#include <array>

#include "mesh/display_field.h"
#include "mesh/tile_levels.h"

namespace bsoil::mesh {

/// For levels 1, 2, 3: how far the tops of a tile's columns lie off the surface that the level
/// draws through each 2nd, 4th, 8th of them [voxels]. Infinite where the tile is more than one
/// surface of one material and one wetness, be it on top or where a side of the grid cuts it.
using CoarseErrors = std::array<float, TileLevels::kMost>;
CoarseErrors find_coarse_errors(const GridColumns& grid, int tx, int ty);

}  // namespace bsoil::mesh
