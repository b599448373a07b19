/// Soil that rolls and slides along the ground.
#pragma once

#include <vector>

#include "bsoil/surface_mesh.h"
#include "mesh/display_field.h"

namespace bsoil::mesh {

/// What rolls on a tile, from the columns of the grid as they are now.
void find_rolling_soil(const GridColumns& grid, const TileSource& source, int tx, int ty,
                       std::vector<RollingSoil>& rolling);

}  // namespace bsoil::mesh
