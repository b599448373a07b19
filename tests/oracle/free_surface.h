/// The free surface that counts for a piece of a body's surface: not in the thesis. Column by
/// column, where the host sums up a table.
///
/// The soil that has to give way before a wall is the wedge, `wedge_length` times as long as it is
/// deep; around a sole it is all within `sole_widths` of its width. A piece between both has the
/// mean of both lengths by the squares of its normal's parts. The height is the mean over a square
/// of columns; each counts by its area inside. Columns under a body count for soles alone, bare
/// terrain no higher than the nearest soil.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "bsoil/geometry.h"

namespace oracle {

using bsoil::Vec3;

/// What is on top of a column.
struct SurfaceColumn {
    enum class Top { soil, body, terrain };
    Top top = Top::soil;
    double height = 0;  ///< of the soil (under a body: as if it were not there) or terrain [voxels]
};

/// A rectangle of columns, by y, then x.
struct SurfaceMap {
    int nx = 0, ny = 0;
    std::vector<SurfaceColumn> columns;
    const SurfaceColumn& at(int x, int y) const { return columns[static_cast<size_t>(y) * nx + x]; }
};

/// A piece of a body's surface. Lengths in voxels.
struct SurfacePiece {
    int x = 0, y = 0;  ///< its column
    Vec3 at, outward;  ///< outward: unit normal
    double body_width = 0;
    double wedge_length = 0;   ///< over the depth
    double sole_widths = 1.5;  ///< see above
    double reach_least = 16;   ///< columns that far away can count in any case ...
    double reach_most = 256;   ///< ... and none further than that
};

/// The nearest soil (counted in steps from column to column; ahead of a wall) decides how deep a
/// piece is; none: there is no soil.
std::optional<double> free_surface(const SurfaceMap& map, const SurfacePiece& piece);

/// Depth of level ground that pushes as hard on a wall as ground(x) does, which is the height above
/// the wall's foot at distance x: Coulomb's wedge, plane by plane, none of which descends. The push
/// grows with the square of the depth, and the wall's mean pressure over its depth counts.
double wedge_depth(const std::function<double(double)>& ground, double depth, double phi_rad,
                   double wall_rad);

}  // namespace oracle
