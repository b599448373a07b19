// How long a world is given to come to rest.
#include <gtest/gtest.h>

#include "built_world.h"
#include "run_plan.h"

namespace bsoil::random_worlds::rest_time_test {
namespace {

constexpr double kQuickS = 15;

/// A bed with a slab of soil 1.5 m above it, which air lets fall at this speed.
WorldPlan slab_in_the_air(double fall_speed_m_s) {
    WorldPlan plan;
    SoilPlan soil;
    soil.def.size_m = {0.8, 0.8, 2.4};
    soil.def.voxel_m = 0.1;
    soil.def.up = UpAxis::z;
    soil.def.backend = Backend::cpu;
    soil.def.materials = {materials::dry_sand()};
    soil.def.materials[0].fall_speed_m_s = fall_speed_m_s;
    soil.fills.push_back({.low_m = {}, .high_m = {0.8, 0.8, 0.4}});
    soil.fills.push_back({.low_m = {0, 0, 1.9}, .high_m = {0.8, 0.8, 2}, .is_hanging = true});
    plan.soils.push_back(soil);
    plan.action_steps = 5;
    return plan;
}

TEST(RestTime, is_longer_where_soil_falls_slowly) {
    const WorldPlan plan = slab_in_the_air(0.08);
    BuiltWorld world(plan);
    ASSERT_EQ(world.error(), "");
    while (world.time_s() < kQuickS + 1) world.step();
    EXPECT_FALSE(world.is_all_asleep());
    for (const Failure& failure : run_plan(plan, Run::watched)) ADD_FAILURE() << text_of(failure);
}

TEST(RestTime, is_longer_where_wide_banks_drain) {
    WorldPlan plan = slab_in_the_air(0);
    plan.soils[0].def.open_sides = kOpenLowX;
    EXPECT_DOUBLE_EQ(rest_s(plan), kQuickS);
    plan.soils[0].def.size_m.x = 3.8;
    EXPECT_GT(rest_s(plan), 29.2);
    plan.soils[0].def.open_sides = kOpenHighZ;  // its top
    EXPECT_DOUBLE_EQ(rest_s(plan), kQuickS);
}

TEST(RestTime, is_longer_where_groundwater_wets_a_bank) {
    WorldPlan plan = slab_in_the_air(0);
    SoilDef& def = plan.soils[0].def;
    def.water_table_m = 0.3;
    def.materials[0].pore_water_fraction = 0.2;
    EXPECT_DOUBLE_EQ(rest_s(plan), kQuickS);
    def.open_sides = kOpenLowX;
    EXPECT_DOUBLE_EQ(rest_s(plan), 60);
    def.water_table_m = 0;
    EXPECT_DOUBLE_EQ(rest_s(plan), kQuickS);
}

// A bank of 19 columns of 32 cm that runs out rests after 241 s with viscosity 0.75, 64 s where it
// settles (docs/decisions/rest.md).
TEST(RestTime, is_longer_where_soil_is_viscous) {
    WorldPlan plan = slab_in_the_air(0);
    SoilDef& def = plan.soils[0].def;
    def.size_m = {19 * 0.32, 4 * 0.32, 14 * 0.32};
    def.voxel_m = 0.32;
    def.materials[0].viscosity = 0.75;
    EXPECT_GT(rest_s(plan), 64.1);
    EXPECT_LT(rest_s(plan), 100);
    def.slides = SlideMotion::run_out;
    EXPECT_GT(rest_s(plan), 241);
    def.materials[0].viscosity = 0;
    EXPECT_DOUBLE_EQ(rest_s(plan), kQuickS);
}

TEST(RestTime, goes_by_the_speed_that_wind_leaves) {
    EXPECT_DOUBLE_EQ(rest_s(slab_in_the_air(0)), kQuickS);
    WorldPlan plan = slab_in_the_air(0.08);
    const double fall_s = rest_s(plan) - kQuickS;
    EXPECT_GT(fall_s, 2.4 / 0.08);
    EXPECT_LT(fall_s, 4 * 2.4 / 0.08);
    Vec3& wind_m_s = plan.soils[0].def.wind_m_s;
    wind_m_s = {1, 0, -0.04};  // there may be shelter from it
    EXPECT_DOUBLE_EQ(rest_s(plan), kQuickS + fall_s);
    wind_m_s = {1, 0, 0.04};
    EXPECT_DOUBLE_EQ(rest_s(plan), kQuickS + 2 * fall_s);
    wind_m_s = {1, 0, 0.08};  // it stays up
    EXPECT_DOUBLE_EQ(rest_s(plan), kQuickS);
}

}  // namespace
}  // namespace bsoil::random_worlds::rest_time_test
