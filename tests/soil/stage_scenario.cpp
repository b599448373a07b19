#include "stage_scenario.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <ostream>
#include <random>
#include <tuple>

namespace bsoil {

using namespace layout;

namespace {

/// A number in 0..1 that is smooth over `cells` voxels.
class SmoothNoise {
  public:
    SmoothNoise(std::mt19937& random, int cells) : cells_(cells) {
        for (double& value : values_) value = std::uniform_real_distribution(0.0, 1.0)(random);
    }
    double at(int x, int y) const {
        const double u = static_cast<double>(x) / cells_, v = static_cast<double>(y) / cells_;
        const int i = static_cast<int>(u), j = static_cast<int>(v);
        const double a = u - i, b = v - j;
        return (value(i, j) * (1 - a) + value(i + 1, j) * a) * (1 - b) +
               (value(i, j + 1) * (1 - a) + value(i + 1, j + 1) * a) * b;
    }

  private:
    double value(int i, int j) const { return values_[static_cast<size_t>(j % 16 * 16 + i % 16)]; }
    int cells_;
    std::array<double, 256> values_{};
};

}  // namespace

SoilDef Scenario::def() const {
    SoilDef def = grid_def(nx, ny, nz);
    if (material_count == 3) {
        def.materials = {fixed_density(materials::dry_sand()), materials::moist_sand(),
                         fixed_density(materials::gravel())};
        def.materials[1].loose_cohesion_fraction = 0.3;
        // So wide that part of the soil that planes() makes lies within it.
        def.materials[1].loose_density_kg_m3 = 1000;
        def.materials[1].compacted_density_kg_m3 = 2000;
    }
    return def;
}

StatePlanes Scenario::planes(const StageBench& bench) const {
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
        return std::uniform_real_distribution(low, high)(random);
    };
    StatePlanes planes = bench.empty_planes();
    const SmoothNoise ground(random, 5), soil(random, 3);
    const auto put_soil = [&](int x, int y, int z, double amount) {
        const int units = static_cast<int>(amount * kVoxelFull);
        planes.at(kPlaneVolume, x, y, z) = units;
        planes.at(kPlaneBond, x, y, z) =
            random() % 2 ? units : static_cast<int>(units * uniform(0, 1));
        int mass = 0;
        for (int m = 0; m < material_count; ++m) {
            const int part = static_cast<int>(units * uniform(0.3, 0.95) / material_count);
            planes.at(kPlaneMaterial + m, x, y, z) = part;
            mass += part;
        }
        for (int axis = 0; axis < 3; ++axis) {
            planes.at(kPlaneMomentumX + axis, x, y, z) =
                static_cast<int>(mass * uniform(-0.9, 0.9) * kVelocityOne);
            planes.at(kPlaneForceX + axis, x, y, z) = static_cast<int>(uniform(-1021, 1021));
        }
        // A prime, so that no direction's quotient lies so near a half that fixed point and double
        // round it differently.
        planes.at(kPlaneForceX + static_cast<int>(random() % 3), x, y, z) =
            random() % 2 ? 1021 : -1021;
    };
    for (int y = 0; y < ny; ++y) {
        for (int x = 0; x < nx; ++x) {
            const double rock = ground.at(x, y) * 4 - 1,
                         top = std::max(0.0, rock) + soil.at(x, y) * nz * 0.5;
            const bool ledge = ground.at(x + 3, y + 7) > 0.7;
            for (int z = 0; z < nz; ++z) {
                double terrain = std::clamp(rock - z, 0.0, 1.0);
                if (ledge && z == nz * 5 / 8) terrain = uniform(0.2, 1);
                planes.at(kPlaneTerrain, x, y, z) = static_cast<int>(terrain * kVoxelFull);
                const double room = 1 - terrain;
                double amount = std::clamp(top - z, 0.0, room);
                if (amount == 0 && uniform(0, 1) < 0.12) {
                    amount = uniform(0, 1) < 0.3 ? room : uniform(0, room);  // floats
                } else if (amount > 0 && uniform(0, 1) < 0.1) {
                    amount *= uniform(0.9, 2.5);  // loose, or in excess
                }
                if (amount > 0.004) {  // crumbs move by chance: they have a test of their own
                    put_soil(x, y, z, amount);
                }
            }
        }
    }
    // Pillars of rock that stick out of the soil and end within a voxel.
    for (int column = 7; column < nx * ny; column += 41) {
        const int x = column % nx, y = column / nx;
        const double top = nz * 0.5 + 0.3 * (column % 13);
        for (int z = 0; z < nz; ++z) {
            const double terrain = std::clamp(top - z, 0.0, 1.0);
            for (int plane = 0; terrain > 0 && plane < planes.plane_count; ++plane) {
                planes.at(plane, x, y, z) =
                    plane == kPlaneTerrain ? static_cast<int>(terrain * kVoxelFull) : 0;
            }
        }
    }
    return planes;
}

