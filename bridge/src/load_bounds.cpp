#include "load_bounds.h"

#include <algorithm>
#include <numbers>

#include "bsoil/limits.h"

namespace bsoil::bullet {

LoadBounds::LoadBounds(const Soil& soil) : step_s(soil.def().step_s) {
    const GridFrame& frame = soil.frame();
    const Vec3 size_m =
        frame.voxel_m * Vec3{static_cast<double>(frame.size[0]), static_cast<double>(frame.size[1]),
                             static_cast<double>(frame.size[2])};
    double density_kg_m3 = 0;
    for (const MaterialDef& m : soil.materials()) {
        density_kg_m3 = std::max(
            {density_kg_m3, m.density_kg_m3, m.loose_density_kg_m3, m.compacted_density_kg_m3});
    }
    constexpr double kWaterKgM3 = 1000;  // pores are less than all of the room
    mass_kg = (density_kg_m3 + kWaterKgM3) * size_m.x * size_m.y * size_m.z;
    const double speed_m_s =
        std::numbers::sqrt3 * limits::kSoilSpeedMostVoxels * frame.voxel_m / step_s;
    impulse_n_s = mass_kg * 2 * speed_m_s;
    diagonal_m = length(size_m);
}

}  // namespace bsoil::bullet
