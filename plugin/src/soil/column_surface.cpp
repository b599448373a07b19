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
        if (volume > 0 && !piled) profile.hanging = z;
        const int reach = z * kVoxelFull + std::min<int>(kVoxelFull, terrain + volume);
        if (piled && terrain - column.ground_at(z) + volume > 0) profile.top_q16 = reach;
        if (piled && volume > 0) profile.soil_q16 = reach;
        if (stands && terrain + volume > 0) profile.stop_q16 = reach;
        const bool carries =
            terrain >= kSolidCoverage || terrain + volume >= kVoxelFull - kSupportSlack;
        stands = stands && carries;
        piled = piled && carries;
    }
    profile.stop_q16 = std::max(profile.stop_q16, profile.soil_q16);
    return profile;
}

namespace {

/// The kernels' text on one column, which is column 0 of itself.
struct ColumnKernel {
    const ColumnVoxels& voxels;
    static int min(int a, int b) { return std::min(a, b); }
    static int max(int a, int b) { return std::max(a, b); }
    int column_terrain(int, int z) const { return voxels.terrain_at(z); }
    int column_volume(int, int z) const { return voxels.volume_at(z); }
#define CONST_INT(name, value) static constexpr int name = value;
#include "column_surface.glsl"
#undef CONST_INT
};

}  // namespace

int32_t column_surface_q16(const ColumnVoxels& column) {
    return ColumnKernel{column}.bare_surface(0, 0, column.height);
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