std::vector<Mover> Scenario::bodies(const StageBench& bench) const {
    std::mt19937 random(seed + 1000);
    const auto uniform = [&](double low, double high) {
        return std::uniform_real_distribution(low, high)(random);
    };
    const double voxel = bench.soil().frame().voxel_m, step = bench.soil().def().step_s;
    const auto place = [&] {
        return Vec3{uniform(0.2, 0.8) * nx, uniform(0.2, 0.8) * ny, uniform(0.15, 0.6) * nz} *
               voxel;
    };
    const auto axis = [&] {
        const Vec3 v{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
        return v * (1 / length(v));
    };
    std::vector<Mover> movers;
    movers.emplace_back(0, box_shape(Vec3{3.1, 2.3, 1.7} * voxel), place());
    movers.emplace_back(1, octahedron_shape(3.4 * voxel), place());
    movers.emplace_back(2, round_shape(ConvexShape::Kind::cylinder, 2.2 * voxel, 2.6 * voxel),
                        place(), true);
    for (Mover& mover : movers) mover.body.pose.rotation = turn(axis(), uniform(0, 3));
    for (int i = 0; i < 2; ++i) {
        movers[static_cast<size_t>(i)].body.contact_pressure_pa = i == 0 ? 20e3 : 1e6;
        movers[static_cast<size_t>(i)].body.contact_width_m = i * 6 * voxel;
        movers[static_cast<size_t>(i)].set_velocity(axis() * (uniform(0.1, 0.9) * voxel / step),
                                                    axis() * (uniform(0, 0.2) / step));
    }
    return movers;
}

void PrintTo(const Scenario& s, std::ostream* out) {
    *out << "seed_" << s.seed << "_grid_" << s.nx << "x" << s.ny << "x" << s.nz << "_materials_"
         << s.material_count;
}

std::vector<Scenario> all_scenarios() {
    std::vector<Scenario> scenarios;
    for (unsigned seed = 1; seed <= 8; ++seed) {
        scenarios.push_back({seed, 16, 16, 16, 1});
        scenarios.push_back({seed + 10, 24, 16, 24, 3});
    }
    return scenarios;
}

StageBench& bench_of(const Scenario& scenario, Backend backend) {
    static std::map<std::tuple<int, int, Backend>, std::unique_ptr<StageBench>> benches;
    auto& bench = benches[{scenario.nx, scenario.material_count, backend}];
    if (!bench) {
        SoilDef def = scenario.def();
        def.backend = backend;
        bench = std::make_unique<StageBench>(def);
    }
    return *bench;
}

StageBench& Stage::prepared(Backend backend) const {
    const Scenario& scenario = GetParam();
    StageBench& bench = bench_of(scenario, backend);
    bench.write(scenario.planes(bench));
    bench.place(scenario.bodies(bench));
    bench.find_support();
    return bench;
}

}  // namespace bsoil
