#include "oracle/water.h"

#include <algorithm>
#include <tuple>
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

/// Height to which the water of a voxel would rise in a pipe, over the voxel's middle; negative
/// where pores are not full.
double pressure(const Voxel& voxel, int z, const std::vector<PoreSoil>& soils, double table) {
    const double depth = std::clamp(table - z - 0.5, 0.0, 1.0);
    return depth - mean(voxel, soils, &PoreSoil::suction) * (1 - saturation(voxel, soils));
}

/// Of what evens out the heads of two voxels what each of `ways` may do.
double share_to_even(const Voxel& a, const Voxel& b, double head,
                     const std::vector<PoreSoil>& soils, int ways) {
    return std::min(pores(a, soils), pores(b, soils)) * head /
           (mean(a, soils, &PoreSoil::suction) + mean(b, soils, &PoreSoil::suction)) / ways;
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
    const bool has_table = weather.table > 0;
    const int ways = has_table ? 5 : 4;
    const auto is_flooded = [&](int z) { return z >= 0 && z + 0.5 < weather.table; };
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
                    if (is_flooded(z)) {
                        const double full = mean(here, soils, &PoreSoil::conductivity);
                        const double room = intake(here, soils) - from_above - enters;
                        const double brings = std::clamp(room, 0.0, full);
                        const double takes = std::clamp(left - pores(here, soils), 0.0, full);
                        step.in += brings;
                        step.out += takes;
                        step.field.at(x, y, z).water += brings - takes;
                        left -= takes;
                    }
                    if (here.soil >= 0.5) rain = drying = 0;
                }
                const double residual = mean(here, soils, &PoreSoil::residual);
                const double open = (saturation(here, soils) - residual) / (1 - residual);
                left -= residual * pores(here, soils);
                if (open <= 0 || left <= 0) continue;
                const double seeps =
                    mean(here, soils, &PoreSoil::conductivity) * open * open * open;
                if (z == 0 && is_flooded(0)) {
                    // Groundwater goes on below.
                } else if (z == 0) {
                    const double drained = std::min({left, seeps, weather.floor});
                    step.field.at(x, y, z).water -= drained;
                    step.out += drained;
                    left -= drained;
                } else if (open_below && before.at(x, y, z - 1).total_mass() > 0) {
                    const Voxel& below = before.at(x, y, z - 1);
                    const bool to_table = is_flooded(z - 1) && !is_flooded(z);
                    double most = to_table ? left : intake(below, soils);
                    double head = 1;
                    if (has_table) {
                        head += pressure(here, z, soils, weather.table) -
                                pressure(below, z - 1, soils, weather.table);
                        const double most_head = mean(here, soils, &PoreSoil::suction) +
                                                 mean(below, soils, &PoreSoil::suction);
                        if (head > 0 && head < 1 && head < most_head) {
                            most = std::min(
                                most, from_above + share_to_even(here, below, head, soils, ways));
                        }
                    }
                    const double flow = std::min({left, seeps * std::clamp(head, 0.0, 1.0), most});
                    if (to_table) {
                        step.field.at(x, y, z).water -= flow;
                        step.out += flow;
                    } else {
                        move_down(flow);
                    }
                    left -= flow;
                }
                for (const auto& [dx, dy, dz] :
                     {std::tuple{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}) {
                    const int tx = x + dx, ty = y + dy, tz = z + dz;
                    if (tx < 0 || ty < 0 || tx >= before.nx || ty >= before.ny || tz >= before.nz ||
                        (dz > 0 && !has_table)) {
                        continue;
                    }
                    const Voxel& there = before.at(tx, ty, tz);
                    if (before.closed(model, tx, ty, tz) || there.total_mass() == 0) continue;
                    const double pull = pressure(here, z, soils, weather.table) -
                                        pressure(there, tz, soils, weather.table) - dz;
                    if (pull <= 0) continue;
                    const double flow =
                        std::min({seeps * pull, share_to_even(here, there, pull, soils, ways),
                                  intake(there, soils) / ways, left});
                    step.field.at(x, y, z).water -= flow;
                    step.field.at(tx, ty, tz).water += flow;
                    left -= flow;
                }
            }
        }
    }
    return step;
}

}  // namespace oracle
