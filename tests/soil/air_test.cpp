// Soil that falls in air: fall speed, wind, gusts, shelter. docs/decisions/wind.md
#include <cmath>

#include "flow_fixture.h"
#include "oracle/projectile.h"
#include "oracle/wind.h"
#include "stage_scenario.h"
#include "temporary_file.h"

namespace bsoil::air_test {
namespace {

using namespace layout;

/// Materials that fall at different speeds, the second as in a vacuum, in gusts.
SoilDef air_def(const Scenario& scenario, Backend backend) {
    SoilDef def = scenario.def();
    def.backend = backend;
    if (def.materials.empty()) def.materials = {def.material};
    for (size_t i = 0; i < def.materials.size(); ++i) {
        constexpr double kFallSpeed[] = {1.5, 0, 0.4};
        def.materials[i].fall_speed_m_s = kFallSpeed[i];
    }
    const double voxel_a_step = def.voxel_m / def.step_s;
    // Over six columns no line comes near the border of two voxels, where rounding would decide.
    def.wind_m_s = voxel_a_step * Vec3{1.2, -0.516, 0.1};
    def.gust = 0.4;
    def.gust_size_m = 5 * def.voxel_m;
    def.shelter_m = 6 * def.voxel_m;
    return def;
}

void prepare(StageBench& bench, const Scenario& scenario) {
    bench.write(scenario.planes(bench));
    bench.place(scenario.bodies(bench));
    bench.find_support();
    bench.impl().params.gust_x = 700;
    bench.impl().params.gust_y = 90000;
}

class Air : public Stage {};

TEST_P(Air, falls_as_the_oracle_does) {
    for (const int substeps : {1, 3}) {
        StageBench bench(air_def(GetParam(), Backend::cpu));
        prepare(bench, GetParam());
        const oracle::Field before = bench.to_field(bench.read());
        bench.advect(substeps);
        const oracle::Model model = bench.model(substeps);
        const oracle::Field expected = oracle::advect(model, before, bench.oracle_bodies());
        const FieldDeviation deviation =
            compare(bench.to_field(bench.read()), expected, GetParam().material_count);
        // As in Projectile.advection_follows_the_oracle; the share that air takes of a speed of up
        // to 16 voxels is rounded down once more.
        constexpr double kTolerance = 8.0 * 33 / kVoxelFull;
        EXPECT_LT(deviation.soil.value, kTolerance) << deviation.soil;
        EXPECT_LT(deviation.mass.value, kTolerance) << deviation.mass;
        EXPECT_LT(deviation.momentum.value, 2 * kTolerance) << deviation.momentum;
        // Some of what falls is in the lee, some is not.
        int lee_count = 0, wind_count = 0;
        before.for_each([&](int x, int y, int z) {
            if (before.at(x, y, z).support.kind != oracle::Support::Kind::falling) return;
            const bool lee = length(oracle::air_velocity(model, before, x, y, z)) == 0;
            ++(lee ? lee_count : wind_count);
        });
        EXPECT_GT(lee_count, 10);
        EXPECT_GT(wind_count, 10);
    }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Air, testing::ValuesIn(all_scenarios()),
                         testing::PrintToStringParamName());

/// Along the axes, diagonally and between them: lines that cross tiles in every way.
std::vector<Vec3> winds_all_around() {
    std::vector<Vec3> winds;
    for (const double x : {-1.0, 0.0, 1.0}) {
        for (const double y : {-1.0, 0.0, 1.0}) {
            if (x != 0 || y != 0) winds.push_back({x, y, 0});
            if (x * y != 0) winds.push_back({x, 0.36 * y, 0});
            if (x * y != 0) winds.push_back({0.23 * x, y, 0});
        }
    }
    return winds;
}

// What find_support knows of a whole tile spares the line its columns, and changes nothing.
TEST(Air, shelter_reaches_over_tiles_in_every_direction) {
    const Scenario scenario{12, 48, 40, 32, 1};
    for (const Vec3& wind : winds_all_around()) {
        SCOPED_TRACE(testing::Message() << wind.x << ", " << wind.y);
        SoilDef def = air_def(scenario, Backend::cpu);
        def.wind_m_s = def.voxel_m / def.step_s * wind;
        def.shelter_m = 36 * def.voxel_m;
        StageBench bench(def);
        prepare(bench, scenario);
        const oracle::Field before = bench.to_field(bench.read());
        bench.advect(1);
        const oracle::Field expected =
            oracle::advect(bench.model(1), before, bench.oracle_bodies());
        const FieldDeviation deviation = compare(bench.to_field(bench.read()), expected, 1);
        constexpr double kTolerance = 8.0 * 33 / kVoxelFull;
        EXPECT_LT(deviation.soil.value, kTolerance) << deviation.soil;
        EXPECT_LT(deviation.momentum.value, 2 * kTolerance) << deviation.momentum;
    }
}

TEST(AirOnGl, has_the_same_bits) {
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    const Scenario scenario{11, 24, 16, 24, 3};
    std::vector<StatePlanes> after;
    for (const Backend backend : {Backend::cpu, Backend::gl}) {
        StageBench bench(air_def(scenario, backend));
        prepare(bench, scenario);
        bench.advect(1);
        bench.find_support();
        bench.advect(3);
        after.push_back(bench.read());
    }
    EXPECT_TRUE(after[0] == after[1]) << "CPU and GL differ";
}

/// Centre of all soil [m], from the grid's corner.
Vec3 center_of(const Soil& soil) {
    const GridFrame& frame = soil.frame();
    Vec3 moment;
    double volume = 0;
    for (int z = 0; z < frame.size[2]; ++z) {
        for (int y = 0; y < frame.size[1]; ++y) {
            for (int x = 0; x < frame.size[0]; ++x) {
                const double v = soil.sample(x, y, z).volume;
                moment += v * Vec3{x + 0.5, y + 0.5, z + 0.5};
                volume += v;
            }
        }
    }
    return frame.voxel_m / volume * moment;
}

/// A lump of 0.3 m in a grid of 9.6 m x 2.4 m x 6.4 m, 5 m up.
std::unique_ptr<Soil> falling_lump(SoilDef def, Vec3 low = {0.5, 1, 5}) {
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(BoxFill{{low, low + Vec3{0.3, 0.3, 0.3}}, {}}));
    return soil;
}
SoilDef open_air_def(double step_s) {
    SoilDef def = grid_def(96, 24, 64, 0.1);
    def.step_s = step_s;
    def.material.loose_density_kg_m3 = def.material.compacted_density_kg_m3 = 0;
    def.material.fall_speed_m_s = 2;
    return def;
}

// With linear drag v = v_t (1 - exp(-t / T)) and the fall is v_t (t - T (1 - exp(-t / T))), with
// T = v_t / g. With a wind w the lump goes w (t - T (1 - exp(-t / T))) along.
TEST(Air, soil_comes_to_its_fall_speed_and_goes_with_the_wind) {
    for (const double step_s : {1.0 / 30, 1.0 / 60, 1.0 / 240}) {
        SoilDef def = open_air_def(step_s);
        def.wind_m_s = {3, 0, 0};
        def.shelter_m = 0;  // full voxels of the lump are shelter to those behind them
        const auto soil = falling_lump(def);
        const Vec3 start = center_of(*soil);
        const double fall_s = def.material.fall_speed_m_s / def.gravity_m_s2;
        int step = 0;
        for (const double time_s : {0.5, 1.0, 2.0}) {
            for (; step * step_s < time_s - step_s / 2; ++step) soil->step({});
            const double lag_s = fall_s * (1 - std::exp(-time_s / fall_s));
            const Vec3 gone = center_of(*soil) - start;
            // A voxel, or a tenth: shares of it under a 4096th of a voxel stay behind, the
            // more the shorter the step.
            const double way_m = time_s - lag_s;
            EXPECT_NEAR(-gone.z, 2 * way_m, step_s < 0.01 ? 0.1 * way_m : 0.05) << time_s;
            EXPECT_NEAR(gone.x, 3 * way_m, step_s < 0.01 ? 0.15 * way_m : 0.1) << time_s;
            EXPECT_NEAR(gone.y, 0, 0.01);
        }
        EXPECT_EQ(soil->status_bits(), 0u);
    }
}

// Dust falls at less than half of what gravity gives in a step, 0.25 m/s here. It fell at that.
TEST(Air, dust_falls_as_slowly_as_it_says_in_long_steps) {
    SoilDef def = open_air_def(1.0 / 20);
    def.material.fall_speed_m_s = 0.05;
    def.shelter_m = 0;
    const auto soil = falling_lump(def);
    const Vec3 start = center_of(*soil);
    for (int i = 0; i < 40; ++i) soil->step({});
    // In the first step it goes half as far. A tenth: see above.
    EXPECT_NEAR((center_of(*soil) - start).z, -0.05 * 39.5 / 20, 0.01);
}

// Of 12 and 3 voxels a step, where a step has 8 parts at most and soil goes 16 at most.
TEST(Air, strong_wind_blows_where_it_should) {
    SoilDef def = open_air_def(1.0 / 20);
    for (const double factor : {1.0, 2.0}) {
        def.wind_m_s = factor * def.voxel_m / def.step_s * Vec3{12, 3, 0};
        StageBench bench(def);
        const auto& p = bench.impl().params;
        EXPECT_EQ(p.wind_x, std::min(12 * factor, 16.0) * kVoxelFull);
        EXPECT_EQ(p.wind_y, p.wind_x / 4);
        StatePlanes planes = bench.empty_planes();
        planes.at(kPlaneVolume, 20, 4, 40) = planes.at(kPlaneMaterial, 20, 4, 40) = kVoxelFull;
        bench.write(planes);
        bench.find_support();
        bench.advect(8);
        int64_t along = 0, aside = 0;
        const StatePlanes after = bench.read();
        for (int x = 20; x < 22; ++x) {
            for (int y = 4; y < 6; ++y) {
                for (int z = 39; z < 41; ++z) {
                    along += after.at(kPlaneMomentumX, x, y, z);
                    aside += after.at(kPlaneMomentumY, x, y, z);
                }
            }
        }
        EXPECT_GT(along, 0);
        EXPECT_NEAR(static_cast<double>(aside) / static_cast<double>(along), 0.25, 0.01);
    }
}

// At 2000 Hz air takes 3.2 of 3277 units of speed in a step. It took 4 one way and 3 the other, so
// that after 40 steps 0.951 and 0.963 were left. A lump full of voxels, so that chance averages.
TEST(Air, slows_soil_down_alike_to_either_side_in_short_steps) {
    SoilDef def = grid_def(48, 8, 16);
    def.step_s = 1.0 / 2000;
    def.material.fall_speed_m_s = 5;
    constexpr double kSpeed = 5;  // [m/s]
    const double rate = def.gravity_m_s2 * def.step_s / def.material.fall_speed_m_s;
    for (const int side : {-1, 1}) {
        StageBench bench(def);
        StatePlanes planes = bench.empty_planes();
        const double speed = side * kSpeed * def.step_s / def.voxel_m * kVelocityOne;
        for (int z = 8; z < 12; ++z) {
            for (int y = 2; y < 6; ++y) {
                for (int x = 20; x < 28; ++x) {
                    planes.at(kPlaneVolume, x, y, z) = kVoxelFull;
                    planes.at(kPlaneMaterial, x, y, z) = kVoxelFull;
                    planes.at(kPlaneMomentumX, x, y, z) =
                        static_cast<int>(std::lround(kVoxelFull * speed));
                }
            }
        }
        const auto momentum_of = [](const StatePlanes& of) {
            double sum = 0;
            for (int z = 0; z < 16; ++z) {
                for (int y = 0; y < 8; ++y) {
                    for (int x = 0; x < 48; ++x) sum += of.at(kPlaneMomentumX, x, y, z);
                }
            }
            return sum;
        };
        bench.write(planes);
        bench.find_support();
        constexpr int kSteps = 40;
        for (int step = 0; step < kSteps; ++step) bench.advect(1);
        EXPECT_NEAR(momentum_of(bench.read()) / momentum_of(planes),
                    std::pow(1 - rate / (1 + rate / 2), kSteps), 1e-3)  // 0.9615
            << side;
    }
}

/// 4 cm of snow a second for 3 s, out of a cloud 1.45 m up, in a wind of 2 m/s on ground of 12.8 m
/// x 1.6 m.
SoilDef snow_def() {
    SoilDef def = grid_def(128, 16, 16, 0.1);
    def.material = fixed_density(sand(35));
    def.material.fall_speed_m_s = 0.4;
    def.wind_m_s = {2, 0, 0};
    def.open_sides = kOpenHighX;
    return def;
}
std::unique_ptr<Soil> snowfall(const SoilDef& def) {
    auto soil = make_soil(def);
    SourceDef cloud;
    cloud.shape = SourceDef::Shape::rectangle;
    cloud.center_m = {6.4, 0.8, 1.45};
    cloud.length_m = 12.8;
    cloud.width_m = 1.6;
    cloud.rate_m3_s = 0.04 * 12.8 * 1.6;
    cloud.end_s = 3;
    EXPECT_TRUE(soil->add_source(cloud));
    return soil;
}
/// With a wall of 0.5 m across the wind at 8 m.
void snow_on(Soil& soil, int steps, bool has_wall = true) {
    Mover wall(1, box_shape({0.2, 0.8, 0.25}), {8, 0.8, 0.25}, true);
    const std::vector<SoilBody> bodies{wall.body};
    for (int i = 0; i < steps; ++i) {
        soil.step(has_wall ? bodies : std::vector<SoilBody>());
    }
}
double mean_depth_m(const Soil& soil, int from, int to) {
    double sum = 0;
    for (int x = from; x < to; ++x) {
        for (int y = 0; y < 16; ++y) {
            for (int z = 0; z < 16; ++z) sum += soil.sample(x, y, z).volume;
        }
    }
    return 0.1 * sum / (16 * (to - from));
}

// Flakes come down at atan(0.4 / 2), 11 deg. So none that comes over the wall falls into its lee,
// which ends at 15 deg: 1.9 m behind it. Advection spreads what falls over neighbouring voxels, and
// a tenth gets there all the same. In front of the wall lies what did not come over it.
TEST(SlowAir, little_snow_lies_behind_a_wall) {
    const auto open = snowfall(snow_def()), walled = snowfall(snow_def());
    snow_on(*open, 480, false);
    snow_on(*walled, 480);
    const auto ratio = [&](int from, int to) {
        return mean_depth_m(*walled, from, to) / mean_depth_m(*open, from, to);
    };
    EXPECT_LT(ratio(83, 97), 0.2);  // measured: 0.08
    EXPECT_GT(ratio(70, 77), 3);
    EXPECT_NEAR(ratio(20, 60), 1, 0.05);
    for (const auto& soil : {&open, &walled}) {
        expect_balance(**soil, make_soil((*soil)->def())->totals());
        EXPECT_EQ((*soil)->status_bits(), 0u);
    }
}

TEST(Air, gusts_have_the_same_bits_on_threads_and_from_a_snapshot) {
    SoilDef def = snow_def();
    def.gust = 0.8;
    def.gust_size_m = 1;
    std::vector<uint64_t> sums;
    for (const int threads : {1, 3}) {
        def.thread_count = threads;
        const auto soil = snowfall(def);
        snow_on(*soil, 60);
        const TemporaryFile file("air.snapshot");
        ASSERT_TRUE(soil->save(file.path()));
        snow_on(*soil, 60);
        sums.push_back(soil->checksum());
        const auto again = snowfall(def);
        ASSERT_TRUE(again->load(file.path()));
        snow_on(*again, 60);
        sums.push_back(again->checksum());
        expect_balance(*again, make_soil(def)->totals());
    }
    EXPECT_EQ(sums, std::vector<uint64_t>(4, sums[0]));
    def.gust = 0;
    const auto calm = snowfall(def);
    snow_on(*calm, 120);
    EXPECT_NE(calm->checksum(), sums[0]);
}

// What does not fall in air does not feel the wind.
TEST(Air, leaves_alone_what_has_no_fall_speed) {
    std::vector<uint64_t> sums;
    for (const double wind : {0.0, 20.0}) {
        SoilDef def = open_air_def(1.0 / 60);
        def.material.fall_speed_m_s = 0;
        def.wind_m_s = {wind, 0, 0};
        const auto soil = falling_lump(def);
        for (int i = 0; i < 60; ++i) soil->step({});
        sums.push_back(soil->checksum());
    }
    EXPECT_EQ(sums[0], sums[1]);
}

}  // namespace
}  // namespace bsoil::air_test
