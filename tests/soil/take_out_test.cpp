// Soil taken out of the world by hand, and what a sample says of its voxel.
#include <cmath>
#include <limits>

#include "soil_fixture.h"

namespace bsoil::take_out_test {
namespace {

/// 32 x 32 x 24 voxels of 5 cm, filled to 12.
std::unique_ptr<Soil> half_full() {
    SoilDef def = grid_def(32, 32, 24);
    def.material = fixed_density(materials::dry_sand());
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {32, 32, 12})));
    return soil;
}

Pose at(double x, double y, double z) { return {{x * 0.05, y * 0.05, z * 0.05}, {}}; }

TEST(TakeOut, returns_the_units_that_the_soil_has_less) {
    const auto soil = half_full();
    const int64_t before = soil->totals().units[0];
    const auto taken = soil->take_out(box_shape({0.2, 0.2, 0.1}), at(16, 16, 12));
    ASSERT_TRUE(taken) << taken.error();
    ASSERT_EQ(taken->size(), 1u);
    // 8 x 8 columns, two of four layers hold soil.
    EXPECT_EQ((*taken)[0], before / (32 * 32 * 12) * (8 * 8 * 2));
    EXPECT_EQ(soil->totals().units[0], before - (*taken)[0]);
    EXPECT_EQ(soil->sample(16, 16, 11).volume, 0);
    EXPECT_EQ(soil->sample(16, 16, 9).volume, 1);
    EXPECT_EQ(soil->sample(11, 16, 11).volume, 1);
    EXPECT_NEAR(soil->surface_height_m(16, 16), 0.5, 1e-9);
}

TEST(TakeOut, what_lost_its_hold_slides_and_nothing_gets_lost) {
    for (const bool awake : {false, true}) {
        SCOPED_TRACE(awake ? "awake" : "asleep");
        const auto soil = half_full();
        if (awake) {
            std::vector<Mover> movers;
            movers.emplace_back(1, sphere_shape(0.2), Vec3{0.8, 0.8, 0.6});
            for (int i = 0; i < 4; ++i) soil->step(bodies_of(movers));
        }
        const auto taken = soil->take_out(box_shape({0.25, 0.25, 0.4}), at(16, 16, 8));
        ASSERT_TRUE(taken);
        const int64_t left = soil->totals().units[0];
        const double hole_m = soil->surface_height_m(16, 16);
        EXPECT_EQ(hole_m, 0);
        for (int i = 0; i < 120; ++i) soil->step({});
        EXPECT_EQ(soil->totals().units[0], left);
        EXPECT_GT(soil->surface_height_m(16, 16), 0.05);  // its walls, 0.6 m high, have come down
        EXPECT_EQ(soil->status_bits(), 0u);
    }
}

TEST(TakeOut, soil_that_hung_over_the_hole_falls) {
    const auto soil = half_full();
    ASSERT_TRUE(soil->take_out(box_shape({0.2, 0.2, 0.1}), at(16, 16, 6)));
    EXPECT_EQ(soil->sample(16, 16, 11).volume, 1);
    for (int i = 0; i < 60; ++i) soil->step({});
    // A dip no deeper than the hole was, over soil without one.
    const double dip_m = 0.6 - soil->surface_height_m(16, 16);
    EXPECT_GT(dip_m, 0.005);
    EXPECT_LT(dip_m, 0.2);
    for (int z = 0; z < 8; ++z) EXPECT_GT(soil->sample(16, 16, z).volume, 0.75) << z;
}

/// Beside a body that pushes soil: the tile is awake, but nothing in it moves by itself.
TEST(TakeOut, what_lies_over_a_hole_in_soil_that_is_awake_falls) {
    const auto soil = half_full();
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape({0.1, 0.1, 0.1}), Vec3{0.6, 0.6, 0.65});
    movers[0].set_velocity({0.05, 0, 0});
    for (int i = 0; i < 10; ++i) {
        movers[0].advance(1.0 / 60);
        soil->step(bodies_of(movers));
    }
    ASSERT_EQ(soil->sample(18, 18, 11).volume, 1);
    // A flat hole: only the one beneath it tells the soil on top that it has lost its hold.
    ASSERT_TRUE(soil->take_out(box_shape({0.06, 0.06, 0.11}), at(18, 18, 2)));
    ASSERT_EQ(soil->sample(18, 18, 2).volume, 0);
    ASSERT_EQ(soil->sample(18, 18, 11).volume, 1);
    for (int i = 0; i < 60; ++i) {
        movers[0].advance(1.0 / 60);
        soil->step(bodies_of(movers));
    }
    for (int z = 0; z < 8; ++z) EXPECT_GT(soil->sample(18, 18, z).volume, 0.9) << z;
    EXPECT_LT(soil->sample(18, 18, 11).volume, 0.9);
}

TEST(TakeOut, nothing_changes_where_there_is_no_soil_or_the_region_is_bad) {
    const auto soil = half_full();
    const uint64_t before = soil->checksum();
    const auto air = soil->take_out(sphere_shape(0.2), at(16, 16, 20));
    ASSERT_TRUE(air);
    EXPECT_EQ((*air)[0], 0);
    EXPECT_FALSE(soil->take_out(sphere_shape(-1), at(16, 16, 6)));
    EXPECT_FALSE(
        soil->take_out(sphere_shape(0.2), {{0, 0, std::numeric_limits<double>::quiet_NaN()}, {}}));
    EXPECT_EQ(soil->checksum(), before);
}

TEST(Sample, says_what_was_moved_pushed_covered_and_active) {
    const auto soil = half_full();
    EXPECT_FALSE(soil->sample(16, 16, 11).is_active);
    EXPECT_EQ(soil->sample(16, 16, 11).body_coverage, 0);
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape({0.1, 0.2, 0.2}), Vec3{0.6, 0.8, 0.7});
    movers[0].set_velocity({0.6, 0, 0});
    double push_most = 0;
    for (int i = 0; i < 20; ++i) {
        movers[0].advance(1.0 / 60);
        soil->step(bodies_of(movers));
        for (int x = 16; x < 24; ++x) {
            push_most = std::max(push_most, length(soil->sample(x, 16, 10).push));
        }
    }
    const Vec3 center = movers[0].body.pose.position;
    const int x = static_cast<int>(center.x / 0.05);
    EXPECT_EQ(soil->sample(x, 16, 11).body_coverage, 1);
    EXPECT_TRUE(soil->sample(x + 3, 16, 11).is_active);
    EXPECT_FALSE(soil->sample(2, 2, 2).is_active);
    EXPECT_GT(push_most, 0);
    EXPECT_EQ(soil->sample(2, 2, 2).undisturbed, 1);
    bool some_moved = false;
    for (int z = 8; z < 20; ++z) {
        const VoxelSample before_blade = soil->sample(x + 3, 16, z);
        some_moved = some_moved || (before_blade.volume > 0 && before_blade.undisturbed < 0.5);
    }
    EXPECT_TRUE(some_moved);
}

}  // namespace
}  // namespace bsoil::take_out_test
