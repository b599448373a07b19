#include "soil/column_surface.h"

#include <algorithm>

#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

ColumnVoxels column_of(const TileVoxels& voxels, int column) {
    const auto plane = [&](int p) {
        return &voxels.words[static_cast<size_t>(p) * kTileColumns *
                                 static_cast<size_t>(voxels.height) +
                             static_cast<size_t>(column)];
    };
    return {plane(kKeptTerrain), plane(kKeptVolume), voxels.height, kTileColumns};
}

ColumnProfile column_profile(const ColumnVoxels& column) {
    ColumnProfile profile;
    bool piled = true;
    for (int z = 0; z < column.height; ++z) {
        const int terrain = column.terrain_at(z);
        const int volume = column.volume_at(z);
        piled = piled || terrain >= kSolidCoverage;
        if (volume > 0 && !piled) {
            profile.hanging = z;
        }
        if (piled && terrain + volume > 0) {
            profile.top_q16 = z * kVoxelFull + std::min<int>(kVoxelFull, terrain + volume);
        }
        piled = piled && terrain + volume >= kVoxelFull - kSupportSlack;
    }
    return profile;
}

int32_t column_surface_q16(const ColumnVoxels& column) {
    int surface = 0, bottom = 0, top = 0;
    int kind = kSpanPiled;
    for (int z = 0; z < column.height; ++z) {
        const int coverage = std::min(kVoxelFull, column.terrain_at(z));
        const int volume = column.volume_at(z);
        const int base = z * kVoxelFull;
        const auto top_with = [&](int reach) {
            return base + (volume + coverage >= kVoxelFull - kSupportSlack
                               ? kVoxelFull
                               : std::min(kVoxelFull, reach));
        };
        const bool hangs = volume >= kVoxelFull && coverage == 0;
        if (coverage >= kSolidCoverage) {
            if (kind == kSpanPiled) surface = top;
            kind = kSpanRigid;
        } else if (kind == kSpanRigid) {
            kind = kSpanPiled;
            bottom = base;
            top = top_with(volume > 0 ? volume + coverage : 0);
        } else if (kind == kSpanPiled) {
            if (top == base && volume + coverage > 0) {
                top = top_with(volume + (bottom == base ? coverage : 0));
            } else if (hangs) {
                surface = top;
                kind = kSpanFalling;
            }
        } else {
            kind = hangs ? kSpanFalling : 0;
        }
    }
    return kind == kSpanPiled ? top : surface;
}

namespace {

/// Calls visit(c, column) for the columns that differ from the one before, and same(c) for the
/// others.
template <typename Visit, typename Same>
void for_each_column(const TileRuns& tile, Visit&& visit, Same&& same) {
    std::vector<int32_t> terrain(static_cast<size_t>(tile.height)), volume(terrain.size());
    for (size_t c = 0; c < kTileColumns; ++c) {
        if (c > 0 && tile.columns[c] == tile.columns[c - 1]) {
            same(c);
            continue;
        }
        size_t z = 0;
        for (const ColumnRun& run : tile.column(static_cast<int>(c))) {
            for (int i = 0; i < run.length; ++i, ++z) {
                terrain[z] = run.values[kKeptTerrain];
                volume[z] = run.values[kKeptVolume];
            }
        }
        visit(c, ColumnVoxels{terrain.data(), volume.data(), tile.height});
    }
}

}  // namespace

TileTops tile_tops(const TileRuns& tile) {
    TileTops out;
    for_each_column(
        tile,
        [&](size_t c, const ColumnVoxels& column) {
            const ColumnProfile profile = column_profile(column);
            out.top_q16[c] = profile.top_q16;
            out.hangs = out.hangs || profile.hanging >= 0;
        },
        [&](size_t c) { out.top_q16[c] = out.top_q16[c - 1]; });
    const auto [lowest, highest] = std::ranges::minmax(out.top_q16);
    out.lowest_q16 = lowest;
    out.highest_q16 = highest;
    return out;
}

std::vector<int32_t> surface_heights_q16(const TileRuns& tile) {
    std::vector<int32_t> heights(kTileColumns);
    for_each_column(
        tile,
        [&](size_t c, const ColumnVoxels& column) { heights[c] = column_surface_q16(column); },
        [&](size_t c) { heights[c] = heights[c - 1]; });
    return heights;
}

}  // namespace bsoil
