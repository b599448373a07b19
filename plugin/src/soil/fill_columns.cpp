#include "soil/fill_columns.h"

#include <algorithm>
#include <cmath>

#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

/// A voxel of `run`, whose lowest layer is z, with `units` more soil, as far as there is room; adds
/// to `added` what went in.
ColumnRun filled(ColumnRun run, int z, int units, const FillMaterial& material, int64_t& added) {
    const int room = kVoxelFull - run.values[kKeptTerrain] - run.values[kKeptVolume];
    units = std::min(room, units);
    // Less than a crumb is not worth a voxel: it would hover until a neighbour's flow took it
    // along.
    if (units > kWholeMost) {
        run.values[kKeptVolume] += units;
        run.values[kKeptBond] += units;
        const int mass =
            std::max(1, static_cast<int>(std::lround(units * material.mass_per_volume)));
        run.values[material.plane] += mass;
        const auto layer = static_cast<size_t>(z);
        const double water = layer < material.water_of_layer.size() ? material.water_of_layer[layer]
                                                                    : material.water_per_mass;
        if (water > 0) {
            run.values[material.water_plane] += static_cast<int>(mass * kWaterParts * water);
        }
        added += int64_t{units} * run.length;
    }
    return run;
}

int64_t fill_column(std::span<const ColumnRun> before, const FillRuns& wanted,
                    const FillMaterial& material, int first, TileRuns& after) {
    int64_t added = 0;
    int low = 0;
    auto next = wanted.begin();
    for (const ColumnRun& run : before) {
        const int high = low + run.length;
        while (low < high) {
            while (next != wanted.end() && next->high <= low) ++next;
            ColumnRun part = run;
            if (next == wanted.end() || next->low >= high) {
                part.length = high - low;
            } else if (next->low > low) {
                part.length = next->low - low;
            } else {
                const bool is_layered = low < static_cast<int>(material.water_of_layer.size());
                part.length = is_layered ? 1 : std::min(high, next->high) - low;
                part = filled(part, low, next->units, material, added);
            }
            after.append(first, part);
            low += part.length;
        }
    }
    return added;
}

}  // namespace

void add_voxel(FillRuns& runs, int z, double share) {
    const int units = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * kVoxelFull));
    if (units == 0) return;
    if (!runs.empty() && runs.back().high == z && runs.back().units == units) {
        ++runs.back().high;
    } else {
        runs.push_back({z, z + 1, units});
    }
}

int64_t fill_columns(const TileRuns& before, std::span<const FillRuns* const> wanted,
                     const FillMaterial& material, TileRuns& after) {
    after.height = before.height;
    after.plane_count = before.plane_count;
    after.runs.clear();
    static const FillRuns kNothing;
    int64_t sum = 0, last = 0;
    for (size_t c = 0; c < kTileColumns; ++c) {
        const FillRuns& runs = wanted[c] ? *wanted[c] : kNothing;
        const FillRuns& runs_before = c > 0 && wanted[c - 1] ? *wanted[c - 1] : kNothing;
        if (c > 0 && before.columns[c] == before.columns[c - 1] &&
            (&runs == &runs_before || runs == runs_before)) {
            after.columns[c] = after.columns[c - 1];
        } else {
            const int first = static_cast<int>(after.runs.size());
            last = fill_column(before.column(static_cast<int>(c)), runs, material, first, after);
            after.columns[c] = {first, static_cast<int>(after.runs.size()) - first};
        }
        sum += last;
    }
    return sum;
}

}  // namespace bsoil
