/// The display field around one tile at its level of detail: signed vertical distances into the
/// runs of each column.
#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/column_runs.h"
#include "mesh/lattice.h"
#include "mesh/tile_levels.h"

namespace bsoil::mesh {

/// Columns of the whole grid, by tile.
struct GridColumns {
    int size[3] = {0, 0, 0};  ///< voxels along x, y, z
    int tile_count[2] = {0, 0};
    std::vector<TileColumns> tiles;  ///< index ty * tile_count[0] + tx
};

/// Samples lie at voxel centres of the tile's lattice. Beyond each side of the grid the inner one
/// of the two samples continues the soil, the outer one is empty. So the soil ends in an exact
/// plane there and its mesh is closed. Cells and samples are counted in the lattice.
class DisplayField {
  public:
    /// Most samples one way of a tile with its neighbours' that its cells and normals read.
    static constexpr int kWindow = kTileSide + 4;

    /// Reads the runs in and around tile (tx, ty) as a level has them. The columns must outlive the
    /// use of the field.
    void build(const GridColumns& grid, const TileLevels& levels, int level, int tx, int ty);
    int level() const { return level_; }
    const Lattice& lattice(int axis) const { return lattice_[axis]; }

    /// The first sample of the window along x (axis 0) or y (1): it has kWindow of them.
    int origin(int axis) const { return origin_[axis]; }
    /// The tile's own cells: cell (i, j) spans samples i..i + 1, j..j + 1.
    int cell_first(int axis) const { return cell_first_[axis]; }
    int cell_last(int axis) const { return cell_last_[axis]; }
    /// Sample counts upwards, and 64-bit words to hold a bit for each.
    int sample_count_z() const { return lattice_[2].count() + 3; }
    int word_count() const { return word_count_; }

    /// Position of a sample along an axis [voxels].
    float position(int axis, int i) const { return lattice_[axis].position(i); }
    /// Height of sample q = 0, 1, ... of a column [voxels]; q = 0 is sample -2.
    float height(int q) const { return position(2, q - 2); }
    /// The soil of a column of the window, and the terrain and static bodies there.
    std::span<const Run> runs(int i, int j) const {
        const Column& column = columns_[column_index(i, j)];
        return {runs_.data() + column.run_begin, column.run_end - column.run_begin};
    }
    std::span<const SolidRun> solids(int i, int j) const {
        return columns_[column_index(i, j)].solids;
    }
    /// The materials of a column, and where it lies bare to a side how they mix.
    std::span<const MaterialLayer> layers(int i, int j) const {
        return columns_[column_index(i, j)].layers;
    }
    std::span<const MixedLayer> mixes(int i, int j) const {
        return columns_[column_index(i, j)].mixes;
    }
    /// Bit q: sample q is inside.
    const uint64_t* inside_bits(int i, int j) const {
        return &bits_[column_index(i, j) * word_count_];
    }

    /// Vertical distance into the nearest run at height z, negative outside, within +-reach
    /// [voxels]. The display field is 0.5 plus this, so the thesis' isovalue 0.5 is its zero.
    float distance(int i, int j, float z, float reach) const;
    /// Where the surface crosses between samples q and q + 1 of a column [voxels].
    float crossing_up(int i, int j, int q) const;
    /// Where it crosses from a sample that is inside to the one beside it that is not, `length`
    /// voxels away: 0..1.
    float crossing_aside(const int inside[2], const int outside[2], float length, float z) const;
    /// Field gradient along x (axis 0) or y (1) about a sample, limited for shading.
    float slope(int axis, int i, int j, float z) const;
    /// Likewise between two neighbouring samples along an axis.
    float step(int axis, int i, int j, float z) const;
    /// Likewise along z.
    float slope_up(int i, int j, float z) const;
    /// Material of the soil at a sample.
    uint8_t material(int i, int j, float z) const;
    /// The look of what lies bare on top of a column, if height z is no deeper than that; else
    /// null.
    const Look* bare_look(int i, int j, float z) const;
    /// How the materials at a sample mix, and its water, where it lies bare to a side; null: not
    /// known.
    const MixedLayer* mixture(int i, int j, float z) const;
    /// Bit q of word w: sample q and one beside it in its column differ in material, or in how
    /// their materials mix.
    uint64_t material_borders(int i, int j, int w) const;

    bool is_in_window(int i, int j) const {
        return i >= origin_[0] && i < origin_[0] + kWindow && j >= origin_[1] &&
               j < origin_[1] + kWindow;
    }
    int column_index(int i, int j) const {
        assert(is_in_window(i, j));
        return (j - origin_[1]) * kWindow + (i - origin_[0]);
    }

  private:
    struct Column {
        uint32_t run_begin = 0, run_end = 0;
        std::span<const SolidRun> solids;
        std::span<const MaterialLayer> layers;
        std::span<const MixedLayer> mixes;
    };

    const Run* run_at(int i, int j, float z) const;
    float limited(int i, int j, float z) const;
    Column make_column(const GridColumns& grid, const TileLevels& levels, int x, int y);
    Column continued(const Column& last, const Column& before, bool is_fine);
    static float bare_bottom(const Run& run, std::span<const SolidRun> solids);
    void continue_into_solid(const GridColumns& grid, int x, int y, int spacing, Column& column);
    void set_bits(int i, int j);

    int level_ = 0;
    Lattice lattice_[3];
    int origin_[2] = {0, 0};
    int cell_first_[2] = {0, 0}, cell_last_[2] = {0, 0};
    int word_count_ = 0;
    std::array<Column, kWindow * kWindow> columns_;
    std::vector<Run> runs_;
    std::vector<uint64_t> bits_;
};

}  // namespace bsoil::mesh
