#include "mesh/tile_levels.h"

#include <algorithm>
#include <cassert>

namespace bsoil::mesh {

TileLevels::TileLevels(int tile_count_x, int tile_count_y) : count_{tile_count_x, tile_count_y} {
    levels_.assign(static_cast<size_t>(tile_count_x) * static_cast<size_t>(tile_count_y), 0);
}

bool TileLevels::take(std::span<const uint8_t> wanted) {
    assert(wanted.size() == levels_.size());
    taken_.assign(wanted.begin(), wanted.end());
    for (uint8_t& level : taken_) level = std::min<uint8_t>(level, kMost);
    // Forth over what is left of and below a tile, then back over what is right of and above it:
    // for the distance in tiles where a corner is a neighbour, too, two sweeps reach everywhere.
    const auto lower = [&](int tx, int ty, int dx, int dy) {
        const int x = tx + dx, y = ty + dy;
        if (x < 0 || x >= count_[0] || y < 0 || y >= count_[1]) return;
        uint8_t& own = taken_[index(tx, ty)];
        own = std::min<uint8_t>(own, taken_[index(x, y)] + 1);
    };
    constexpr int kBefore[4][2] = {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}};
    for (int ty = 0; ty < count_[1]; ++ty) {
        for (int tx = 0; tx < count_[0]; ++tx) {
            for (const auto& d : kBefore) lower(tx, ty, d[0], d[1]);
        }
    }
    for (int ty = count_[1] - 1; ty >= 0; --ty) {
        for (int tx = count_[0] - 1; tx >= 0; --tx) {
            for (const auto& d : kBefore) lower(tx, ty, -d[0], -d[1]);
        }
    }
    if (taken_ == levels_) return false;
    std::swap(levels_, taken_);
    return true;
}

int TileLevels::finest_at(int x, int y) const {
    const int tx = x / kTileSide, ty = y / kTileSide;
    const int first_x = x % kTileSide == 0 ? std::max(0, tx - 1) : tx;
    const int first_y = y % kTileSide == 0 ? std::max(0, ty - 1) : ty;
    int finest = kMost;
    for (int v = first_y; v <= ty; ++v) {
        for (int u = first_x; u <= tx; ++u) finest = std::min(finest, at(u, v));
    }
    return finest;
}

int TileLevels::tile_of_cell(int level, int axis, int i) const {
    return std::clamp(i < 0 ? 0 : i / cells_of(level), 0, count_[axis] - 1);
}

TileLevels::FinerAround TileLevels::finer_around(int level, int i, int j) const {
    const int cell[2] = {i, j};
    int tile[2], low[2], high[2];  // of the offsets to the tiles that touch it
    for (int axis = 0; axis < 2; ++axis) {
        const int side = cells_of(level);
        tile[axis] = tile_of_cell(level, axis, cell[axis]);
        low[axis] = cell[axis] == tile[axis] * side && tile[axis] > 0 ? -1 : 0;
        high[axis] =
            cell[axis] + 1 == (tile[axis] + 1) * side && tile[axis] + 1 < count_[axis] ? 1 : 0;
    }
    FinerAround around;
    for (int dy = low[1]; dy <= high[1]; ++dy) {
        for (int dx = low[0]; dx <= high[0]; ++dx) {
            const bool finer = at(tile[0] + dx, tile[1] + dy) < level;
            around.finer[static_cast<size_t>(dy + 1)][static_cast<size_t>(dx + 1)] = finer;
            around.any |= finer;
        }
    }
    return around;
}

bool TileLevels::is_beside_finer(int tx, int ty) const {
    const int level = at(tx, ty);
    for (int y = std::max(0, ty - 1); y <= std::min(count_[1] - 1, ty + 1); ++y) {
        for (int x = std::max(0, tx - 1); x <= std::min(count_[0] - 1, tx + 1); ++x) {
            if (at(x, y) < level) return true;
        }
    }
    return false;
}

bool TileLevels::is_plain(int level, int i, int j) const {
    if (at(tile_of_cell(level, 0, i), tile_of_cell(level, 1, j)) != level) return false;
    return level == 0 || !finer_around(level, i, j).any;
}

uint64_t TileLevels::around(int tx, int ty) const {
    // The cells of a neighbour that lie at this tile's border may touch that one's next neighbour
    // only where it has a single cell.
    const int reach = at(tx, ty) == kMost ? 2 : 1;
    uint64_t sum = static_cast<uint64_t>(at(tx, ty));
    for (int y = ty - reach; y <= ty + reach; ++y) {
        for (int x = tx - reach; x <= tx + reach; ++x) {
            const bool exists = x >= 0 && x < count_[0] && y >= 0 && y < count_[1];
            sum = 4 * sum + static_cast<uint64_t>(exists ? at(x, y) : 0);
        }
    }
    return sum;
}

}  // namespace bsoil::mesh
