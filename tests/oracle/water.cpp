#include "oracle/water.h"

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

double moist_strength(double strength, double moist, double saturation, double water_of_mass) {
    return (strength + 4 * saturation * (1 - saturation) * moist) / (1 + water_of_mass);
}

WaterStep move_water(const Model& model, const Field& before, const std::vector<PoreSoil>& soils,
                     const Weather& weather) {
    WaterStep step{before};
    for (int y = 0; y < before.ny; ++y) {
        for (int x = 0; x < before.nx; ++x) {
            double rain = weather.rain, drying = weather.drying;
            for (int z = before.nz - 1; z >= 0; --z) {
                const Voxel& here = before.at(x, y, z);
                if (before.closed(model, x, y, z)) {
                    rain = 0;
                    continue;
                }
                const bool open_below = z > 0 && !before.closed(model, x, y, z - 1);
                const auto move_down = [&](double flow) {
                    step.field.at(x, y, z).water -= flow;
                    step.field.at(x, y, z - 1).water += flow;
                };
                if (here.total_mass() == 0) {
                    if (open_below) move_down(here.water);
                    continue;
                }
                double left = here.water;
                if (here.support.kind != Support::Kind::falling) {
                    const double enters =
                        std::min(rain, std::max(0.0, pores(here, soils) - here.water));
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
                const double flow = std::min(
                    left, mean(here, soils, &PoreSoil::conductivity) * open * open * open);
                if (z == 0) {
                    const double drained = std::min(flow, weather.floor);
                    step.field.at(x, y, z).water -= drained;
                    step.out += drained;
                } else if (open_below && before.at(x, y, z - 1).total_mass() > 0) {
                    const Voxel& below = before.at(x, y, z - 1);
                    move_down(std::min(flow, std::max(0.0, pores(below, soils) - below.water)));
                }
            }
        }
    }
    return step;
}

}  // namespace oracle
