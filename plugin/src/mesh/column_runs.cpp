#include "mesh/column_runs.h"

#include <algorithm>
#include <cmath>

namespace bsoil::mesh {
namespace {

constexpr float kDense = 0.5f;  ///< from this fill on a voxel counts as part of a run: the isovalue
constexpr float kTrace = 0.01f;             ///< less soil than this in a voxel is not shown
constexpr float kGrainLeast = 1.0f / 1024;  ///< less soil than this is not even a grain
constexpr float kOverlap = 2.0f;  ///< how far soil continues into the solid it rests on [voxels]
constexpr float kGapMin =
    1.0f;  ///< runs closer than this are one: pores of moving soil are not shown
constexpr float kSliverHalf =
    0.05f;  ///< a run too thin to hold a sample is widened about one by this

/// A column of a tile; soil and solid by height.
struct ColumnView {
    const float* volume;
    const float* solid;  ///< null: none
    int height;
    int place;     ///< in the tile
    bool can_fly;  ///< soil does, terrain does not

    float soil_at(int z) const { return z >= 0 && z < height ? volume[z * kTileColumns] : 0.0f; }
    float solid_at(int z) const {
        return solid && z >= 0 && z < height ? solid[z * kTileColumns] : 0.0f;
    }
    float fill_at(int z) const { return std::min(1.0f, soil_at(z) + solid_at(z)); }
    bool supported(int z) const { return z == 0 || solid_at(z - 1) >= kDense; }
    /// Thin soil on a support counts too, so that a layer may thin out to nothing.
    bool in_run(int z) const { return is_thick(z) && !is_lump(z); }

