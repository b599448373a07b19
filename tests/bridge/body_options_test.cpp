// What a host may say about a body, before and while the soil runs.
#include <limits>
#include <new>
#include <string>

#include "test_box.h"

namespace bsoil::bullet::body_options_test {
namespace {

TEST(BodyOptions, defaults_are_what_an_object_has_without_any) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    const BodyOptions known = soil->options(box);
    EXPECT_FALSE(known.ignored);
    EXPECT_FALSE(known.coverage_only);
    EXPECT_LT(known.surface.friction, 0);
}

TEST(BodyOptions, ignored_at_run_time_falls_through_and_is_held_again) {
    BulletScene scene;
    SoilActionDef without_ground;
    without_ground.ground = false;
    const auto soil = sand_bed(*scene.world, small_bed(), without_ground);
    const int64_t before = units_of(*soil);
    btRigidBody& box = sleeping_box(scene);
    ASSERT_TRUE(soil->set_options(box, {.ignored = true}));
    EXPECT_TRUE(soil->options(box).ignored);
    scene.run(0.25);
    // It was asleep: let go, it has to fall, but for the step in which it is woken.
    EXPECT_NEAR(box.getLinearVelocity().y(), -0.25 * kGravity_m_s2, 3 * kGravity_m_s2 / 60);
    EXPECT_EQ(soil->body_id(box), -1);
    EXPECT_EQ(length(soil->body_report(box).force_n), 0);
    place(box, kAbove);
    box.setLinearVelocity(btVector3(0, 0, 0));
    ASSERT_TRUE(soil->set_options(box, {}));
    scene.run(2);
    EXPECT_NEAR(mean_lift_n(scene, *soil, box), kWeightN, 0.01 * kWeightN);
    EXPECT_EQ(units_of(*soil), before);
}

TEST(BodyOptions, ignored_at_run_time_rests_on_the_ground_and_is_held_again) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = sleeping_box(scene);
    const btScalar height = box.getWorldTransform().getOrigin().y();
    ASSERT_TRUE(soil->set_options(box, {.ignored = true}));
    scene.run(2);
    EXPECT_EQ(length(soil->body_report(box).force_n), 0);
    EXPECT_NEAR(box.getWorldTransform().getOrigin().y(), height, 0.05);
    ASSERT_TRUE(soil->set_options(box, {}));
    box.activate();
    scene.run(2);
    EXPECT_NEAR(mean_lift_n(scene, *soil, box), kWeightN, 0.01 * kWeightN);
}

// Its pair with the ground goes on, without contacts, and must not wake it.
TEST(BodyOptions, held_again_after_a_rest_on_the_ground_it_falls_asleep) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.size_m = {1.2, 0.8, 1.2};
    def.voxel_m = 0.1;
    const auto soil = sand_bed(*scene.world, def);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    ASSERT_TRUE(soil->set_options(box, {.ignored = true}));
    scene.run(0.5);
    ASSERT_NEAR(height_of(box), kBedTopM + static_cast<double>(kHalf), 0.02);
    ASSERT_TRUE(soil->set_options(box, {}));
    scene.run(5);
    EXPECT_FALSE(box.isActive());
    EXPECT_NEAR(soil->body_report(box).force_n.y, kWeightN, 0.1 * kWeightN);
}

TEST(BodyOptions, coverage_only_moves_soil_and_feels_none) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, btVector3(0, 0.7f, 0));
    ASSERT_TRUE(soil->set_options(box, {.coverage_only = true}));
    const double time_s = 0.3;
    scene.run(time_s);
    EXPECT_NEAR(box.getLinearVelocity().y(), -time_s * kGravity_m_s2, 1e-3);
    EXPECT_EQ(scene.world->getNumConstraints(), 0);
    // The box covers this voxel now, so that the soil that was there is elsewhere.
    const double bottom_m = height_of(box) - static_cast<double>(kHalf);
    ASSERT_LT(bottom_m, kBedTopM - 0.1);
    const Vec3 at = soil->soil().frame().to_grid({0.025, bottom_m + 0.075, 0.025});
    EXPECT_LT(soil->soil()
                  .sample(static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z))
                  .volume,
              0.05);
    EXPECT_GT(soil->body_report(box).force_n.y, kWeightN) << "the report is that of its motion";
}

TEST(BodyOptions, coverage_only_is_reversible) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = sleeping_box(scene);
    ASSERT_TRUE(soil->set_options(box, {.coverage_only = true}));
    scene.run(0.1);
    EXPECT_LT(box.getLinearVelocity().y(), -0.5f);
    ASSERT_TRUE(soil->set_options(box, {}));
    scene.run(2);
    EXPECT_NEAR(mean_lift_n(scene, *soil, box), kWeightN, 0.01 * kWeightN);
}

