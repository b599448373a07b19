/// Tiles asleep: the height spans of each column as bytes, exact both ways.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace bsoil {

/// The voxels of one tile that outlive a step: `plane_count` planes of 64 * height words, index z *
/// 64 + column.
struct TileVoxels {
    int height = 0;
    int plane_count = 0;
    std::vector<int32_t> words;

    void reset(int tile_height, int planes) {
        height = tile_height;
        plane_count = planes;
        words.assign(static_cast<size_t>(planes) * 64 * tile_height, 0);
    }
    int32_t& at(int plane, int z, int column) {
        return words[(static_cast<size_t>(plane) * height + z) * 64 + column];
    }
    int32_t at(int plane, int z, int column) const {
        return words[(static_cast<size_t>(plane) * height + z) * 64 + column];
    }
};

/// Packs a tile. Per column: runs of voxels alike, each a length, a mask of the planes that are not
/// zero and their values; a column equal to the one before is one byte. Level ground takes 1 to 2
/// bytes a column.
std::vector<uint8_t> pack_tile(const TileVoxels& tile);

/// The inverse. `tile` has its size set already. False when the bytes are damaged (tile is then
/// unspecified).
bool unpack_tile(std::span<const uint8_t> bytes, TileVoxels& tile);

}  // namespace bsoil
