/// Soil put into columns as runs of voxels: what a fill costs does not depend on how deep it is.
#pragma once

#include <array>
#include <compare>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "soil/tile_codec.h"
#include "soil/tile_table.h"

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
    /// A caller's own function may not be called on several threads.
    bool is_ours = false;
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

/// What a whole tile becomes that held the same and gets the same in every column as others.
struct LevelTile {
    /// `before` is kept, so that no other takes its address.
    std::shared_ptr<const PackedTile> before, after;
    int64_t added = 0;
};
using LevelTiles = std::map<std::pair<const PackedTile*, FillRuns>, LevelTile>;

/// A tile while it is filled. Kept from row to row: uneven ground has hundreds of runs in each.
struct TileFill {
    int index = 0;
    int low[2] = {0, 0}, high[2] = {0, 0};  ///< its columns that the fill may reach
    std::array<FillRuns, 64> runs;
    std::array<const FillRuns*, 64> wanted{};
    const FillRuns* some = nullptr;  ///< of a column of those
    bool is_level = false;           ///< all get the same
    LevelTile* level = nullptr;      ///< shared with tiles alike
    bool is_worked = false;          ///< else `level` has what comes out
    TileRuns held, filled;
    std::shared_ptr<const PackedTile> after;
    int64_t added = 0;

    void ask(const FillShape& shape);
    void work(const FillMaterial& what);
};

}  // namespace bsoil
