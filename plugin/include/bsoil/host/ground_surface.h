/// GroundSurface: the soil's surface as triangles, read where someone asks.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "bsoil/soil.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Grid axes (x, y level, z up), metres. The surface's vertices lie over the column centres, at the
/// topmost resting soil or terrain, and once more at the box's rim, so that it reaches to it. A
/// column without soil and terrain is empty: beside it the surface falls to the floor within one
/// voxel, between empty columns there is none.
///
/// Heights are kept per tile of 8 x 8 columns and read again when Soil::tile_revision has moved.
/// Apart from them stands what bodies' contacts have met: from that changes are measured, whoever
/// else has asked in between.
class GroundSurface {
  public:
    /// soil: must outlive this.
    explicit GroundSurface(const Soil& soil);

    static constexpr int kTileSide = 8;  ///< columns, as a tile of the soil
    static constexpr int kTileColumns = kTileSide * kTileSide;
    /// A part of the surface.
    struct Triangle {
        std::array<Vec3, 3> corners_m;  ///< counter-clockwise seen from above
    };
    /// A square of the vertex lattice: of vertices x, x + 1 and y, y + 1.
    struct Cell {
        int x = 0, y = 0;
    };
    /// Along an axis.
    int cell_count(int axis) const { return size_[axis] + 1; }
    /// The cell over a place [m], clamped to the box; the first one for NaN.
    Cell cell_at(double x_m, double y_m) const;
    /// Place of a vertex along an axis.
    double vertex_m(int axis, int vertex) const;
    /// Number of triangles, 0 to 2, that the cell has between z_low_m and z_high_m, or that overlap
    /// that range.
    int triangles(Cell cell, double z_low_m, double z_high_m,
                  std::array<Triangle, 2>& triangles) const;
    /// The surface of all cells from low to high (inclusive) as two triangles, if it is there
    /// everywhere and plane to a thousandth of a voxel.
    bool plane_triangles(Cell low, Cell high, std::array<Triangle, 2>& triangles) const;
    /// Under or over a place; empty outside the box and between empty columns.
    std::optional<SurfacePoint> at(double x_m, double y_m) const;

    /// Bodies meet the surface of all cells from low to high (inclusive): changes are measured from
    /// what it is now, or from what they met there before.
    void meet(Cell low, Cell high);
    /// Meets the surface, and says whether a height between z_low_m and z_high_m in these columns
    /// has changed, by more than a hundredth of a voxel, since it was first met or forget_changes.
    bool has_changed(Cell low, Cell high, double z_low_m, double z_high_m);
    /// From now on only changes to come count.
    void forget_changes() { ++generation_; }

    /// What contacts have met of a tile. A run restored from a snapshot goes on with it.
    struct MetHeights {
        uint64_t changed = 0;                         ///< a bit per column
        std::array<float, kTileColumns> settled_m{};  ///< what the next change is measured from
        std::array<float, kTileColumns> before_m{};   ///< settled_m before the last change
    };
    /// And which tile: tx + ty times the tiles along x.
    struct MetTile {
        int64_t tile = 0;
        MetHeights heights;
    };
    /// Of all tiles that bodies have met, by tile.
    std::vector<MetTile> met_tiles() const;
    /// Puts what met_tiles() gave at another time in place of what there is.
    void set_met_tiles(std::span<const MetTile> tiles);

    double voxel_m() const { return voxel_m_; }  ///< edge of a voxel
    /// Of the grid, columns.
    int size(int axis) const { return size_[axis]; }

  private:
    struct Tile {
        uint64_t revision = 0;
        std::array<float, kTileColumns> height_m{};
    };
    /// What is known of it here.
    struct Met {
        uint64_t revision = 0;    ///< of the tile, when it was last compared
        uint64_t generation = 0;  ///< in which `changed` was written
        MetHeights heights;
    };
    struct Columns {
        int x0, y0, x1, y1;  ///< inclusive
    };

    const Tile* tile_at(int column_x, int column_y) const;
    Columns columns_of(Cell low, Cell high) const;
    void compare(Met& met, const Tile& tile, bool is_new) const;
    int64_t tiles_x() const { return (size_[0] + kTileSide - 1) / kTileSide; }
    double height_m(int vertex_x, int vertex_y) const;

    const Soil& soil_;
    double voxel_m_;
    int size_[2];
    uint64_t generation_ = 1;
    mutable std::unordered_map<int64_t, Tile> tiles_;
    std::unordered_map<int64_t, Met> met_;
};

}  // namespace bsoil
#pragma GCC visibility pop
