// Worlds whose soil is too slow for them: each of its steps is spread over several of Bullet's.
#include <algorithm>
#include <cmath>
#include <vector>

#include "bsoil/bullet/soil_raycaster.h"
#include "bsoil/bullet/world_snapshot.h"
#include "bullet_types.h"
#include "raycast_car.h"
#include "temporary_file.h"
#include "test_box.h"

namespace bsoil::bullet::slow_soil_test {
namespace {

/// Each call works on one piece of a step, the last one on all that is left: the same on every
/// machine, however fast.
SoilDef slow_bed(int spread) {
    SoilDef def = small_bed();
    def.step_budget_ms = 1e-6;
    def.step_spread_max = spread;
    return def;
}

/// Kinetic energy, and potential energy above the bed [J].
double energy_j(const btRigidBody& body) {
    const btVector3 omega = body.getAngularVelocity() * body.getWorldTransform().getBasis();
    const double mass_kg = 1 / static_cast<double>(body.getInvMass());
    return 0.5 * mass_kg * static_cast<double>(body.getLinearVelocity().length2()) +
           0.5 * static_cast<double>(omega.dot(body.getLocalInertia() * omega)) +
           mass_kg * kGravity_m_s2 * (height_of(body) - kBedTopM);
}

class SlowSoil : public testing::TestWithParam<int> {
  protected:
    int spread() const { return GetParam(); }
};

TEST_P(SlowSoil, bears_a_parked_body_as_a_fast_one_does) {
    BulletScene fast, slow;
    const auto fast_soil = sand_bed(*fast.world), soil = sand_bed(*slow.world, slow_bed(spread()));
    btRigidBody& reference = fast.add_box(kMassKg, kHalfBox, kAbove);
    btRigidBody& box = slow.add_box(kMassKg, kHalfBox, kAbove);
    for (btRigidBody* body : {&reference, &box}) body->setActivationState(DISABLE_DEACTIVATION);
    fast.run(4);
    slow.run(4);
    EXPECT_NEAR(height_of(box), height_of(reference), 0.1 * small_bed().voxel_m);
    const double before_m = height_of(box);
    double most_m = before_m, least_m = before_m;
    for (int i = 0; i < 600; ++i) {
        slow.run(1.0 / 60);
        most_m = std::max(most_m, height_of(box));
        least_m = std::min(least_m, height_of(box));
        ASSERT_GT(soil->body_report(box).patch_count, 0) << i;
    }
    EXPECT_LT(most_m - least_m, 1e-4);
    EXPECT_NEAR(mean_lift_n(slow, *soil, box), kWeightN, 0.01 * kWeightN);
    EXPECT_NEAR(soil->soil().step_rate().share(), 1.0 / spread(), 0.02);
}

// As in energy_test.cpp: what counts as a rise, and what all of them may give back. A body that
// comes down is held by the soil below it in each of Bullet's steps, whether the soil steps or not.
TEST_P(SlowSoil, never_adds_to_a_bodys_energy) {
    for (const btScalar fall_m : {btScalar(0), btScalar(0.5)}) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world, slow_bed(spread()));
        btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove + btVector3(0, fall_m, 0));
        box.setLinearVelocity(btVector3(1, 0, 0));
        box.setActivationState(DISABLE_DEACTIVATION);
        const double start_j = energy_j(box);
        double before_j = start_j, rises_j = 0;
        for (int i = 0; i < 180; ++i) {
            scene.run(1.0 / 60);
            const double now_j = energy_j(box);
            rises_j += std::max(0.0, now_j - before_j);
            before_j = now_j;
        }
        EXPECT_LT(rises_j, 1e-3 * (start_j - before_j)) << fall_m;
        EXPECT_GT(height_of(box), kBedTopM - 0.1) << fall_m;
        EXPECT_LT(before_j, start_j);
    }
}

