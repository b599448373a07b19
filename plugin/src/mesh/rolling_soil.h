/// Soil that rolls and slides along the ground.
#pragma once

#include <span>
#include <vector>

#include "bsoil/surface_mesh.h"
#include "mesh/display_field.h"

namespace bsoil::mesh {

/// How a column's topmost soil moves along the ground.
struct ColumnMotion {
    GroundMotion motion;
    float dust = 0;  ///< see TileSource::dust_at
};

/// Of all columns of a tile, or none where nothing moves. Right after the tile's own columns were
/// read: a source has the tile at hand then, and would fetch it anew later.
void read_motions(const GridColumns& grid, const TileSource& source, int tx, int ty,
                  std::vector<ColumnMotion>& motions);

/// What rolls on a tile, from its motions and the columns of the grid as they are now.
void find_rolling_soil(const GridColumns& grid, const TileSource& source, int tx, int ty,
                       std::span<const ColumnMotion> motions, std::vector<RollingSoil>& rolling);

}  // namespace bsoil::mesh
