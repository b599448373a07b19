#include "soil/column_surface.h"

#include <algorithm>

#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

ColumnVoxels column_of(const TileVoxels& voxels, const TileVoxels& ground, int column) {
    const auto plane = [&](int p) {
        return &voxels.words[static_cast<size_t>(p) * kTileColumns *
                                 static_cast<size_t>(voxels.height) +
                             static_cast<size_t>(column)];
    };
    return {plane(kKeptTerrain), plane(kKeptVolume), voxels.height, kTileColumns,
            ground.words.empty() ? nullptr : &ground.words[static_cast<size_t>(column)]};
}

ColumnProfile column_profile(const ColumnVoxels& column) {
    ColumnProfile profile;
    bool piled = true, stands = true;
    for (int z = 0; z < column.height; ++z) {
        const int terrain = column.terrain_at(z);
        const int volume = column.volume_at(z);
        piled = piled || terrain >= kSolidCoverage;
        if (volume > 0 && !piled) {
            profile.hanging = z;
        }
        const int reach = z * kVoxelFull + std::min<int>(kVoxelFull, terrain + volume);
        if (piled && terrain - column.ground_at(z) + volume > 0) {
            profile.top_q16 = reach;
        }
        if (piled && volume > 0) {
            profile.soil_q16 = reach;
        }
        if (stands && terrain + volume > 0) {
            profile.stop_q16 = reach;
        }
        const bool carries =
            terrain >= kSolidCoverage || terrain + volume >= kVoxelFull - kSupportSlack;
        stands = stands && carries;
        piled = piled && carries;
    }
    profile.stop_q16 = std::max(profile.stop_q16, profile.soil_q16);
    return profile;
}

int32_t column_surface_q16(const ColumnVoxels& column) {
    constexpr int kNotBare = -1;
    int surface = 0, bare = kNotBare, bottom = 0, top = 0;
    bool climbs = false;
    int kind = kSpanPiled;
    const auto is_surface = [&] { return top > bottom || bottom == 0; };
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
        if (climbs && coverage > 0) bare = base + coverage;
        climbs = climbs && coverage >= kSolidCoverage;
        if (coverage >= kSolidCoverage) {
            if (kind == kSpanPiled && is_surface()) {
                surface = top;
                climbs = z <= top / kVoxelFull + 1;
                bare = climbs ? base + coverage : kNotBare;
            }
            kind = kSpanRigid;
        } else if (kind == kSpanRigid) {
            kind = kSpanPiled;
            bottom = base;
            top = top_with(volume > 0 ? volume + coverage : 0);
        } else if (kind == kSpanPiled) {
            if (top == base && volume + coverage > 0) {
                top = top_with(volume + (bottom == base ? coverage : 0));
            } else if (hangs) {
                if (is_surface()) {
                    surface = top;
                    bare = kNotBare;
                }
                kind = kSpanFalling;
            }
        } else {
            kind = hangs ? kSpanFalling : 0;
        }
    }
    if (kind == kSpanPiled && is_surface()) return top;
    return bare == kNotBare ? surface : kTerrainTop - bare;
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
        visit(c, ColumnVoxels{terrain.data(), volume.data(), tile.height, 1, nullptr});
    }
}

}  // namespace

TileTops tile_tops(const TileRuns& tile) {
    TileTops out;
    for_each_column(
        tile,
        [&](size_t c, const ColumnVoxels& column) {
            const ColumnProfile profile = column_profile(column);
            out.soil_q16[c] = profile.soil_q16;
            out.stop_q16[c] = profile.stop_q16;
            out.hangs = out.hangs || profile.hanging >= 0;
        },
        [&](size_t c) {
            out.soil_q16[c] = out.soil_q16[c - 1];
            out.stop_q16[c] = out.stop_q16[c - 1];
        });
    out.lowest_q16 = std::ranges::min(out.stop_q16);
    out.highest_q16 = std::ranges::max(out.soil_q16);
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