TEST_P(SlowSoil, gives_way_to_what_is_pushed_and_is_conserved) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, slow_bed(spread()));
    const int64_t units = units_of(*soil);
    btRigidBody& blade = scene.add_box(0, btVector3(0.05f, 0.2f, 0.3f), btVector3(-0.6f, 0.45f, 0));
    blade.setCollisionFlags(blade.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    blade.setActivationState(DISABLE_DEACTIVATION);
    double resistance_n = 0;
    constexpr double kSpeed_m_s = 0.4;
    for (int i = 1; i <= 120; ++i) {
        place(blade, btVector3(btScalar(-0.6 + kSpeed_m_s / 60 * i), 0.45f, 0));
        blade.setInterpolationLinearVelocity(btVector3(btScalar(kSpeed_m_s), 0, 0));
        scene.run(1.0 / 60);
        if (i > 60) resistance_n -= soil->body_report(blade).force_n.x / 60;
    }
    EXPECT_GT(resistance_n, 50);
    EXPECT_GT(soil->surface_at({0.3, 0, 0})->position_m.y, kBedTopM + 0.05) << "a berm before it";
    EXPECT_LT(soil->surface_at({-0.2, 0, 0})->position_m.y, kBedTopM) << "a furrow behind it";
    EXPECT_EQ(units_of(*soil), units);
}

// What a bucket carries goes as far as the bucket.
TEST_P(SlowSoil, carries_soil_with_a_tray) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, slow_bed(spread()));
    auto& tray_shape = static_cast<btCompoundShape&>(scene.shape<btCompoundShape>());
    const auto add = [&](const btVector3& half, const btVector3& at) {
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(at);
        tray_shape.addChildShape(pose, &scene.shape<btBoxShape>(half));
    };
    add(btVector3(0.25f, 0.05f, 0.25f), btVector3(0, 0, 0));
    for (const btScalar side : {btScalar(-1), btScalar(1)}) {
        add(btVector3(0.05f, 0.15f, 0.25f), btVector3(side * 0.3f, 0.1f, 0));
        add(btVector3(0.35f, 0.15f, 0.05f), btVector3(0, 0.1f, side * 0.3f));
    }
    btRigidBody& tray = scene.add(0, tray_shape, btVector3(-0.4f, 0.6f, 0));
    tray.setCollisionFlags(tray.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    tray.setActivationState(DISABLE_DEACTIVATION);
    scene.run(0.2);
    ASSERT_TRUE(soil->fill(BoxFill{{{-0.6, 0.66, -0.2}, {-0.2, 0.76, 0.2}}, {}}));
    scene.run(1);
    const double before_kg = soil->body_report(tray).load_kg;
    EXPECT_GT(before_kg, 10);
    for (int i = 1; i <= 96; ++i) {
        place(tray, btVector3(btScalar(-0.4 + 0.5 / 60 * i), 0.6f, 0));
        tray.setInterpolationLinearVelocity(btVector3(0.5f, 0, 0));
        scene.run(1.0 / 60);
    }
    tray.setInterpolationLinearVelocity(btVector3(0, 0, 0));
    scene.run(0.5);
    // Set in motion within one call it loses some over its walls, more where a step has more calls.
    // This budget has room for one sub-step, however many voxels the tray crosses in it.
    EXPECT_GT(soil->body_report(tray).load_kg, (spread() > 4 ? 0.7 : 0.85) * before_kg);
}

TEST_P(SlowSoil, lets_bodies_come_and_go_while_it_works) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, slow_bed(spread()));
    const int64_t units = units_of(*soil);
    btRigidBody& stays = scene.add_box(kMassKg, kHalfBox, kAbove + btVector3(0.5f, 0, 0));
    for (int i = 0; i < 40; ++i) {
        btRigidBody& box =
            scene.add_box(kMassKg, btVector3(0.1f, 0.1f, 0.1f) * btScalar(1 + i % 3), kAbove);
        scene.run((1 + i % 7) / 60.0);
        scene.remove(box);
        scene.shapes.pop_back();
    }
    scene.run(1);
    // A box that is put into soil falls until a step has seen it, and pulls down what it touches:
    // 1 mm without a budget, 2 and 5 cm with two and four calls a step, 24 cm with eight.
    EXPECT_GT(height_of(stays), kBedTopM + 0.2 - (spread() > 4 ? 0.3 : 0.1));
    EXPECT_EQ(units_of(*soil), units);
    soil->set_enabled(false);
    scene.run(0.1);
    soil->set_enabled(true);
    scene.run(0.1);
    EXPECT_EQ(units_of(*soil), units);
}

// Whoever asks for the whole soil has it finish the step in progress.
TEST_P(SlowSoil, reports_no_contacts_of_before_a_step_that_others_have_had_finished) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, slow_bed(spread()));
    scene.add_box(kMassKg, kHalfBox, kAbove - btVector3(0, 0.02f, 0));
    scene.run(0.1);
    while (!soil->soil().is_stepping() || soil->last_report().contacts.empty()) {
        scene.run(1.0 / 60);
    }
    units_of(*soil);
    EXPECT_TRUE(soil->last_report().contacts.empty());
    scene.run(spread() / 60.0);
    EXPECT_FALSE(soil->last_report().contacts.empty());
}

