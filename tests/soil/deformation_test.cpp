// Force application (33) and force propagation (34), (35) against the oracle.
#include "oracle/deformation.h"

#include "stage_scenario.h"

namespace bsoil::deformation_test {
namespace {

using namespace layout;

class Deformation : public Stage {};

double angle_between(Vec3 a, Vec3 b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

TEST_P(Deformation, force_application_follows_the_oracle) {
    StageBench& bench = prepared(Backend::cpu);
    const oracle::Field before = bench.to_field(bench.read());
    const oracle::Field expected =
        oracle::apply_force(bench.model(), before, bench.oracle_bodies());
    bench.apply_force();
    const oracle::Field got = bench.to_field(bench.read());
    int pushed_count = 0, inexact_count = 0;
    before.for_each([&](int x, int y, int z) {
        const Vec3 a = got.at(x, y, z).force, b = expected.at(x, y, z).force;
        ASSERT_EQ(length(a) > 0, length(b) > 0) << x << " " << y << " " << z;
        if (length(b) > 0) {
            // Q10 components cut off below: 1/1024 each of a vector of length 1 or more. The way
            // out of a wall is a mean over the voxels around; where they nearly cancel, it is
            // shorter.
            const double angle = angle_between(a, b);
            EXPECT_LT(angle, 0.01) << x << " " << y << " " << z;
            inexact_count += angle > 0.003;
            ++pushed_count;
        }
    });
    EXPECT_GT(pushed_count, 5);
    EXPECT_LE(inexact_count, pushed_count / 100 + 1);
}

TEST_P(Deformation, force_propagation_follows_the_oracle) {
    StageBench& bench = prepared(Backend::cpu);
    bench.apply_force();
    const oracle::Field before = bench.to_field(bench.read());
    const oracle::Model model = bench.model();
    const oracle::Field expected = oracle::propagate_force(model, before, bench.oracle_bodies());
    bench.propagate_force();
    const oracle::Field got = bench.to_field(bench.read());
    const FieldDeviation deviation = compare(got, expected, GetParam().material_count);
    // A transfer is rounded down five times (share of the excess, three overlaps, the amount): at
    // most 5 units of 65536 for each voxel's worth of soil. A voxel sends to 7 and gets from
    // 26; 2.5 voxels' worth in one at most.
    constexpr double kTolerance = 5.0 * 33 * 2.5 / kVoxelFull;
    EXPECT_LT(deviation.soil.value, kTolerance) << deviation.soil;
    EXPECT_LT(deviation.mass.value, kTolerance) << deviation.mass;
    EXPECT_LT(deviation.momentum.value, kTolerance) << deviation.momentum;
    int arrived_count = 0;
    before.for_each([&](int x, int y, int z) {
        const double arrived = length(expected.at(x, y, z).force);
        const double left_over = oracle::excess(model, expected.at(x, y, z));
        // What a voxel was pushed by before stays in the sum with the weight of 1/4096 voxel (16
        // units), and each of some arrivals is rounded down by up to as much: 2 % of what arrives
        // from 1/20 on. Near the threshold of excess rounding decides whether (35) keeps the force.
        if (arrived > 0.05 && std::abs(left_over) > kTolerance) {
            const Vec3 force = got.at(x, y, z).force;
            if (left_over > 0) {
                EXPECT_LT(angle_between(force, expected.at(x, y, z).force), 0.02)
                    << x << " " << y << " " << z;
            } else {
                EXPECT_EQ(length(force), 0) << x << " " << y << " " << z;  // (35), second case
            }
            ++arrived_count;
        }
    });
    EXPECT_GT(arrived_count, 5);
}

// A tipping bucket's corner once gathered 18 voxels of soil in one.
TEST(PressedSoil, takes_no_more_from_pushes_that_meet_in_it) {
    StageBench bench(all_scenarios().front().def());
    StatePlanes planes = bench.empty_planes();
    constexpr int kMiddle = 8;
    const auto put = [&](int x, int y, int z, int volume, const int(&force)[3]) {
        planes.at(kPlaneVolume, x, y, z) = planes.at(kPlaneMaterial, x, y, z) = volume;
        for (int axis = 0; axis < 3; ++axis) {
            planes.at(kPlaneForceX + axis, x, y, z) = force[axis] * kForceOne;
        }
    };
    put(kMiddle, kMiddle, kMiddle, kCrowdedLeast + 1, {0, 0, 0});
    for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {-1, 1}) {
            int at[3] = {kMiddle, kMiddle, kMiddle}, force[3] = {0, 0, 0};
            at[axis] += side;
            force[axis] = -side;
            put(at[0], at[1], at[2], 6 * kVoxelFull, force);
        }
    }
    bench.write(planes);
    bench.apply_force();
    bench.propagate_force();
    EXPECT_EQ(bench.read().at(kPlaneVolume, kMiddle, kMiddle, kMiddle), kCrowdedLeast + 1);
}

// Six neighbours with eight voxels each push into one without soil. By hand: 6 * 16 / 8. It got
// 6 * 7, since each keeps what it has room for.
TEST(PressedSoil, gets_no_more_than_fits_from_pushes_that_meet_at_once) {
    StageBench bench(all_scenarios().front().def());
    StatePlanes planes = bench.empty_planes();
    constexpr int kMiddle = 8;
    for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {-1, 1}) {
            int at[3] = {kMiddle, kMiddle, kMiddle};
            at[axis] += side;
            planes.at(kPlaneVolume, at[0], at[1], at[2]) = 8 * kVoxelFull;
            planes.at(kPlaneMaterial, at[0], at[1], at[2]) = 8 * kVoxelFull;
            planes.at(kPlaneForceX + axis, at[0], at[1], at[2]) = -side * kForceOne;
        }
    }
    bench.write(planes);
    bench.apply_force();
    bench.propagate_force();
    EXPECT_NEAR(bench.read().at(kPlaneVolume, kMiddle, kMiddle, kMiddle), 12 * kVoxelFull, 100);
}

TEST_P(Deformation, has_the_same_bits_on_gl) {
    expect_same_on_gl([](StageBench& bench) {
        bench.apply_force();
        for (int i = 0; i < 4; ++i) bench.propagate_force();
        return bench.read();
    });
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Deformation, testing::ValuesIn(all_scenarios()),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil::deformation_test
