// Soil that is brought to rest before a world starts.
#include <algorithm>

#include "test_box.h"

namespace bsoil::bullet::settling_test {
namespace {

TEST(Settling, takes_no_time_in_the_world_and_leaves_soil_at_rest) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    ASSERT_TRUE(soil->fill(BoxFill{{{-0.3, kBedTopM, -0.3}, {0.3, 0.8, 0.3}}, {}}));
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, btVector3(0.7f, 0.55f, 0.7f));
    box.setLinearVelocity(btVector3(0, 0, 1));
    const int64_t units = units_of(*soil);
    const auto settled = soil->settle(3000);
    ASSERT_TRUE(settled) << settled.error();
    EXPECT_TRUE(settled->is_at_rest);
    EXPECT_GT(settled->step_count, 10);
    EXPECT_EQ(soil->step_count(), settled->step_count);
    EXPECT_EQ(units_of(*soil), units);
    EXPECT_LT(soil->surface_at({0, 0, 0})->position_m.y, 0.78);
    EXPECT_EQ(box.getWorldTransform().getOrigin().z(), btScalar(0.7f));
    EXPECT_EQ(box.getLinearVelocity().z(), btScalar(1));
    // Nothing of the heap moves in the world's own steps.
    scene.remove(box);
    const uint64_t checksum = soil->soil().checksum();
    EXPECT_EQ(soil->settle()->step_count, 0);
    EXPECT_EQ(soil->soil().checksum(), checksum);
}

TEST(Settling, a_body_in_its_place_bears_from_the_first_substep) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    // 2 cm deep: more than enough for its weight.
    btRigidBody& box =
        scene.add_box(kMassKg, kHalfBox, btVector3(0, btScalar(kBedTopM) + btScalar(0.18), 0));
    ASSERT_TRUE(soil->settle(10));
    EXPECT_GT(soil->body_report(box).patch_count, 0);
    scene.run(1.0 / 60);
    EXPECT_GT(soil->body_report(box).force_n.y, 0.2 * kWeightN);
}

TEST(Settling, says_why_it_cannot) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    const auto refused = soil->settle(-1);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().find("steps_max"), std::string::npos) << refused.error();
    soil->set_enabled(false);
    const auto off = soil->settle();
    ASSERT_FALSE(off);
    EXPECT_NE(off.error().find("set_enabled"), std::string::npos) << off.error();
    EXPECT_EQ(soil->step_count(), 0);
}

// A playground of 62500 tiles: level ground costs no tile but those that something touches.
TEST(Settling, a_hundred_metres_of_level_ground_stay_asleep) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.size_m = {100, 2, 100};
    const auto soil = sand_bed(*scene.world, def);
    EXPECT_LT(soil->soil().memory_use().asleep_bytes, 8'000'000);
    const auto settled = soil->settle();
    ASSERT_TRUE(settled);
    EXPECT_TRUE(settled->is_at_rest);
    EXPECT_EQ(settled->tile_awake_count, 0);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove + btVector3(31, 0, 17));
    scene.run(0.2);
    EXPECT_LE(soil->last_report().tile_awake_count, 36);
    EXPECT_GT(soil->body_report(box).force_n.y, 0.2 * kWeightN);
}

// A ball sinks 11 um into soil of 105 kPa: the soil sees no depth, and its contacts bear nothing.
// It slept without a force, and slept on where the soil below it was taken out.
TEST(Settling, a_ball_on_soil_that_hardly_gives_way_sleeps_on_its_weight_and_wakes_without_it) {
    BulletScene scene;
    SoilDef def;
    def.size_m = {2, 2, 2};
    def.voxel_m = 0.1;
    def.backend = Backend::cpu;
    def.material.friction_angle_rad = 1.15;
    def.material.cohesion_pa = 105e3;
    def.material.loose_cohesion_fraction = 0.5;
    auto made = SoilAction::create(*scene.world, def);
    ASSERT_TRUE(made) << made.error();
    SoilAction& soil = **made;
    ASSERT_TRUE(soil.fill(BoxFill{{{-1, 0, -1}, {1, 0.8, 1}}, "dry_sand"}));
    btRigidBody& ball = scene.add(15, scene.shape<btSphereShape>(0.156f), {0, 1.2f, 0});
    scene.run(5);
    ASSERT_FALSE(ball.isActive());
    EXPECT_NEAR(soil.body_report(ball).force_n.y, 15 * 9.81, 0.02 * 15 * 9.81);
    const btScalar before_m = ball.getWorldTransform().getOrigin().y();
    ConvexShape hole;
    hole.half_extents_m = {0.4, 0.45, 0.4};
    ASSERT_TRUE(soil.soil().take_out(hole, {{0, 0.45, 0}, Quat{}}));
    scene.run(1);
    EXPECT_LT(ball.getWorldTransform().getOrigin().y(), before_m - 0.3f);
}

// Bullet's solver lifts the one patch and presses the other. What was lifted was forgotten, so a
// box rose by micrometres a substep until a patch let go, and rocked by 0.0026 rad/s; now 2e-5.
TEST(Settling, a_box_that_may_not_sleep_stands_still) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, btVector3(0.013f, 0.62f, 0.021f));
    box.setActivationState(DISABLE_DEACTIVATION);
    scene.run(4);
    const btScalar height_m = box.getWorldTransform().getOrigin().y();
    btScalar fastest_rad_s = 0;
    for (int frame = 0; frame < 240; ++frame) {
        scene.run(1.0 / 60);
        fastest_rad_s = std::max(fastest_rad_s, box.getAngularVelocity().length());
    }
    EXPECT_LT(fastest_rad_s, 5e-4f);
    EXPECT_NEAR(box.getWorldTransform().getOrigin().y(), height_m, 1e-5f);
}

}  // namespace
}  // namespace bsoil::bullet::settling_test
