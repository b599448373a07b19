/// Tiles asleep: the height spans of each column as bytes, exact both ways.
#pragma once

#include <array>
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

    /// All zero.
    void reset(int tile_height, int planes) {
        height = tile_height;
        plane_count = planes;
        words.assign(static_cast<size_t>(planes) * 64 * tile_height, 0);
    }
    /// For who writes all words.
    void resize(int tile_height, int planes) {
        height = tile_height;
        plane_count = planes;
        words.resize(static_cast<size_t>(planes) * 64 * tile_height);
    }
    int32_t& at(int plane, int z, int column) {
        return words[(static_cast<size_t>(plane) * height + z) * 64 + column];
    }
    int32_t at(int plane, int z, int column) const {
        return words[(static_cast<size_t>(plane) * height + z) * 64 + column];
    }
};

/// More planes than a tile has with any number of materials.
inline constexpr int kTilePlanesMost = 20;

/// Voxels on top of each other that are alike.
struct ColumnRun {
    int length = 0;
    std::array<int32_t, kTilePlanesMost> values{};  ///< by plane; 0 beyond the tile's planes
};

/// The same tile as runs, from the floor up. Columns alike share theirs.
struct TileRuns {
    struct Range {
        int first = 0, count = 0;
        bool operator==(const Range&) const = default;
    };
    int height = 0;
    int plane_count = 0;
    std::vector<ColumnRun> runs;
    std::array<Range, 64> columns{};

    std::span<const ColumnRun> column(int c) const {
        return std::span(runs).subspan(static_cast<size_t>(columns[static_cast<size_t>(c)].first),
                                       static_cast<size_t>(columns[static_cast<size_t>(c)].count));
    }
    /// Calls visit(column, z, run) for each run of each column, z: where it begins.
    template <typename Visit>
    void for_each(Visit&& visit) const {
        for (int c = 0; c < 64; ++c) {
            int z = 0;
            for (const ColumnRun& run : column(c)) {
                visit(c, z, run);
                z += run.length;
            }
        }
    }
    /// Puts a run on top of those from `first` on; it becomes part of the last one where it is
    /// alike.
    void append(int first, const ColumnRun& run);
};

/// Packs a tile. Per column: runs of voxels alike, each a length, a mask of the planes that are not
/// zero and their values; a column equal to the one before is one byte. Level ground takes 1 to 2
/// bytes a column.
std::vector<uint8_t> pack_tile(const TileVoxels& tile);

/// The inverse. `tile` has its size set already. False when the bytes are damaged (tile is then
/// unspecified).
bool unpack_tile(std::span<const uint8_t> bytes, TileVoxels& tile);
/// Only the first planes, as many as `tile` has, of a tile packed with `packed_plane_count`.
bool unpack_first_planes(std::span<const uint8_t> bytes, int packed_plane_count, TileVoxels& tile);
/// Only the lowest levels, as many as `tile` has, of a tile packed with `packed_height`.
bool unpack_levels(std::span<const uint8_t> bytes, int packed_height, TileVoxels& tile);
/// Above so many levels all words of a tile are zero, packed or as it is. 0 where the bytes are
/// damaged.
/// @{
int filled_levels(std::span<const uint8_t> bytes, int height, int plane_count);
int filled_levels(const TileVoxels& tile);
/// @}

/// The same bytes from runs and back; no two neighbouring runs of a column are alike.
/// @{
std::vector<uint8_t> pack_runs(const TileRuns& tile);
bool unpack_runs(std::span<const uint8_t> bytes, TileRuns& tile);
/// @}

}  // namespace bsoil
