// Soil that runs out of a hopper: docs/decisions/hoppers.md.
#include <cmath>

#include "flow_fixture.h"
#include "oracle/arches.h"
#include "oracle/projectile.h"
#include "stage_bench.h"

namespace bsoil::hopper_test {
namespace {

constexpr double kFloor = 0.6, kSoil = 1.2, kDensity = 1500;

/// A square silo with a square opening in its floor, of four boxes. What comes through is taken
/// away 0.4 m below.
struct Hopper {
    std::vector<Mover> floor;
    std::unique_ptr<Soil> soil;

    Hopper(double opening_m, double side_m, Backend backend = Backend::cpu, int threads = 0) {
        SoilDef def = grid_def(static_cast<int>(std::lround(side_m / kVoxel)),
                               static_cast<int>(std::lround(side_m / kVoxel)), 40, kVoxel);
        def.material = sand(30);
        def.material.density_kg_m3 = kDensity;
        def.backend = backend;
        def.thread_count = threads;
        soil = make_soil(def);
        const double rim_m = (side_m - opening_m) / 2, middle_m = side_m / 2;
        const auto add = [&](Vec3 half_extents_m, double x_m, double y_m) {
            floor.emplace_back(static_cast<int>(floor.size()), box_shape(half_extents_m),
                               Vec3{x_m, y_m, kFloor - 0.1}, true);
        };
        add({rim_m / 2, middle_m, 0.1}, rim_m / 2, middle_m);
        add({rim_m / 2, middle_m, 0.1}, side_m - rim_m / 2, middle_m);
        add({opening_m / 2, rim_m / 2, 0.1}, middle_m, rim_m / 2);
        add({opening_m / 2, rim_m / 2, 0.1}, middle_m, side_m - rim_m / 2);
        EXPECT_TRUE(soil->add_sink(box_sink({0, 0, 0}, {side_m, side_m, 0.2})));
        EXPECT_TRUE(soil->fill(BoxFill{{{0, 0, kFloor}, {side_m, side_m, kFloor + kSoil}}, {}}));
    }

    void step() { soil->step(bodies_of(floor)); }

    /// Mass that comes through from one time to another, by the second.
    double rate_kg_s(double from_s, double to_s) {
        double before_kg = 0;
        for (int i = 1; i <= std::lround(to_s * 60); ++i) {
            step();
            if (i == std::lround(from_s * 60)) before_kg = soil->totals().mass_kg[0];
        }
        return (before_kg - soil->totals().mass_kg[0]) / (to_s - from_s);
    }
};

// Beverloo (1961) without a rim: 0.58 rho sqrt(g) D^2.5 through a round opening, by its area 0.74
// through a square one.
double beverloo_kg_s(double opening_m) {
    return 0.74 * kDensity * std::sqrt(9.81) * std::pow(opening_m, 2.5);
}

TEST(Hopper, flow_goes_by_the_opening_as_beverloo_has_it) {
    double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
    constexpr std::pair<double, double> kOpeningAndSide[] = {
        {0.2, 1}, {0.3, 1}, {0.4, 1.2}, {0.6, 1.8}};
    for (const auto& [opening_m, side_m] : kOpeningAndSide) {
        const double rate = Hopper(opening_m, side_m).rate_kg_s(1.25, 2.25);
        EXPECT_GT(rate, 0.5 * beverloo_kg_s(opening_m)) << opening_m;
        EXPECT_LT(rate, beverloo_kg_s(opening_m)) << opening_m;
        const double x = std::log(opening_m), y = std::log(rate);
        sum_x += x, sum_y += y, sum_xx += x * x, sum_xy += x * y;
    }
    // 2.41, and more with voxels of half the size. Without arches 1.2.
    EXPECT_NEAR((4 * sum_xy - sum_x * sum_y) / (4 * sum_xx - sum_x * sum_x), 2.5, 0.15);
}

TEST(Hopper, flow_does_not_hang_on_the_level) {
    const double high = Hopper(0.4, 1.8).rate_kg_s(1, 2);
    EXPECT_NEAR(Hopper(0.4, 1.8).rate_kg_s(4, 5), high, 0.1 * high);
}

TEST(Hopper, has_the_same_bits_on_gl_on_threads_and_from_a_snapshot) {
    constexpr int kSteps = 70, kSaved = 45;
    Hopper one(0.4, 0.8, Backend::cpu, 1), three(0.4, 0.8, Backend::cpu, 3);
    std::vector<uint64_t> sums;
    for (int i = 0; i < kSteps; ++i) {
        if (i == kSaved) {
            const auto put = three.soil->prepare(one.soil->state());
            ASSERT_TRUE(put) << put.error();
            (*put)();
        }
        one.step();
        sums.push_back(one.soil->checksum());
        if (i < kSaved && i > 5) continue;
        three.step();
        ASSERT_EQ(three.soil->checksum(), sums.back()) << "step " << i;
    }
    EXPECT_LT(one.soil->totals().mass_kg[0], 0.8 * 0.8 * kSoil * kDensity - 20);
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    Hopper on_gl(0.4, 0.8, Backend::gl);
    for (int i = 0; i < kSteps; ++i) {
        on_gl.step();
        ASSERT_EQ(on_gl.soil->checksum(), sums[static_cast<size_t>(i)]) << "step " << i << " on GL";
    }
}

// A shaft of six columns between soil at rest, in which all falls at 3 voxels a step.
TEST(Arch, lets_soil_fall_as_fast_as_over_an_opening) {
    using namespace layout;
    StageBench bench(grid_def(24, 8, 16));
    StatePlanes planes = bench.empty_planes();
    const auto is_in_shaft = [](int x) { return x >= 9 && x < 15; };
    for (int x = 4; x < 20; ++x) {
        for (int y = 0; y < 8; ++y) {
            for (int z = is_in_shaft(x) ? 6 : 0; z < 12; ++z) {
                planes.at(kPlaneVolume, x, y, z) = kVoxelFull;
                planes.at(kPlaneMaterial, x, y, z) = kVoxelFull;
                if (!is_in_shaft(x)) continue;
                planes.at(kPlaneMomentumZ, x, y, z) = -3 * kVelocityOne * 64 * 1024;
            }
        }
    }
    bench.write(planes);
    bench.find_support();
    const oracle::Model model = bench.model(4);
    const oracle::Field before = bench.to_field(bench.read());
    const oracle::Field expected = oracle::advect(model, before, bench.oracle_bodies());
    bench.advect(4);
    const FieldDeviation deviation = compare(bench.to_field(bench.read()), expected, 1);
    EXPECT_LT(deviation.momentum.value, 3e-3) << deviation.momentum;
    EXPECT_LT(deviation.soil.value, 3e-3) << deviation.soil;
    // By hand, in the middle of a voxel of 5 cm, 2.5 and 3.5 voxels from the sides.
    const double speed_m_s = oracle::arch_speed(model, before, 11, 4, 8) * 0.05 * 60;
    EXPECT_NEAR(speed_m_s, std::sqrt(2 * 9.81 * 2 * 0.125 * 0.175 / 0.3), 0.005);
    EXPECT_EQ(oracle::arch_speed(model, before, 11, 4, 3),
              oracle::arch_speed(model, before, 11, 4, 2));
}

}  // namespace
}  // namespace bsoil::hopper_test
