#include "oracle/water.h"

#include <algorithm>
#include <utility>

namespace oracle {
namespace {

template <typename Member>
double mean(const Voxel& voxel, const std::vector<PoreSoil>& soils, Member member) {
    std::vector<double> of_materials;
    for (const PoreSoil& soil : soils) of_materials.push_back(soil.*member);
    return voxel.mean(of_materials);
}

double pores(const Voxel& voxel, const std::vector<PoreSoil>& soils) {
    return voxel.total_mass() * mean(voxel, soils, &PoreSoil::pores);
}

}  // namespace

double saturation(const Voxel& voxel, const std::vector<PoreSoil>& soils) {
    const double room = pores(voxel, soils);
    return room > 0 ? std::min(1.0, voxel.water / room) : 0;
}

namespace {

double suction(const Voxel& voxel, const std::vector<PoreSoil>& soils) {
    return mean(voxel, soils, &PoreSoil::suction) * (1 - saturation(voxel, soils));
}

/// Half of the room for what comes from above, half for what comes from the sides.
double intake(const Voxel& voxel, const std::vector<PoreSoil>& soils) {
    return std::max(0.0, pores(voxel, soils) - voxel.water) / 2;
}

}  // namespace

double moist_strength(double strength, double moist, double saturation, double water_of_mass) {
    return (strength + 4 * saturation * (1 - saturation) * moist) / (1 + water_of_mass);
}

WaterStep move_water(const Model& model, const Field& before, const std::vector<PoreSoil>& soils,
                     const Weather& weather) {
    WaterStep step{before};
    for (int y = 0; y < before.ny; ++y) {
        for (int x = 0; x < before.nx; ++x) {
            double rain = weather.rain, drying = weather.drying, drips = 0;
            for (int z = before.nz - 1; z >= 0; --z) {
                const Voxel& here = before.at(x, y, z);
                const double from_above = std::exchange(drips, 0);
                if (before.closed(model, x, y, z)) {
                    rain = 0;
                    continue;
                }
                const bool open_below = z > 0 && !before.closed(model, x, y, z - 1);
                const auto move_down = [&](double flow) {
                    step.field.at(x, y, z).water -= flow;
                    step.field.at(x, y, z - 1).water += flow;
                    drips = flow;
                };
                if (here.total_mass() == 0) {
                    if (open_below) move_down(here.water);
                    continue;
                }
                double left = here.water;
                if (here.support.kind != Support::Kind::falling) {
                    const double enters = std::clamp(intake(here, soils) - from_above, 0.0, rain);
                    const double dries = std::min(drying, here.water);
                    rain -= enters;
                    drying -= dries;
                    step.in += enters;
                    step.out += dries;
                    step.field.at(x, y, z).water += enters - dries;
                    left -= dries;
                    if (here.soil >= 0.5) rain = drying = 0;
                }
                const double residual = mean(here, soils, &PoreSoil::residual);
                const double open = (saturation(here, soils) - residual) / (1 - residual);
                left -= residual * pores(here, soils);
                if (open <= 0 || left <= 0) continue;
                const double seeps =
                    mean(here, soils, &PoreSoil::conductivity) * open * open * open;
                if (z == 0) {
                    const double drained = std::min({left, seeps, weather.floor});
                    step.field.at(x, y, z).water -= drained;
                    step.out += drained;
                    left -= drained;
                } else if (open_below && before.at(x, y, z - 1).total_mass() > 0) {
                    const double flow =
                        std::min({left, seeps, intake(before.at(x, y, z - 1), soils)});
                    move_down(flow);
                    left -= flow;
                }
                const double dry = mean(here, soils, &PoreSoil::suction);
                for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
                    const int tx = x + dx, ty = y + dy;
                    if (tx < 0 || ty < 0 || tx >= before.nx || ty >= before.ny) continue;
                    const Voxel& there = before.at(tx, ty, z);
                    if (before.closed(model, tx, ty, z) || there.total_mass() == 0) continue;
                    const double pull = suction(there, soils) - suction(here, soils);
                    if (pull <= 0) continue;
                    const double even = std::min(pores(here, soils), pores(there, soils)) * pull /
                                        (dry + mean(there, soils, &PoreSoil::suction));
                    const double flow =
                        std::min({seeps * pull, even / 4, intake(there, soils) / 4, left});
                    step.field.at(x, y, z).water -= flow;
                    step.field.at(tx, ty, z).water += flow;
                    left -= flow;
                }
            }
        }
    }
    return step;
}

}  // namespace oracle
