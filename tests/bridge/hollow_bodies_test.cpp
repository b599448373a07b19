// Bodies that have soil in them, or between their legs, and come down on other soil.
#include <gtest/gtest.h>

#include "bullet_scene.h"
#include "sand_bed.h"

namespace bsoil::bullet::hollow_bodies_test {
namespace {

/// Centre and half sides of a box that is a part of a body.
struct Part {
    btVector3 center, half;
};

btRigidBody& add(BulletScene& scene, std::initializer_list<Part> parts, btScalar mass_kg,
                 double height_m) {
    auto& compound = static_cast<btCompoundShape&>(scene.shape<btCompoundShape>());
    for (const Part& part : parts) {
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(part.center);
        compound.addChildShape(pose, &scene.shape<btBoxShape>(part.half));
    }
    return scene.add(mass_kg, compound, {0, btScalar(height_m), 0});
}

constexpr double kBucketHalfM = 0.3;

/// Open on top, 0.6 m each way, 50 kg; its bottom lies at this height.
btRigidBody& add_bucket(BulletScene& scene, double bottom_m) {
    constexpr auto h = btScalar(kBucketHalfM), t = btScalar(0.05);
    return add(scene,
               {{{0, t - h, 0}, {h, t, h}},
                {{t - h, 0, 0}, {t, h, h}},
                {{h - t, 0, 0}, {t, h, h}},
                {{0, 0, t - h}, {h, h, t}},
                {{0, 0, h - t}, {h, h, t}}},
               50, bottom_m + kBucketHalfM);
}

double bottom_of(const btRigidBody& bucket) { return height_of(bucket) - kBucketHalfM; }

void fill_bucket(SoilAction& soil, const btRigidBody& bucket) {
    const double y = height_of(bucket);
    ASSERT_TRUE(soil.fill(BoxFill{{{-0.2, y - 0.2, -0.2}, {0.2, y + 0.2, 0.2}}, {}}));
}

SoilDef tall_bed() {
    SoilDef def = small_bed();
    def.size_m = {2, 3, 2};
    return def;
}

// Its own soil is not what it falls on. In free fall it has no weight, so that for a step it is
// nobody's load; the bucket stopped then, and slept in the air.
TEST(HollowBodies, bucket_with_soil_falls_to_the_ground) {
    for (const double drop_m : {0.2, 0.5, 1.0}) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world, tall_bed());
        btRigidBody& bucket = add_bucket(scene, kBedTopM + drop_m);
        btPoint2PointConstraint joint(bucket, btVector3(0, btScalar(kBucketHalfM), 0));
        scene.world->addConstraint(&joint);
        fill_bucket(*soil, bucket);
        scene.run(0.5, 4);
        scene.world->removeConstraint(&joint);
        scene.run(2, 4);
        EXPECT_LT(bottom_of(bucket), kBedTopM) << drop_m;
        EXPECT_GT(bottom_of(bucket), kBedTopM - 0.1) << drop_m;
        const BodyReport report = soil->body_report(bucket);
        const double weight_n = (50 + report.load_kg) * kGravity_m_s2;
        EXPECT_NEAR(report.force_n.y, weight_n, 0.02 * weight_n) << drop_m;
    }
}

// Nor is it what it stands on, where it was filled between two steps of the soil.
TEST(HollowBodies, bucket_on_a_plane_does_not_stand_on_its_load) {
    BulletScene scene;
    auto made = SoilAction::create(*scene.world, tall_bed());
    ASSERT_TRUE(made) << made.error();
    SoilAction& soil = **made;
    btRigidBody& plane =
        scene.add(0, scene.shape<btStaticPlaneShape>(btVector3(0, 1, 0), 0), {0, 0.5f, 0});
    btRigidBody& bucket = add_bucket(scene, 0.5);
    plane.setFriction(0);
    fill_bucket(soil, bucket);
    scene.run(1, 4);
    EXPECT_EQ(soil.body_report(bucket).force_n.y, 0);
    const double load_kg = soil.body_report(bucket).load_kg;
    EXPECT_GT(load_kg, 50);
    for (int i = 0; i < 60; ++i) {  // frames of 1/240 s at 1 m/s2
        bucket.activate();
        bucket.applyCentralForce(btVector3(btScalar(50 + load_kg), 0, 0));
        scene.world->stepSimulation(btScalar(1) / 240, 0);
    }
    EXPECT_NEAR(bucket.getLinearVelocity().x(), 0.25, 0.01);
}

// Soil between its legs that nothing of it touches held it in the air.
TEST(HollowBodies, table_over_a_heap_stands_on_its_legs) {
    for (const double drop_m : {0.1, 0.5}) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world, tall_bed());
        ASSERT_TRUE(soil->fill(CylinderFill{{0, kBedTopM, 0}, 0.2, 0.3, {}}));
        scene.run(1);
        const btVector3 leg(0.1f, 0.4f, 0.1f);
        btRigidBody& table = add(scene,
                                 {{{0, 0.3f, 0}, {0.6f, 0.05f, 0.6f}},
                                  {{0.5f, -0.1f, 0.5f}, leg},
                                  {{-0.5f, -0.1f, 0.5f}, leg},
                                  {{0.5f, -0.1f, -0.5f}, leg},
                                  {{-0.5f, -0.1f, -0.5f}, leg}},
                                 200, kBedTopM + 0.5 + drop_m);
        scene.run(2, 4);
        EXPECT_LT(height_of(table) - 0.5, kBedTopM) << drop_m;
        EXPECT_GT(height_of(table) - 0.5, kBedTopM - 0.1) << drop_m;
        const double weight_n = 200 * kGravity_m_s2;
        EXPECT_NEAR(soil->body_report(table).force_n.y, weight_n, 0.02 * weight_n) << drop_m;
    }
}

// Nothing resisted before the soil's first step: at 60 m/s it went through half a metre.
TEST(FastBodies, meet_soil_that_has_not_stepped_as_any_other) {
    for (const btScalar speed_m_s : {btScalar(10), btScalar(60)}) {
        double lowest_m[2];
        for (const bool has_stepped : {false, true}) {
            BulletScene scene;
            const auto soil = sand_bed(*scene.world);
            if (has_stepped) scene.run(0.1, 4);
            btRigidBody& ball = scene.add(10, scene.shape<btSphereShape>(btScalar(0.1)),
                                          {0, btScalar(kBedTopM + 0.12), 0});
            ball.setLinearVelocity({0, -speed_m_s, 0});
            scene.run(0.5, 4);
            lowest_m[has_stepped] = height_of(ball) - 0.1;
        }
        EXPECT_NEAR(lowest_m[0], lowest_m[1], 0.02) << speed_m_s;
        EXPECT_GT(lowest_m[0], 0) << speed_m_s;
    }
}

}  // namespace
}  // namespace bsoil::bullet::hollow_bodies_test
