/// Soil put into columns as runs of voxels: what a fill costs does not depend on how deep it is.
#pragma once

#include <compare>
#include <functional>
#include <vector>

#include "soil/tile_codec.h"

namespace bsoil {

/// The voxels low .. high - 1 of a column are to get `units` of soil each.
struct FillRun {
    int low = 0, high = 0;
    int units = 0;
    auto operator<=>(const FillRun&) const = default;
};
/// From the bottom up, without overlaps.
using FillRuns = std::vector<FillRun>;

/// Adds a voxel on top of the others; `share` of it is full, 0..1.
void add_voxel(FillRuns& runs, int z, double share);

/// Which columns of a grid get what.
struct FillShape {
    /// Adds the runs of column (x, y) to an empty list.
    std::function<void(int x, int y, FillRuns& runs)> column;
    /// Whether the columns (x0, y0) to (x1, y1) all get the same. Empty: nobody knows.
    std::function<bool(int x0, int y0, int x1, int y1)> is_level;
};

/// What a unit of volume adds to a voxel of which planes.
struct FillMaterial {
    size_t plane = 0;  ///< of its mass
    double mass_per_volume = 1;
    /// Water by layer from the bottom, as water_per_mass; that is of the layers above.
    std::vector<double> water_of_layer;
    size_t water_plane = 0;
    double water_per_mass = 0;
};

/// Puts soil into the columns of a tile where `wanted` has runs (64 entries; null: none), as far as
/// there is room. Returns the volume units put in.
int64_t fill_columns(const TileRuns& before, std::span<const FillRuns* const> wanted,
                     const FillMaterial& material, TileRuns& after);

}  // namespace bsoil
