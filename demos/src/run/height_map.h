/// Heights of a soil's surface, as maps have them.
#pragma once

#include <string>
#include <vector>

#include "bsoil/soil.h"

namespace bsoil::scene {

/// Rows from north to south, columns from west to east: of a grid that is turned about the
/// vertical, turned by as much. East is the world's x, north its y where z is up and its -z where y
/// is.
struct HeightMap {
    struct Place {
        double east_m = 0, north_m = 0;
    };
    int width = 0, height = 0;
    double cell_m = 0;
    Place corner;      ///< the outer one of the first cell
    Place column_way;  ///< from a cell to the next of its row
    Place row_way;     ///< and of its column
    /// By half a turn, too: the columns of its rows do not go east.
    bool is_turned() const { return column_way.north_m != 0 || column_way.east_m < 0; }
    std::vector<double> heights_m;  ///< of the surface in the world
};
HeightMap height_map(const Soil& soil);

/// GeoTIFF 1.1 (OGC 19-008r4): one band of 32-bit floats, metres in a coordinate system of its own.
/// The error names the file, or the package that the build lacked.
Status write_geotiff(const HeightMap& map, const std::string& path);

}  // namespace bsoil::scene
