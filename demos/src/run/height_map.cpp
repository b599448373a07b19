#include "height_map.h"

#include <cmath>

namespace bsoil::scene {

HeightMap height_map(const Soil& soil) {
    const GridFrame& frame = soil.frame();
    const bool y_up = soil.def().up == UpAxis::y;
    HeightMap map;
    // Grid x and y are the world's x and y where z is up, its z and x where y is up.
    map.width = frame.size[y_up ? 1 : 0];
    map.height = frame.size[y_up ? 0 : 1];
    map.cell_m = frame.voxel_m;
    const auto grid_at = [&](int column, int row) {
        return y_up ? Vec3{static_cast<double>(row), static_cast<double>(column), 0}
                    : Vec3{static_cast<double>(column), static_cast<double>(map.height - row), 0};
    };
    const auto place_at = [&](int column, int row) {
        const Vec3 world = frame.to_world(grid_at(column, row));
        return HeightMap::Place{world.x, y_up ? -world.z : world.y};
    };
    // Zero is zero, whatever a turn by no angle leaves of it.
    const auto way = [&](HeightMap::Place to) {
        const auto cleaned = [&](double d) { return std::abs(d) < 1e-9 * map.cell_m ? 0.0 : d; };
        return HeightMap::Place{cleaned(to.east_m - map.corner.east_m),
                                cleaned(to.north_m - map.corner.north_m)};
    };
    map.corner = place_at(0, 0);
    map.column_way = way(place_at(1, 0));
    map.row_way = way(place_at(0, 1));
    const Vec3 floor = frame.to_world({0, 0, 0});
    const double floor_m = y_up ? floor.y : floor.z;
    for (int row = 0; row < map.height; ++row) {
        for (int column = 0; column < map.width; ++column) {
            const int x = y_up ? row : column, y = y_up ? column : map.height - 1 - row;
            map.heights_m.push_back(floor_m + soil.surface_height_m(x, y));
        }
    }
    return map;
}

}  // namespace bsoil::scene