  private:
    bool is_thick(int z) const {
        const float soil = volume[z * kTileColumns];
        return soil >= kDense || (soil > kTrace && (soil + solid_at(z) >= kDense || supported(z)));
    }
    /// A single voxel that flies, with none beside it in the tile: the surface would show it as an
    /// octahedron. It is drawn as grains.
    bool is_lump(int z) const {
        if (!can_fly || supported(z) || solid_at(z) >= kTrace) return false;
        if ((z > 0 && is_thick(z - 1)) || (z + 1 < height && is_thick(z + 1))) return false;
        const int x = place % kTileSide, y = place / kTileSide;
        const auto is_beside = [&](int step) {
            return volume[z * kTileColumns + step] >= kDense ||
                   (solid && solid[z * kTileColumns + step] >= kDense);
        };
        return !(x > 0 && is_beside(-1)) && !(x + 1 < kTileSide && is_beside(1)) &&
               !(y > 0 && is_beside(-kTileSide)) && !(y + 1 < kTileSide && is_beside(kTileSide));
    }
};

/// Top and bottom of the run of voxels first..last.
Run bounds_of(const ColumnView& column, int first, int last) {
    Run run;
    const float above = std::min(1.0f, column.soil_at(last + 1));
    if (column.supported(first)) {
        // Full voxels, then a partial one. While soil moves the last two may both be partial.
        run.on_solid = first > 0;
        run.bottom = run.on_solid ? static_cast<float>(first) - kOverlap : kOnFloor;
        run.top = static_cast<float>(last) + column.fill_at(last) + above;
        if (last > first) run.top -= 1.0f - column.fill_at(last - 1);
        return run;
    }
    // In the air: as much as there is, about its centre.
    float amount = 0, moment = 0;
    for (int z = first - 1; z <= last + 1; ++z) {
        const bool inside = z >= first && z <= last;
        const float fill = inside ? column.fill_at(z) : std::min(1.0f, column.soil_at(z));
        amount += fill;
        moment += fill * (static_cast<float>(z) + 0.5f);
    }
    const float center = moment / amount;
    const float sample = std::floor(center) + 0.5f;
    run.bottom = std::min(center - 0.5f * amount, sample - kSliverHalf);
    run.top = std::max(center + 0.5f * amount, sample + kSliverHalf);
    return run;
}

template <typename MaterialAt>
void append_runs(const ColumnView& column, MaterialAt material_at, std::vector<Run>& runs,
                 std::vector<MaterialLayer>& layers) {
    const size_t run_begin = runs.size(), layer_begin = layers.size();
    for (int z = 0; z < column.height; ++z) {
        if (!column.in_run(z)) continue;
        const int first = z;
        for (; z < column.height && column.in_run(z); ++z) {
            if (layers.size() == layer_begin || layers.back().material != material_at(z)) {
                layers.push_back({z, material_at(z)});
            }
        }
        Run run = bounds_of(column, first, z - 1);
        run.top = std::min(run.top, static_cast<float>(column.height));
        run.material = material_at(z - 1);
        if (runs.size() > run_begin && run.bottom - runs.back().top < kGapMin) {
            runs.back().top = std::max(runs.back().top, run.top);
            runs.back().material = run.material;
        } else {
            runs.push_back(run);
        }
    }
}

void append_solids(const ColumnView& column, std::vector<SolidRun>& solids) {
    if (!column.solid) return;
    for (int z = 0; z < column.height; ++z) {
        if (column.solid_at(z) < kDense) continue;
        const int first = z;
        while (z < column.height && column.solid_at(z) >= kDense) ++z;
        solids.push_back({static_cast<float>(first), static_cast<float>(z - 1) +
                                                         std::min(1.0f, column.solid_at(z - 1)) +
                                                         column.solid_at(z)});
    }
}

template <typename MaterialAt>
void find_runs(const float* volume, const float* solid, MaterialAt material_at, int height,
               bool can_fly, TileColumns& columns) {
    columns.runs.items.clear();
    columns.solids.items.clear();
    columns.layers.items.clear();
    for (int c = 0; c < kTileColumns; ++c) {
        const ColumnView column{volume + c, solid ? solid + c : nullptr, height, c, can_fly};
        const auto material = [&](int z) { return material_at(z * kTileColumns + c); };
        append_runs(column, material, columns.runs.items, columns.layers.items);
        append_solids(column, columns.solids.items);
        columns.runs.begin[c + 1] = static_cast<uint32_t>(columns.runs.items.size());
        columns.solids.begin[c + 1] = static_cast<uint32_t>(columns.solids.items.size());
        columns.layers.begin[c + 1] = static_cast<uint32_t>(columns.layers.items.size());
    }
}

}  // namespace

void find_soil_runs(std::span<const float> volume, std::span<const float> solid,
                    std::span<const uint8_t> material, int height, TileColumns& columns) {
    const bool any_solid = std::any_of(solid.begin(), solid.end(), [](float s) { return s > 0; });
    find_runs(
        volume.data(), any_solid ? solid.data() : nullptr,
        [&](int index) { return material[index]; }, height, true, columns);
}

void find_loose_voxels(std::span<const float> volume, std::span<const float> solid, int height,
                       std::vector<int>& voxels) {
    voxels.clear();
    for (int z = 0; z < height; ++z) {
        for (int c = 0; c < kTileColumns; ++c) {
            if (volume[z * kTileColumns + c] < kGrainLeast) continue;
            const ColumnView column{volume.data() + c, solid.data() + c, height, c, true};
            if (column.solid_at(z) >= kDense || column.in_run(z)) continue;
            // What lies on a run is its partial top; a run in the air takes in what is below it,
            // too.
            if (z > 0 && column.in_run(z - 1)) continue;
            if (z + 1 < height && column.in_run(z + 1) && !column.supported(z + 1)) continue;
            voxels.push_back(z * kTileColumns + c);
        }
    }
}

void find_terrain_runs(std::span<const float> solid, int height, TileColumns& columns) {
    find_runs(
        solid.data(), nullptr, [](int) { return uint8_t{0}; }, height, false, columns);
}

}  // namespace bsoil::mesh
