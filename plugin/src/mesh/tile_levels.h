/// The level of detail of each tile.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/column_runs.h"

#pragma GCC visibility push(default)
namespace bsoil::mesh {

/// Level 0 has all samples, each level half as many along each axis as the one before. The last one
/// has one cell a tile. Tiles that touch, be it at a corner, are at most one level apart.
class TileLevels {
  public:
    static constexpr int kMost = 3;
    static_assert(kTileSide >> kMost == 1);

    TileLevels(int tile_count_x, int tile_count_y);

    int at(int tx, int ty) const { return levels_[index(tx, ty)]; }
    /// Cells of a tile along each axis.
    static int cells_of(int level) { return kTileSide >> level; }
    /// Takes these levels, one a tile, lowered where touching tiles would be further apart. False
    /// when they are what they were.
    bool take(std::span<const uint8_t> wanted);

    /// The finest level of the tiles that have column (x, y) as a sample: what the column looks
    /// like must not depend on which of them asks.
    int finest_at(int x, int y) const;

    /// What of a cell is shared with finer cells. Offsets -1, 0, 1 towards a tile that touches the
    /// cell, and is finer than the cell's own: finer[dy + 1][dx + 1].
    struct FinerAround {
        std::array<std::array<bool, 3>, 3> finer{};
        bool any = false;
    };
    /// For the cell between samples i and i + 1, j and j + 1 of a level, in a tile of that level.
    FinerAround finer_around(int level, int i, int j) const;
    /// A finer tile touches this one.
    bool is_beside_finer(int tx, int ty) const;
    /// The cell lies in a tile of this level, and no finer tile touches it.
    bool is_plain(int level, int i, int j) const;

    /// All that a tile's mesh depends on of the levels.
    uint64_t around(int tx, int ty) const;

  private:
    size_t index(int tx, int ty) const { return static_cast<size_t>(ty * count_[0] + tx); }
    int tile_of_cell(int level, int axis, int i) const;

    int count_[2];
    std::vector<uint8_t> levels_, taken_;
};

}  // namespace bsoil::mesh
#pragma GCC visibility pop
