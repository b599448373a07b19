// Soil that becomes another soil under bodies that lie on it.
#include <cmath>

#include "test_box.h"

namespace bsoil::bullet::soil_change_test {
namespace {

SoilDef bed_of(double friction_rad, double tool_friction) {
    SoilDef def = small_bed();
    def.material.friction_angle_rad = friction_rad;
    def.material.tool_friction = tool_friction;
    return def;
}

// 40 kPa under a box of 0.4 m: at 15 deg soil bears a fifth to a ninth of what it does at 34 deg
// (Nq 3.9 and 29, Ngamma 1.1 and 29). So the box has to go down several times as far.
TEST(SoilChange, wakes_what_sleeps_on_it_and_lets_it_sink) {
    constexpr btScalar kHeavyKg = 650;
    constexpr double kHeavyN = 650 * kGravity_m_s2;
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, bed_of(0.6, 0.4));
    btRigidBody& box = scene.add_box(kHeavyKg, kHalfBox, btVector3(0, btScalar(0.6), 0));
    scene.run(8);
    ASSERT_FALSE(box.isActive());
    const double before_m = kBedTopM + 0.2 - height_of(box);
    ASSERT_TRUE(soil->soil().change(bed_of(0.26, 0.2)));
    scene.run(8);
    const double after_m = kBedTopM + 0.2 - height_of(box);
    EXPECT_GT(after_m, 3 * before_m);
    EXPECT_NEAR(soil->body_report(box).force_n.y, kHeavyN, 0.02 * kHeavyN);

    BulletScene other;
    const auto weak = sand_bed(*other.world, bed_of(0.26, 0.2));
    btRigidBody& there = other.add_box(kHeavyKg, kHalfBox, btVector3(0, btScalar(0.6), 0));
    other.run(16);
    EXPECT_NEAR(after_m, kBedTopM + 0.2 - height_of(there), 0.25 * after_m);
}

// Pulled by 0.3 of its weight it stays where friction with the soil is 0.5, and slides where it is
// 0.1.
TEST(SoilChange, is_felt_by_a_body_that_is_pulled) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, bed_of(0.6, 0.5));
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, btVector3(-0.4f, btScalar(0.61), 0));
    scene.run(2);
    const auto pull = [&](double seconds) {
        const btScalar from = box.getWorldTransform().getOrigin().x();
        for (int i = 0; i < std::lround(60 * seconds); ++i) {
            box.activate();
            box.applyCentralForce(btVector3(btScalar(0.3 * kWeightN), 0, 0));
            scene.run(1.0 / 60);
        }
        return static_cast<double>(box.getWorldTransform().getOrigin().x() - from);
    };
    const double held_m = pull(0.5);
    ASSERT_TRUE(soil->soil().change(bed_of(0.6, 0.1)));
    const double slid_m = pull(0.5);
    EXPECT_LT(held_m, 0.03);
    EXPECT_GT(slid_m, held_m + 0.05);
}

}  // namespace
}  // namespace bsoil::bullet::soil_change_test
