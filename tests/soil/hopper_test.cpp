// Soil that runs out of a hopper: docs/decisions/hoppers.md.
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "flow_fixture.h"
#include "oracle/arches.h"
#include "oracle/projectile.h"
#include "stage_bench.h"

namespace bsoil::hopper_test {
namespace {

constexpr double kFloor = 0.6, kSoil = 1.2, kDensity = 1500;

struct Plan {
    double opening_m, side_m;
    Backend backend = Backend::cpu;
    int threads = 0;
    double voxel_m = kVoxel, yaw_deg = 0;
};

/// A square silo along the grid with a square opening in its floor, of four boxes. What comes
/// through is taken away 0.4 m below.
struct Hopper {
    std::vector<Mover> floor;
    std::unique_ptr<Soil> soil;

    Hopper(const Plan& plan) {
        const double side_m = plan.side_m, voxel_m = plan.voxel_m;
        const auto voxels = [&](double m) { return static_cast<int>(std::lround(m / voxel_m)); };
        SoilDef def = grid_def(voxels(side_m), voxels(side_m), voxels(2), voxel_m);
        def.material = sand(30);
        def.material.density_kg_m3 = kDensity;
        def.backend = plan.backend;
        def.thread_count = plan.threads;
        soil = make_soil(def);
        // So wide that the floor fills the silo however it is turned.
        const double half_m = plan.opening_m / 2, rim_m = side_m / 2, off_m = half_m + rim_m;
        const auto add = [&](Vec3 half_extents_m, Vec3 at_m) {
            const Vec3 middle_m{side_m / 2, side_m / 2, kFloor - 0.1};
            ConvexShape box = box_shape(half_extents_m);
            box.local.rotation = turn({0, 0, 1}, plan.yaw_deg * std::numbers::pi / 180);
            box.local.position = rotate(box.local.rotation, at_m);
            floor.emplace_back(static_cast<int>(floor.size()), box, middle_m, true);
        };
        for (const double way : {-1.0, 1.0}) {
            add({rim_m, half_m + 2 * rim_m, 0.1}, {way * off_m, 0, 0});
            add({half_m, rim_m, 0.1}, {0, way * off_m, 0});
        }
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

/// The exponent by which the flow goes with the opening: the slope of a line through logarithms.
double exponent_of_flow(std::span<const Plan> plans) {
    double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
    for (const Plan& plan : plans) {
        const double rate = Hopper(plan).rate_kg_s(1.25, 2.25);
        EXPECT_GT(rate, 0.6 * beverloo_kg_s(plan.opening_m)) << plan.opening_m;
        EXPECT_LT(rate, beverloo_kg_s(plan.opening_m)) << plan.opening_m;
        testing::Test::RecordProperty("kg_s_" + std::to_string(std::lround(1e3 * plan.opening_m)),
                                      std::to_string(rate));
        const double x = std::log(plan.opening_m), y = std::log(rate);
        sum_x += x, sum_y += y, sum_xx += x * x, sum_xy += x * y;
    }
    const double count = static_cast<double>(plans.size());
    return (count * sum_xy - sum_x * sum_y) / (count * sum_xx - sum_x * sum_x);
}

class HopperInGrid : public testing::TestWithParam<std::pair<double, double>> {};

// Without arches the exponent is 1.2. An opening has four voxels at least, six where the grid is
// turned. Turned by 45 deg that is not enough: the rim goes through voxels' corners, and opens or
// closes each by halves (2.33 at 5 cm).
TEST_P(HopperInGrid, flow_goes_by_the_opening_as_beverloo_has_it) {
    const auto& [voxel_m, yaw_deg] = GetParam();
    std::vector<Plan> plans;
    for (const auto& [opening_m, side_m] :
         {std::pair{0.2, 1.0}, {0.3, 1.0}, {0.4, 1.2}, {0.6, 1.8}}) {
        if (yaw_deg != 0 && opening_m < 5.5 * voxel_m) continue;
        plans.push_back({opening_m, side_m, Backend::cpu, 0, voxel_m, yaw_deg});
    }
    EXPECT_NEAR(exponent_of_flow(plans), 2.5, 0.15);
}
INSTANTIATE_TEST_SUITE_P(Grids, HopperInGrid,
                         testing::Values(std::pair{0.05, 0.0}, std::pair{0.05, 22.5}));
INSTANTIATE_TEST_SUITE_P(SlowGrids, HopperInGrid,
                         testing::Values(std::pair{0.04, 0.0}, std::pair{0.025, 0.0},
                                         std::pair{0.025, 22.5}, std::pair{0.025, 45.0}));

TEST(Hopper, flow_does_not_hang_on_the_level) {
    Hopper hopper({0.4, 1.8});
    const double high = hopper.rate_kg_s(1, 2);
    EXPECT_NEAR(hopper.rate_kg_s(2, 3), high, 0.1 * high);  // that is from 4 s to 5 s
}

TEST(Hopper, has_the_same_bits_on_gl_on_threads_and_from_a_snapshot) {
    constexpr int kSteps = 70, kSaved = 45;
    Hopper one({0.4, 0.8, Backend::cpu, 1}), three({0.4, 0.8, Backend::cpu, 3});
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
    Hopper on_gl({0.4, 0.8, Backend::gl});
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
