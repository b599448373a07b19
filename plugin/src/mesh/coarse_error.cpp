#include "mesh/coarse_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bsoil::mesh {
namespace {

constexpr int kSpan = kTileSide + 1;  ///< samples of a tile along an axis, its last border included

}  // namespace

CoarseErrors find_coarse_errors(const GridColumns& grid, int tx, int ty) {
    CoarseErrors errors;
    errors.fill(std::numeric_limits<float>::infinity());
    float tops[kSpan][kSpan];
    const Run* any = nullptr;
    int empty_count = 0;
    for (int j = 0; j < kSpan; ++j) {
        for (int i = 0; i < kSpan; ++i) {
            const int x = std::min(tx * kTileSide + i, grid.size[0] - 1);
            const int y = std::min(ty * kTileSide + j, grid.size[1] - 1);
            const TileColumns& tile =
                grid.tiles[(y / kTileSide) * grid.tile_count[0] + x / kTileSide];
            const int c = (y % kTileSide) * kTileSide + x % kTileSide;
            const auto runs = tile.runs.column(c);
            if (runs.empty()) {
                ++empty_count;
                continue;
            }
            const bool stands = runs[0].bottom == kOnFloor || runs[0].on_solid;
            if (runs.size() > 1 || !stands) return errors;
            if (any && any->look != runs[0].look) return errors;
            const bool is_cut = x == 0 || y == 0 || x == grid.size[0] - 1 || y == grid.size[1] - 1;
            if (is_cut && std::max(tile.layers.column(c).size(), tile.mixes.column(c).size()) > 1) {
                return errors;
            }
            any = &runs[0];
            tops[j][i] = any->top;
        }
    }
    if (empty_count == kSpan * kSpan) return {};
    if (empty_count > 0) return errors;
    for (int level = 1; level <= TileLevels::kMost; ++level) {
        const int spacing = 1 << level;
        float worst = 0;
        for (int j = 0; j < kTileSide; ++j) {
            for (int i = 0; i < kTileSide; ++i) {
                const int x = i / spacing * spacing, y = j / spacing * spacing;
                const float u = static_cast<float>(i - x) / static_cast<float>(spacing);
                const float v = static_cast<float>(j - y) / static_cast<float>(spacing);
                const float low = tops[y][x] + u * (tops[y][x + spacing] - tops[y][x]);
                const float high = tops[y + spacing][x] +
                                   u * (tops[y + spacing][x + spacing] - tops[y + spacing][x]);
                worst = std::max(worst, std::abs(low + v * (high - low) - tops[j][i]));
            }
        }
        errors[level - 1] = worst;
    }
    return errors;
}

}  // namespace bsoil::mesh