TEST_P(SlowSoil, goes_on_from_a_snapshot) {
    const auto build = [&](BulletScene& scene) {
        auto soil = sand_bed(*scene.world, slow_bed(spread()));
        scene.add_box(kMassKg, kHalfBox, kAbove).setActivationState(DISABLE_DEACTIVATION);
        return soil;
    };
    BulletScene scene, other;
    const auto soil = build(scene), restored = build(other);
    const TemporaryFile file("slow_soil.snapshot");
    scene.run(1);
    while (!soil->soil().is_stepping()) scene.run(1.0 / 60);
    ASSERT_TRUE(soil->soil().is_stepping());
    SoilAction* const from[] = {soil.get()};
    SoilAction* const to[] = {restored.get()};
    const Status saved = save_world(*scene.world, from, file.path());
    ASSERT_TRUE(saved) << saved.error();
    other.run(0.5);
    const Status loaded = load_world(*other.world, to, file.path());
    ASSERT_TRUE(loaded) << loaded.error();
    EXPECT_FALSE(restored->soil().is_stepping());
    EXPECT_EQ(restored->soil().checksum(), soil->soil().checksum());
    const double height_m = height_of(*scene.bodies[0]);
    EXPECT_EQ(height_of(*other.bodies[0]), height_m);
    other.run(3);
    EXPECT_NEAR(height_of(*other.bodies[0]), height_m, 0.1 * small_bed().voxel_m);
    EXPECT_EQ(units_of(*restored), units_of(*soil));
}

TEST_P(SlowSoil, bears_a_car_on_rays) {
    BulletScene scene;
    SoilDef def = slow_bed(spread());
    def.size_m = {8, 1, 3};
    const auto soil = sand_bed(*scene.world, def);
    SoilRaycaster caster(*soil);
    Car car(scene, caster, 800,
            btVector3(-2.5f, btScalar(kBedTopM) + 0.2f + Car::kRestM + 0.35f, 0));
    ASSERT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = 0.3}));
    scene.run(2);
    const double start_m = car.wheel_height_m(0);
    EXPECT_GT(start_m, kBedTopM + static_cast<double>(Car::kRadiusM) - 0.04);
    EXPECT_NEAR(car.suspension_n(), 800 * kGravity_m_s2, 80 * kGravity_m_s2);
    // Once it rolls, where eight calls make a step, its wheels run off the contacts that they have.
    if (spread() > 4) return;
    car.drive(2000);
    scene.run(1.5);
    EXPECT_GT(car.x(), -2.2);
    EXPECT_GT(car.wheel_height_m(0), start_m - 0.02);
    EXPECT_LT(car.wheel_height_m(0), start_m + 0.05);
}

// The wheels come to the end of the list of bodies, which may move it in memory. Only a sanitizer
// sees a look at where it was.
TEST(SlowSoilUnderCar, meets_bodies_that_come_between_two_steps) {
    BulletScene scene;
    SoilDef def = slow_bed(8);
    def.size_m = {4, 1, 2};
    def.voxel_m = 0.1;
    const auto soil = sand_bed(*scene.world, def);
    SoilRaycaster caster(*soil);
    Car car(scene, caster, 800,
            btVector3(0, btScalar(kBedTopM) + 0.2f + Car::kRestM + Car::kRadiusM, 0));
    ASSERT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = 0.3}));
    while (!soil->soil().is_stepping()) scene.run(1.0 / 60);
    // One meets the soil in each frame.
    std::vector<btRigidBody*> boxes;
    for (int i = 0; i < 5; ++i) {
        const btVector3 at(btScalar(0.2 * i - 0.4), btScalar(kBedTopM + 0.06 + 0.03 * i), 0);
        boxes.push_back(&scene.add_box(5, btVector3(0.05f, 0.05f, 0.05f), at));
        boxes.back()->setLinearVelocity(btVector3(0, -2, 0));
    }
    scene.run(0.2);
    // If nothing held them, they would be below 0.
    for (const btRigidBody* box : boxes) EXPECT_GT(height_of(*box), 0.1);
    EXPECT_GT(car.wheel_height_m(0), kBedTopM + 0.2);
}

INSTANTIATE_TEST_SUITE_P(CallsAStep, SlowSoil, testing::Values(2, 4, 8));

}  // namespace
}  // namespace bsoil::bullet::slow_soil_test
