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
    return {plane(kKeptTerrain),
            plane(kKeptVolume),
            voxels.height,
            kTileColumns,
            ground.words.empty() ? nullptr : &ground.words[static_cast<size_t>(column)],
            voxels.plane_count > kKeptBond ? plane(kKeptBond) : nullptr};
}

namespace {

/// The kernels' text on one column, which is column 0 of itself.
struct ColumnKernel {
    const ColumnVoxels& voxels;
    static int min(int a, int b) { return std::min(a, b); }
    static int max(int a, int b) { return std::max(a, b); }
    int column_terrain(int, int z) const { return voxels.terrain_at(z); }
    int column_volume(int, int z) const { return voxels.volume_at(z); }
    bool is_column_roof(int, int z) const { return voxels.is_roof(z); }
    static int falling_least() { return kVoxelFull; }  // where the surface is does not hang on it
#define CONST_INT(name, value) static constexpr int name = value;
#define OUT(type) type&
#define INOUT(type) type&
#include "column_surface.glsl"
#undef INOUT
#undef OUT
#undef CONST_INT
};

}  // namespace

ColumnFill column_fill(const ColumnVoxels& column) {
    ColumnKernel rules{column};
    ColumnFill fill;
    int kind = kSpanPiled, bottom = 0, top = 0;  // as in bare_surface()
    bool stands = true;
    for (int z = 0; z < column.height; ++z) {
        const int terrain = column.terrain_at(z);
        const int volume = column.volume_at(z);
        const int base = z * kVoxelFull;
        const bool is_roof = rules.begins_roof(0, z, kind, top, volume, terrain);
        const int next = is_roof ? kSpanPiled : rules.kind_above(kind, top, base, volume, terrain);
        const bool is_carried = is_roof || rules.is_carried(kind, top, base);
        const bool rests = is_carried || next == kSpanRigid;
        const int filled_q16 = base + std::min<int>(kVoxelFull, terrain + volume);
        if (volume > 0 && !rests) fill.hanging = z;
        if (rests && terrain - column.ground_at(z) + volume > 0) fill.top_q16 = filled_q16;
        if (rests && volume > 0) fill.soil_q16 = filled_q16;
        stands = stands && is_carried;
        if (stands && terrain + volume > 0) fill.stop_q16 = filled_q16;
        top = rules.top_in_voxel(next, is_roof ? ColumnKernel::kNoSpan : kind, bottom, top, base,
                                 volume, terrain, kSupportSlack);
        bottom = next == kind && !is_roof ? bottom : base;
        kind = next;
    }
    fill.stop_q16 = std::max(fill.stop_q16, fill.soil_q16);
    return fill;
}

int32_t column_surface_q16(const ColumnVoxels& column) {
    return ColumnKernel{column}.bare_surface(0, 0, column.height);
}

namespace {

/// Calls visit(c, column) for the columns that differ from the one before, and same(c) for the
/// others. is_cut: columns end with their topmost terrain or soil.
template <typename Visit, typename Same>
void for_each_column(const TileRuns& tile, bool has_roofs, bool is_cut, Visit&& visit,
                     Same&& same) {
    std::vector<int32_t> terrain(static_cast<size_t>(tile.height)), volume(terrain.size()),
        bond(terrain.size());
    for (size_t c = 0; c < kTileColumns; ++c) {
        if (c > 0 && tile.columns[c] == tile.columns[c - 1]) {
            same(c);
            continue;
        }
        size_t z = 0;
        std::span<const ColumnRun> runs = tile.column(static_cast<int>(c));
        const auto is_air = [](const ColumnRun& run) {
            return run.values[kKeptTerrain] == 0 && run.values[kKeptVolume] == 0;
        };
        while (is_cut && !runs.empty() && is_air(runs.back())) runs = runs.first(runs.size() - 1);
        for (const ColumnRun& run : runs) {
            for (int i = 0; i < run.length; ++i, ++z) {
                terrain[z] = run.values[kKeptTerrain];
                volume[z] = run.values[kKeptVolume];
                bond[z] = run.values[kKeptBond];
            }
        }
        visit(c, ColumnVoxels{terrain.data(), volume.data(),
                              is_cut ? static_cast<int>(z) : tile.height, 1, nullptr,
                              has_roofs ? bond.data() : nullptr});
    }
}

}  // namespace

TileTops tile_tops(const TileRuns& tile) {
    TileTops out;
    for_each_column(
        tile, false, true,
        [&](size_t c, const ColumnVoxels& column) {
            const ColumnFill fill = column_fill(column);
            out.soil_q16[c] = fill.soil_q16;
            out.stop_q16[c] = fill.stop_q16;
            out.hangs = out.hangs || fill.hanging >= 0;
        },
        [&](size_t c) {
            out.soil_q16[c] = out.soil_q16[c - 1];
            out.stop_q16[c] = out.stop_q16[c - 1];
        });
    out.lowest_q16 = std::ranges::min(out.stop_q16);
    out.highest_q16 = std::ranges::max(out.soil_q16);
    return out;
}

std::vector<int32_t> surface_heights_q16(const TileRuns& tile, bool has_roofs) {
    std::vector<int32_t> heights(kTileColumns);
    for_each_column(
        tile, has_roofs, false,
        [&](size_t c, const ColumnVoxels& column) { heights[c] = column_surface_q16(column); },
        [&](size_t c) { heights[c] = heights[c - 1]; });
    return heights;
}

}  // namespace bsoil
