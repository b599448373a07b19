#include "mesh/bare_walls.h"

#include <algorithm>
#include <cmath>

namespace bsoil::mesh {
namespace {

/// From here on up a run's soil is covered by a column's runs, which are in order. Where nothing
/// is bare, that is the run's top.
float covered_up_to(const Run& run, std::span<const Run> beside) {
    float height = std::max(0.0f, run.bottom);
    for (const Run& other : beside) {
        if (other.bottom <= height) height = std::max(height, other.top);
    }
    return std::min(height, run.top);
}

}  // namespace

void find_bare_walls(const GridColumns& grid, const TileColumns& tile, int tx, int ty,
                     ColumnLists<BareWall>& walls) {
    walls.items.clear();
    const auto runs_of = [&](int x, int y) {
        const int other_x = x / kTileSide, other_y = y / kTileSide;
        const bool is_own = other_x == tx && other_y == ty;
        const TileColumns& columns =
            is_own ? tile : grid.tiles[static_cast<size_t>(other_y * grid.tile_count[0] + other_x)];
        return columns.runs.column((y % kTileSide) * kTileSide + x % kTileSide);
    };
    for (int c = 0; c < kTileColumns; ++c) {
        const int x = tx * kTileSide + c % kTileSide, y = ty * kTileSide + c / kTileSide;
        for (const Run& run : tile.runs.column(c)) {
            const bool hangs = run.bottom > 0 && !run.on_solid;
            float bare_from = hangs ? run.bottom : run.top;
            for (int v = y - 1; v <= y + 1; ++v) {
                for (int u = x - 1; u <= x + 1; ++u) {
                    const bool is_inside = u >= 0 && u < grid.size[0] && v >= 0 && v < grid.size[1];
                    const float covered = is_inside ? covered_up_to(run, runs_of(u, v)) : 0.0f;
                    bare_from = std::min(bare_from, covered);
                }
            }
            // Down to here the top's own look is seen.
            if (bare_from >= run.top - kBareDepth) continue;
            walls.items.push_back({static_cast<int>(std::max(0.0f, std::floor(bare_from))),
                                   static_cast<int>(std::ceil(run.top))});
        }
        walls.begin[static_cast<size_t>(c) + 1] = static_cast<uint32_t>(walls.items.size());
    }
}

}  // namespace bsoil::mesh
