// Support, advection (21) to (29) and overflow resolution against the oracle.
#include "oracle/projectile.h"

#include <cmath>

#include "stage_scenario.h"

namespace bsoil::projectile_test {
namespace {

using namespace layout;

class Projectile : public Stage {};

TEST_P(Projectile, support_follows_the_oracle) {
    StageBench& bench = prepared(Backend::cpu);
    const oracle::Field got = bench.to_field(bench.read());
    // Where a roof just stands rounding decides: to 1/4096 voxel of its cohesion in each voxel.
    const auto expected = [&](double strength) {
        return oracle::find_support(bench.model(), got, bench.oracle_bodies(), strength);
    };
    const oracle::Field strong = expected(1.01), weak = expected(0.99);
    got.for_each([&](int x, int y, int z) {
        const auto is_support = [&](const oracle::Field& field) {
            const oracle::Support &a = got.at(x, y, z).support, &b = field.at(x, y, z).support;
            return a.kind == b.kind && a.body == b.body;
        };
        EXPECT_TRUE(is_support(strong) || is_support(weak)) << x << " " << y << " " << z;
    });
}

TEST_P(Projectile, advection_follows_the_oracle) {
    for (int substeps : {1, 3}) {
        StageBench& bench = prepared(Backend::cpu);
        const oracle::Field before = bench.to_field(bench.read());
        bench.advect(substeps);
        const oracle::Field expected =
            oracle::advect(bench.model(substeps), before, bench.oracle_bodies());
        const FieldDeviation deviation =
            compare(bench.to_field(bench.read()), expected, GetParam().material_count);
        // Drift is a whole number of 1/65536 voxels, cut off twice (velocity, sub-step); overlaps
        // and amounts are rounded down four times: at most 6 units for each voxel's worth of soil.
        // A voxel sends to 7 and gets from 26.
        constexpr double kTolerance = 6.0 * 33 / kVoxelFull;
        EXPECT_LT(deviation.soil.value, kTolerance) << deviation.soil;
        EXPECT_LT(deviation.mass.value, kTolerance) << deviation.mass;
        EXPECT_LT(deviation.momentum.value, kTolerance) << deviation.momentum;
    }
}

// The same where soil that lands keeps what goes along the ground.
TEST_P(Projectile, landing_with_momentum_follows_the_oracle) {
    SoilDef def = GetParam().def();
    def.slides = SlideMotion::run_out;
    StageBench bench(def);
    bench.write(GetParam().planes(bench));
    bench.place(GetParam().bodies(bench));
    bench.find_support();
    const oracle::Field before = bench.to_field(bench.read());
    bench.advect(1);
    const oracle::Field expected = oracle::advect(bench.model(), before, bench.oracle_bodies());
    const FieldDeviation deviation =
        compare(bench.to_field(bench.read()), expected, GetParam().material_count);
    // As above; the kept share of a landing is rounded to 1/4096 of what is lost.
    EXPECT_LT(deviation.soil.value, 6.0 * 33 / kVoxelFull) << deviation.soil;
    EXPECT_LT(deviation.momentum.value, 6.0 * 33 / kVoxelFull + 1.0 / 4096) << deviation.momentum;
}

TEST(Deviation, of_what_is_no_number_is_more_than_any) {
    Deviation deviation;
    deviation.take(1, 3, 0, 0, 0);
    deviation.take(1, std::nan(""), 4, 5, 6);
    deviation.take(1, 9, 0, 0, 0);
    EXPECT_TRUE(std::isnan(deviation.value));
    EXPECT_EQ(deviation.x, 4);
}

// A full voxel at top speed meets one that has as much momentum: it is cut off, and says so.
TEST(Momentum, that_is_more_than_an_integer_holds_saturates) {
    for (const int sign : {-1, 1}) {
        StageBench bench(grid_def(24, 8, 8));
        StatePlanes planes = bench.empty_planes();
        const auto put = [&](int x, int volume, int momentum) {
            planes.at(kPlaneVolume, x, 4, 4) = volume;
            planes.at(kPlaneMaterial, x, 4, 4) = 2 * volume - 1;
            planes.at(kPlaneMomentumX, x, 4, 4) = momentum;
        };
        constexpr int kMost = (2 * kVoxelFull - 1) * (kSpeedMost / 64);
        put(10, kVoxelFull, sign * kMost);
        put(10 + sign, 8 * kVoxelFull, sign * kMost);  // 2 voxels a step
        bench.write(planes);
        bench.advect(16);
        EXPECT_EQ(bench.read().at(kPlaneMomentumX, 10 + sign, 4, 4), sign * kMomentumMost);
        EXPECT_TRUE(bench.result_status() & kStatusHeadroom);
    }
}

// Four voxels of soil in one that a body lifts at top speed: as much as there may be, and not what
// is left of twice as much in 32 bits.
TEST(Momentum, that_a_body_gives_to_soil_of_several_voxels_saturates) {
    for (const Backend backend : {Backend::cpu, Backend::gl}) {
        if (backend == Backend::gl && !gl_missing().empty()) GTEST_SKIP() << gl_missing();
        SoilDef def = grid_def(8, 8, 16);
        def.backend = backend;
        StageBench bench(def);
        StatePlanes planes = bench.empty_planes();
        planes.at(kPlaneVolume, 4, 4, 6) = planes.at(kPlaneMaterial, 4, 4, 6) = 4 * kVoxelFull;
        planes.at(kPlaneSupport, 4, 4, 6) = kSupportBody;  // the first body
        bench.write(planes);
        std::vector<Mover> movers;
        movers.emplace_back(0, box_shape(Vec3{2, 2, 1} * def.voxel_m), Vec3{4, 4, 2} * def.voxel_m);
        movers[0].set_velocity({0, 0, 16 * def.voxel_m / def.step_s});
        bench.place(movers);
        bench.advect(16);  // a voxel up
        const StatePlanes after = bench.read();
        EXPECT_EQ(after.at(kPlaneVolume, 4, 4, 7), 4 * kVoxelFull);
        EXPECT_EQ(after.at(kPlaneMomentumZ, 4, 4, 7), kMomentumMost);
        EXPECT_EQ(after.at(kPlaneMomentumZ, 4, 4, 6), 0);
        EXPECT_TRUE(bench.result_status() & kStatusHeadroom);
    }
}

TEST_P(Projectile, overflow_resolution_follows_the_oracle) {
    constexpr std::pair<OverflowHeuristic, oracle::Heuristic> kHeuristics[] = {
        {OverflowHeuristic::even, oracle::Heuristic::even},
        {OverflowHeuristic::up, oracle::Heuristic::up},
        {OverflowHeuristic::up_spread, oracle::Heuristic::up_spread},
    };
    for (const auto& [heuristic, oracle_heuristic] : kHeuristics) {
        StageBench& bench = prepared(Backend::cpu);
        bench.apply_force();  // soil without a body keeps its push, soil without excess loses it
        const oracle::Field before = bench.to_field(bench.read());
        const oracle::Field expected = oracle::resolve_overflow(
            bench.model(), before, bench.oracle_bodies(), oracle_heuristic);
        bench.resolve_overflow(heuristic);
        const FieldDeviation deviation =
            compare(bench.to_field(bench.read()), expected, GetParam().material_count);
        // Share of the excess, its division among up to 26 voxels and the amount are each rounded
        // down: 3 units for each of up to 2.5 voxels' worth of soil, with 26 voxels either way.
        constexpr double kTolerance = 3.0 * 52 * 2.5 / kVoxelFull;
        EXPECT_LT(deviation.soil.value, kTolerance) << deviation.soil;
        EXPECT_LT(deviation.mass.value, kTolerance) << deviation.mass;
        EXPECT_LT(deviation.momentum.value, kTolerance) << deviation.momentum;
        int moved_count = 0;
        before.for_each([&](int x, int y, int z) {
            moved_count += before.at(x, y, z).soil != expected.at(x, y, z).soil;
        });
        EXPECT_GT(moved_count, 5);
    }
}

TEST_P(Projectile, has_the_same_bits_on_gl) {
    expect_same_on_gl([](StageBench& bench) {
        bench.advect(1);
        for (OverflowHeuristic heuristic :
             {OverflowHeuristic::even, OverflowHeuristic::up, OverflowHeuristic::up_spread}) {
            bench.resolve_overflow(heuristic);
        }
        bench.find_support();
        bench.advect(2);
        return bench.read();
    });
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Projectile, testing::ValuesIn(all_scenarios()),
                         testing::PrintToStringParamName());

// Gravity of 59 units of 1/65536 voxel a step, and friction with a body of 64. Each of five parts
// had 11 and 12 of them, so that a fifteenth of both was lost.
TEST(Advection, has_all_of_gravity_and_friction_in_any_number_of_parts) {
    SoilDef def = grid_def(16, 8, 16);
    constexpr int kGravity = 59, kGrip = kOneQ16 / kVelocityOne;
    def.gravity_m_s2 = kGravity * def.voxel_m / kVoxelFull / (def.step_s * def.step_s);
    StageBench bench(def);
    StatePlanes planes = bench.empty_planes();
    const auto put = [&](int x, int z) {
        planes.at(kPlaneVolume, x, 4, z) = planes.at(kPlaneMaterial, x, 4, z) = kVoxelFull;
    };
    put(3, 10);  // falls
    put(12, 2);  // lies on the body
    std::vector<Mover> movers;
    movers.emplace_back(0, box_shape(Vec3{3.5, 4, 1} * def.voxel_m),
                        Vec3{12.5, 4, 1} * def.voxel_m);
    movers[0].set_velocity({0.1 * def.voxel_m / def.step_s, 0, 0});
    movers[0].body.surface.friction = 1.0 * kGrip / kGravity;
    for (const int parts : {1, 3, 5, 7, 8}) {
        bench.write(planes);
        bench.place(movers);
        bench.find_support();
        for (int part = 0; part < parts; ++part) bench.advect(parts, part);
        const StatePlanes after = bench.read();
        int64_t along = 0, down = 0;
        for (int z = 0; z < 16; ++z) {
            for (int x = 0; x < 16; ++x) {
                along += after.at(kPlaneMomentumX, x, 4, z);
                down -= after.at(kPlaneMomentumZ, x, 4, z);
            }
        }
        EXPECT_EQ(down, kVoxelFull / 64 * kGravity) << parts;
        EXPECT_EQ(along, kVoxelFull / 64 * kGrip) << parts;
    }
}

// Each crumb stays whole; a part of them moves, as large as the drift is long. So does soil of more
// than a crumb that drifts so little that it has no share to give.
TEST(Crumbs, move_whole_and_on_average_as_far_as_they_drift) {
    StageBench& bench = bench_of({1, 24, 16, 24, 3}, Backend::cpu);
    for (const auto& [substeps, volume, drift] :
         {std::tuple(1, +kWholeMost, 0.3), {4, +kWholeMost, 0.3}, {1, 2 * kWholeMost, 0.03}}) {
        constexpr int kMass = 100, kCount = 12 * 8 * 8;
        const double kDrift = drift;  // along x, voxels a part of a step
        StatePlanes planes = bench.empty_planes();
        for (int z = 1; z < 24; z += 3) {
            for (int y = 0; y < 16; y += 2) {
                for (int x = 0; x < 24; x += 2) {
                    planes.at(kPlaneVolume, x, y, z) = volume;
                    planes.at(kPlaneMaterial, x, y, z) = kMass;
                    planes.at(kPlaneMomentumX, x, y, z) =
                        static_cast<int>(kMass * kDrift * substeps * kVelocityOne);
                }
            }
        }
        bench.write(planes);
        bench.advect(substeps);
        const StatePlanes after = bench.read();
        int moved_count = 0, sum = 0;
        for (int z = 0; z < 24; ++z) {
            for (int y = 0; y < 16; ++y) {
                for (int x = 0; x < 24; ++x) {
                    const int mass = after.at(kPlaneMaterial, x, y, z);
                    EXPECT_EQ(mass % kMass, 0);
                    sum += mass;
                    moved_count += x % 2 == 1 ? mass / kMass : 0;
                }
            }
        }
        EXPECT_EQ(sum, kMass * kCount);
        // A count of independent chances: three standard deviations.
        EXPECT_NEAR(moved_count / static_cast<double>(kCount), kDrift,
                    3 * std::sqrt(kDrift * (1 - kDrift) / kCount));
    }
}

// What wind presses to a wall falls for all that: a crumb's axes have chances of their own.
TEST(Crumbs, come_down_along_a_wall_that_they_are_pressed_to) {
    StageBench& bench = bench_of({1, 24, 16, 24, 3}, Backend::cpu);
    constexpr int kMass = 100, kCount = 16 * 8;
    for (const int volume : {+kWholeMost, 2 * kWholeMost}) {
        StatePlanes planes = bench.empty_planes();
        for (int z = 2; z < 24; z += 3) {
            for (int y = 0; y < 16; ++y) {
                planes.at(kPlaneVolume, 23, y, z) = volume;
                planes.at(kPlaneMaterial, 23, y, z) = kMass;
                planes.at(kPlaneMomentumX, 23, y, z) = kMass * kVelocityOne / 2;
                planes.at(kPlaneMomentumZ, 23, y, z) = -kMass * kVelocityOne / 50;
            }
        }
        bench.write(planes);
        bench.advect(1);
        const StatePlanes after = bench.read();
        int fallen_count = 0;
        for (int z = 1; z < 24; z += 3) {
            for (int y = 0; y < 16; ++y) {
                fallen_count += after.at(kPlaneMaterial, 23, y, z) / kMass;
            }
        }
        EXPECT_GT(fallen_count, 0) << volume;
        EXPECT_LT(fallen_count, kCount / 8) << volume;
    }
}

}  // namespace
}  // namespace bsoil::projectile_test
