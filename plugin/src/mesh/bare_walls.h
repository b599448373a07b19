/// Where a column's soil lies bare to a side, below what is seen of its top.
#pragma once

#include "mesh/display_field.h"

namespace bsoil::mesh {

/// Of the columns of a tile just read, beside those of the grid as they are known. A column at a
/// side of the grid, which cuts it, is bare all the way.
void find_bare_walls(const GridColumns& grid, const TileColumns& tile, int tx, int ty,
                     ColumnLists<BareWall>& walls);

}  // namespace bsoil::mesh
