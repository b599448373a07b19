/// Where the surface of a column is, told from its terrain and soil.
#pragma once

#include "soil/tile_codec.h"

namespace bsoil {

/// Terrain and soil of a column's voxels, from the floor up [volume units].
struct ColumnVoxels {
    const int32_t* terrain = nullptr;
    const int32_t* volume = nullptr;
    int height = 0;
    size_t stride = 1;  ///< words from a voxel to the one above
    int32_t terrain_at(int z) const { return terrain[static_cast<size_t>(z) * stride]; }
    int32_t volume_at(int z) const { return volume[static_cast<size_t>(z) * stride]; }
};
ColumnVoxels column_of(const TileVoxels& voxels, int column);

/// What rests in a column and what hangs above it.
struct ColumnProfile {
    int32_t top_q16 = 0;  ///< of the topmost resting soil or terrain [Q16 voxels above the floor]
    int hanging = -1;     ///< z of the topmost soil that nothing carries; -1: none
};
ColumnProfile column_profile(const ColumnVoxels& column);

/// Height of a column's surface [Q16 voxels] as build_spans.glsl finds it where there are no
/// bodies.
int32_t column_surface_q16(const ColumnVoxels& column);

/// Tops of a tile's columns, as ColumnProfile has them.
struct TileTops {
    std::array<int32_t, 64> top_q16{};
    int32_t lowest_q16 = 0, highest_q16 = 0;  ///< of them
    bool hangs = false;                       ///< there is soil that nothing carries
};
TileTops tile_tops(const TileRuns& tile);

/// column_surface_q16 of a tile's columns.
std::vector<int32_t> surface_heights_q16(const TileRuns& tile);

}  // namespace bsoil