TEST(BodyOptions, surface_decides_how_a_body_slides) {
    // A pull of 0.4 of its weight: more than a friction of 0.2 holds, less than one of 0.6.
    double way_m[2];
    const double frictions[2] = {0.2, 0.6};
    for (int i = 0; i < 2; ++i) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world);
        btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
        ASSERT_TRUE(soil->set_options(box, {.surface = {frictions[i], 0}}));
        scene.run(1);
        const btScalar from = box.getWorldTransform().getOrigin().x();
        for (int frame = 0; frame < 30; ++frame) {
            box.activate();
            box.applyCentralForce(btVector3(btScalar(0.4 * kWeightN), 0, 0));
            scene.run(1.0 / 60);
        }
        way_m[i] = static_cast<double>(box.getWorldTransform().getOrigin().x() - from);
    }
    EXPECT_GT(way_m[0], 0.1);
    EXPECT_LT(way_m[1], 0.02);
}

TEST(BodyOptions, bad_ones_are_refused_by_field_and_change_nothing) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    ASSERT_TRUE(soil->set_options(box, {.surface = {0.3, 0}}));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const double bad : {nan, 2.5, std::numeric_limits<double>::infinity()}) {
        const Status refused = soil->set_options(box, {.ignored = true, .surface = {bad, 0}});
        ASSERT_FALSE(refused) << bad;
        EXPECT_NE(refused.error().find("SurfaceFriction::friction"), std::string::npos)
            << refused.error();
    }
    const Status refused = soil->set_options(box, {.surface = {0.3, 1e6}});
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().find("SurfaceFriction::adhesion_pa"), std::string::npos)
        << refused.error();
    EXPECT_EQ(soil->options(box).surface.friction, 0.3);
    EXPECT_FALSE(soil->options(box).ignored);
}

TEST(BodyOptions, null_among_the_ignored_is_refused) {
    BulletScene scene;
    SoilActionDef options;
    options.ignored = {nullptr};
    const auto soil = SoilAction::create(*scene.world, small_bed(), options);
    ASSERT_FALSE(soil);
    EXPECT_NE(soil.error().find("ignored[0]"), std::string::npos) << soil.error();
}

TEST(BodyOptions, wait_for_the_object_and_end_when_it_leaves) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    scene.world->removeRigidBody(&box);
    ASSERT_TRUE(soil->set_options(box, {.ignored = true}));
    scene.run(0.1);
    scene.world->addRigidBody(&box);
    scene.run(0.1);
    EXPECT_TRUE(soil->options(box).ignored);
    EXPECT_EQ(soil->body_id(box), -1);
    scene.world->removeRigidBody(&box);
    EXPECT_FALSE(soil->options(box).ignored);
    scene.world->addRigidBody(&box);
    EXPECT_FALSE(soil->options(box).ignored);
    place(box, kAbove);
    scene.run(0.1);
    EXPECT_NE(soil->body_id(box), -1);
}

TEST(BodyOptions, do_not_pass_to_a_new_object_at_the_old_address) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btCollisionShape& shape = scene.shape<btBoxShape>(kHalfBox);
    alignas(16) unsigned char room[sizeof(btRigidBody)];
    const auto build = [&] {
        auto* body = new (room) btRigidBody(kMassKg, nullptr, &shape, btVector3(1, 1, 1));
        place(*body, kAbove);
        scene.world->addRigidBody(body);
        return body;
    };
    btRigidBody* first = build();
    ASSERT_TRUE(soil->set_options(*first, {.ignored = true}));
    scene.run(0.1);
    ASSERT_EQ(soil->body_id(*first), -1);
    scene.world->removeRigidBody(first);
    first->~btRigidBody();
    btRigidBody* second = build();
    scene.run(1);
    EXPECT_NE(soil->body_id(*second), -1);
    EXPECT_GT(height_of(*second), kBedTopM) << "held by the soil";
    scene.world->removeRigidBody(second);
    second->~btRigidBody();
}

// A body that never enters the world, and another at its address.
TEST(BodyOptions, that_wait_are_forgotten_by_the_defaults) {
    for (const bool forgets : {false, true}) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world);
        btCollisionShape& shape = scene.shape<btBoxShape>(kHalfBox);
        alignas(16) unsigned char room[sizeof(btRigidBody)];
        auto* first = new (room) btRigidBody(kMassKg, nullptr, &shape, btVector3(1, 1, 1));
        ASSERT_TRUE(soil->set_options(*first, {.ignored = true}));
        if (forgets) {
            ASSERT_TRUE(soil->set_options(*first, {}));
        }
        first->~btRigidBody();
        auto* second = new (room) btRigidBody(kMassKg, nullptr, &shape, btVector3(1, 1, 1));
        place(*second, kAbove);
        scene.world->addRigidBody(second);
        scene.run(0.1);
        EXPECT_EQ(soil->options(*second).ignored, !forgets);
        EXPECT_EQ(soil->body_id(*second) >= 0, forgets);
        scene.world->removeRigidBody(second);
        second->~btRigidBody();
    }
}

}  // namespace
}  // namespace bsoil::bullet::body_options_test
