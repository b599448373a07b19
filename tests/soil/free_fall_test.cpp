// Soil in free fall.
#include <algorithm>
#include <cstdint>

#include "soil/kernel_params.h"
#include "soil_fixture.h"

namespace bsoil::free_fall_test {
namespace {

using namespace layout;

struct Sums {
    int64_t mass = 0;
    double height = 0;  // of the centre of mass [voxels]
    int64_t momentum[3] = {0, 0, 0};
};

Sums sums_of(Soil& soil) {
    Soil::Impl& impl = SoilProbe::impl(soil);
    Sums sums;
    double moment = 0;
    TileVoxels voxels;
    for (size_t index = 0; index < impl.tiles.size(); ++index) {
        if (!impl.tiles[index]) continue;
        impl.tiles.read_voxels(static_cast<int>(index), voxels);
        for (int z = 0; z < impl.height; ++z) {
            for (int c = 0; c < kTileColumns; ++c) {
                for (int m = 0; m < impl.params.material_count; ++m) {
                    sums.mass += voxels.at(kKeptMaterial + m, z, c);
                    moment += (z + 0.5) * voxels.at(kKeptMaterial + m, z, c);
                }
                for (int axis = 0; axis < 3; ++axis) {
                    sums.momentum[axis] += voxels.at(kKeptMomentum + axis, z, c);
                }
            }
        }
    }
    sums.height = moment / static_cast<double>(sums.mass);
    return sums;
}

TEST(FreeFall, the_centre_of_mass_follows_g_t_squared_over_2) {
    for (double voxel_m : {0.1, 0.05}) {
        auto soil = make_soil(grid_def(24, 24, 64, voxel_m));
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {8.3, 8, 50}, {15, 15.6, 58.4})));
        const double start = sums_of(*soil).height;
        const SoilDef& def = soil->def();
        const double g = def.gravity_m_s2 * def.step_s * def.step_s / voxel_m;
        for (int step = 1; g * step * step / 2 < 40; ++step) {
            soil->step({});
            if (step % 5 == 0) {
                EXPECT_NEAR(start - sums_of(*soil).height, g * step * step / 2,
                            0.01 * g * step * step / 2)
                    << "step " << step;
            }
        }
    }
}

TEST(FreeFall, momentum_grows_by_m_g_dt_to_the_unit) {
    // Gravity of 56 momentum units a step for each mass unit, and a whole number of them in a half
    // step: nothing is lost in rounding. The fall stays below two voxels a step, so that a step has
    // two parts at most.
    constexpr int kGain = 56;
    SoilDef def = grid_def(24, 24, 64);
    def.gravity_m_s2 =
        static_cast<double>(kGain) / kVelocityOne * def.voxel_m / (def.step_s * def.step_s);
    auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(FunctionFill{[](Vec3 at) {
                                            return 0.21 - length(at - Vec3{0.6, 0.6, 2.8});
                                        },
                                        {}}));
    const int64_t mass = sums_of(*soil).mass;
    for (int64_t step = 1; step <= 34; ++step) {
        soil->step({});
        const Sums sums = sums_of(*soil);
        ASSERT_EQ(sums.momentum[2], -kGain * mass * step) << "step " << step;
        ASSERT_EQ(sums.momentum[0], 0);
        ASSERT_EQ(sums.momentum[1], 0);
        ASSERT_EQ(sums.mass, mass);
    }
}

// Of 3.2 units of 1/65536 voxel a step squared whole ones would be 7 % short; of 0.16 there are
// none.
TEST(FreeFall, is_as_fast_in_short_steps) {
    for (const double voxel_m : {0.05, 1.0}) {
        SoilDef def = grid_def(16, 16, 24, voxel_m);
        def.step_s = 1.0 / 2000;
        const auto soil = make_soil(def);
        ASSERT_TRUE(soil);
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {6, 6, 20}, {10, 10, 21})));
        constexpr int kSteps = 400;
        for (int i = 0; i < kSteps; ++i) soil->step({});
        const Sums sums = sums_of(*soil);
        const double speed =
            static_cast<double>(-sums.momentum[2]) / static_cast<double>(sums.mass) / kVelocityOne;
        const double expected = def.gravity_m_s2 * def.step_s * def.step_s / voxel_m * kSteps;
        // Half a unit of 64 in the larger voxels.
        EXPECT_NEAR(speed / expected, 1, 0.01) << voxel_m;
        EXPECT_EQ(sums.momentum[0], 0);
    }
}

