/// Where the surface of a column is and how far up it is filled, told from its terrain and soil.
#pragma once

#include "base/layout.h"
#include "soil/tile_codec.h"

namespace bsoil {

/// Terrain and soil of a column's voxels, from the floor up [volume units].
struct ColumnVoxels {
    const int32_t* terrain = nullptr;
    const int32_t* volume = nullptr;
    int height = 0;
    size_t stride = 1;  ///< words from a voxel to the one above
    const int32_t* ground =
        nullptr;  ///< the part of the terrain that belongs to bodies; may be null
    /// What was never moved; may be null: then nothing hangs over a hollow as a roof.
    const int32_t* bond = nullptr;
    int32_t terrain_at(int z) const { return terrain[static_cast<size_t>(z) * stride]; }
    int32_t volume_at(int z) const { return volume[static_cast<size_t>(z) * stride]; }
    /// Soil that was never moved and that nothing carries is a roof: what falls loses its bond.
    bool is_roof(int z) const {
        return bond && volume_at(z) > layout::kWholeMost &&
               2 * bond[static_cast<size_t>(z) * stride] >= volume_at(z) &&
               terrain_at(z) + volume_at(z) >= layout::kVoxelFull - layout::kSupportSlack;
    }
    int32_t ground_at(int z) const { return ground ? ground[static_cast<size_t>(z) * stride] : 0; }
};
/// ground: see TileTable::read_ground().
ColumnVoxels column_of(const TileVoxels& voxels, const TileVoxels& ground, int column);

/// How far up a column is filled, to the unit: what people see, pictures show and a scene measures.
/// What rests on what is decided by the kernels' own text (shaders/column_surface.glsl), as the
/// surface is; but a surface counts a voxel that carries soil as full (kSupportSlack), and ends
/// under terrain that hangs over it.
struct ColumnFill {
    /// Of the topmost resting soil or terrain [Q16 voxels above the floor]. Ground bodies without
    /// soil on them do not count.
    int32_t top_q16 = 0;
    int32_t soil_q16 = 0;  ///< of the topmost resting soil; 0: none
    int32_t stop_q16 = 0;  ///< up to here soil beside the column cannot slide into it
    int hanging = -1;      ///< z of the topmost soil that nothing carries; -1: none
};
ColumnFill column_fill(const ColumnVoxels& column);

/// A column's surface where there are no bodies, on which bodies and slopes stand: the kernels'
/// word, a height [Q16 voxels], or kTerrainTop less that of the terrain.
int32_t column_surface_q16(const ColumnVoxels& column);

/// Tops of a tile's columns, as ColumnFill has them.
struct TileTops {
    std::array<int32_t, 64> soil_q16{}, stop_q16{};
    int32_t lowest_q16 = 0, highest_q16 = 0;  ///< lowest stop, highest soil
    bool hangs = false;                       ///< there is soil that nothing carries
};
TileTops tile_tops(const TileRuns& tile);

/// column_surface_q16 of a tile's columns. has_roofs: soil has cohesion.
std::vector<int32_t> surface_heights_q16(const TileRuns& tile, bool has_roofs);

}  // namespace bsoil