// A plate that is struck has the soil on it go at 1.5 voxels a step at once, though it has hardly
// moved itself: the step has not enough parts for that, the next one has.
TEST(FreeFall, of_what_is_thrown_is_too_fast_only_beyond_all_parts_of_a_step) {
    for (const int most : {8, 1}) {
        SoilDef def = grid_def(16, 16, 48);
        def.substeps_max = most;
        auto soil = make_soil(def);
        std::vector<Mover> movers;
        movers.emplace_back(1, box_shape(Vec3{3, 3, 1} * kVoxel), Vec3{8, 8, 5} * kVoxel);
        soil->step(bodies_of(movers));
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {6, 6, 6}, {10, 10, 8})));
        for (int i = 0; i < 10; ++i) soil->step(bodies_of(movers));
        const double start = sums_of(*soil).height, speed = 1.5;  // voxels a step
        movers[0].set_velocity(Vec3{0, 0, speed} * kVoxel * 60);
        movers[0].advance(0.1 / 60);
        soil->step(bodies_of(movers));
        EXPECT_EQ(soil->status_bits(),
                  most == 1 ? static_cast<uint32_t>(StatusBit::speed_clamped) : 0u);
        movers[0].set_velocity({});
        double highest = start;
        for (int i = 0; i < 30; ++i) {
            soil->step(bodies_of(movers));
            highest = std::max(highest, sums_of(*soil).height);
        }
        const double g = def.gravity_m_s2 / (60 * 60 * kVoxel);
        if (most == 8) {
            EXPECT_NEAR(highest - start, speed * speed / (2 * g), 1);
        }
    }
}

// Usual steps have one value, short ones two.
TEST(FreeFall, has_the_mean_gravity_that_it_should) {
    for (const double step_s : {1.0 / 60, 1.0 / 240, 1.0 / 500, 1.0 / 1000, 1.0 / 2000}) {
        for (const double voxel_m : {0.02, 0.05, 0.3, 1.0}) {
            SoilDef def;
            def.step_s = step_s;
            def.voxel_m = voxel_m;
            const double exact = def.gravity_m_s2 * step_s * step_s / voxel_m * kVoxelFull;
            int64_t sum = 0;
            int32_t least = INT32_MAX, most = 0;
            constexpr int kSteps = 4000;
            for (int64_t step = 1; step <= kSteps; ++step) {
                const int32_t gravity = gravity_q16(def, step);
                sum += gravity;
                least = std::min(least, gravity);
                most = std::max(most, gravity);
            }
            const double mean = static_cast<double>(sum) / kSteps;
            EXPECT_NEAR(mean, exact, exact > 50 ? 0.01 * exact : std::max(0.01 * exact, 1e-3));
            EXPECT_LE(most - least, exact > 50 ? 0 : 1) << step_s << " s, " << voxel_m << " m";
        }
    }
}

// Thin soil runs ahead of a block and lies on the ground before it. Where slides ran out all that
// hung together above that was put on the ground at once: 0.27 m too low when a step was 16 ms
// long, 0.5 m when it was 2 ms.
TEST(FreeFall, goes_on_above_dust_on_the_ground) {
    for (const SlideMotion slides : {SlideMotion::settle, SlideMotion::run_out}) {
        for (const double step_s : {1.0 / 60, 1.0 / 500}) {
            SoilDef def = grid_def(16, 16, 32);
            def.slides = slides;
            def.step_s = step_s;
            auto soil = make_soil(def);
            ASSERT_TRUE(soil->fill(voxel_box(*soil, {4, 4, 0}, {12, 12, 0.02})));
            const auto of_dust = static_cast<double>(sums_of(*soil).mass);
            ASSERT_TRUE(soil->fill(voxel_box(*soil, {4, 4, 26}, {12, 12, 28})));
            const double start = sums_of(*soil).height;
            const double g = def.gravity_m_s2 * step_s * step_s / def.voxel_m;
            const double share = 1 - of_dust / static_cast<double>(sums_of(*soil).mass);
            for (int step = 1; g * step * step / 2 < 20; ++step) {
                soil->step({});
                ASSERT_NEAR(start - sums_of(*soil).height, share * g * step * step / 2, 0.5)
                    << "step " << step << " of " << step_s << " s, "
                    << (slides == SlideMotion::settle ? "settle" : "run_out");
            }
        }
    }
}

TEST(FreeFall, ends_at_rest_on_the_floor) {
    auto soil = make_soil(grid_def(24, 24, 32));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {8, 8, 20}, {16, 16, 26})));
    const SoilTotals before = soil->totals();
    StepReport report;
    for (int i = 0; i < 300; ++i) report = soil->step({});
    EXPECT_EQ(report.block_active_count, 0);
    EXPECT_EQ(soil->totals().units, before.units);
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(sums_of(*soil).momentum[axis], 0);
}

// Level ground, but that one column hangs over a gap of a voxel, each of its voxels too loose to be
// a span of falling soil: all eight columns beside it slide into the gap at once.
TEST(FreeFall, a_column_that_lost_its_support_takes_a_voxel_from_each_neighbour) {
    auto soil = make_soil(grid_def(16, 16, 24));
    const auto fill = [&soil](Vec3 low, Vec3 high) {
        ASSERT_TRUE(soil->fill(voxel_box(*soil, low, high)));
    };
    fill({0, 0, 0}, {16, 8, 20});
    fill({0, 9, 0}, {16, 16, 20});
    fill({0, 8, 0}, {8, 9, 20});
    fill({9, 8, 0}, {16, 9, 20});
    fill({8, 8, 0}, {9, 9, 4});
    for (int z = 5; z < 20; ++z) fill({8, 8, z * 1.0}, {9, 9, z + 0.9});
    for (int s = 0; s < 5; ++s) {
        soil->step({});
        double most = 0;
        for (int z = 0; z < 24; ++z) most = std::max(most, soil->sample(8, 8, z).volume);
        EXPECT_LT(most, 9) << "step " << s;
    }
}

}  // namespace
}  // namespace bsoil::free_fall_test
