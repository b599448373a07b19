// Bodies that their host puts elsewhere between two steps of the soil.
#include "bsoil/bullet/soil_raycaster.h"
#include "host_action.h"
#include "raycast_car.h"
#include "sand_bed.h"

namespace bsoil::bullet::put_elsewhere_test {
namespace {

constexpr btScalar kSubstepS = btScalar(1) / 240;  ///< the soil's step takes four
constexpr btScalar kRadiusM = btScalar(0.2);
const btVector3 kThrownM_s(3, -8, 0);

void substep(BulletScene& scene) { scene.world->stepSimulation(kSubstepS, 1, kSubstepS); }

/// A ball of 30 kg at rest on the bed.
btRigidBody& resting_ball(BulletScene& scene) {
    btRigidBody& ball = scene.add(30, scene.shape<btSphereShape>(kRadiusM),
                                  btVector3(0, btScalar(kBedTopM) + kRadiusM, 0));
    scene.run(1, 4);
    return ball;
}

void throw_from(btRigidBody& body, const btVector3& position) {
    place(body, position);
    body.setLinearVelocity(kThrownM_s);
    body.setAngularVelocity(btVector3(0, 0, 0));
    body.activate(true);
}

/// In free fall since substeps ago.
void expect_free(const btRigidBody& body, int substeps) {
    const btVector3 fallen(0, btScalar(-kGravity_m_s2) * kSubstepS * btScalar(substeps), 0);
    EXPECT_LT((body.getLinearVelocity() - kThrownM_s - fallen).length(), btScalar(1e-3))
        << "after substep " << substeps;
    EXPECT_LT(body.getAngularVelocity().length(), btScalar(1e-3));
}

TEST(Teleport, a_body_that_is_lifted_off_the_soil_flies_free) {
    for (const btVector3& by : {btVector3(0, 1.2f, 0), btVector3(0.4f, 0.3f, 0)}) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world);
        btRigidBody& ball = resting_ball(scene);
        ASSERT_GT(soil->body_report(ball).force_n.y, 200);
        throw_from(ball, ball.getWorldTransform().getOrigin() + by);
        for (int i = 1; i <= 4; ++i) {
            substep(scene);
            expect_free(ball, i);
            EXPECT_EQ(soil->body_report(ball).force_n.y, 0);
            EXPECT_EQ(soil->body_report(ball).patch_count, 0);
        }
    }
}

TEST(Teleport, by_an_action_ahead_of_the_soil_it_flies_free_too) {
    BulletScene scene;
    btRigidBody* body = nullptr;
    HostAction action([&body] {
        if (body) throw_from(*std::exchange(body, nullptr), btVector3(0, 1.5f, 0));
    });
    scene.world->addAction(&action);
    const auto soil = sand_bed(*scene.world);
    btRigidBody& ball = resting_ball(scene);
    body = &ball;
    substep(scene);
    for (int i = 1; i <= 2; ++i) {
        substep(scene);
        expect_free(ball, i);
    }
    scene.world->removeAction(&action);
}

TEST(Teleport, a_body_that_is_turned_leaves_its_patches_behind) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& beam = scene.add_box(30, btVector3(0.4f, 0.05f, 0.05f),
                                      btVector3(0, btScalar(kBedTopM) + 0.05f, 0));
    scene.run(1, 4);
    ASSERT_GT(soil->body_report(beam).force_n.y, 200);
    btTransform pose = beam.getWorldTransform();
    pose.setRotation(btQuaternion(btVector3(0, 1, 0), btScalar(1.5)));
    beam.setWorldTransform(pose);
    beam.activate(true);
    substep(scene);
    EXPECT_EQ(soil->body_report(beam).patch_count, 0);
    // It lies on soil here as well, which holds it as what has just come down.
    EXPECT_LT(beam.getLinearVelocity().y(), btScalar(1e-3));
    EXPECT_GT(beam.getLinearVelocity().y(), btScalar(-0.05));
    scene.run(0.5, 4);
    EXPECT_NEAR(soil->body_report(beam).force_n.y, 30 * kGravity_m_s2, 15) << "found anew";
}

TEST(Teleport, a_body_that_its_host_corrects_by_a_little_stays_held) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& ball = resting_ball(scene);
    const double height_m = height_of(ball);
    for (int i = 0; i < 40; ++i) {
        place(ball, ball.getWorldTransform().getOrigin() + btVector3(0.005f, 0, 0));
        substep(scene);
        EXPECT_GT(soil->body_report(ball).force_n.y, 200) << i;
    }
    EXPECT_NEAR(height_of(ball), height_m, 0.01);
}

TEST(Teleport, a_car_that_is_lifted_off_the_soil_falls_free) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.size_m = {4, 1, 2};
    def.voxel_m = 0.1;
    const auto soil = sand_bed(*scene.world, def);
    SoilRaycaster caster(*soil);
    Car car(scene, caster, 800,
            btVector3(0, btScalar(kBedTopM) + btScalar(0.2) + Car::kRestM + Car::kRadiusM, 0));
    ASSERT_TRUE(caster.attach(*car.vehicle, SoilWheelDef{.width_m = 0.24}));
    car.brake(20);
    scene.run(1, 4);
    ASSERT_GT(car.suspension_n(), 7000);
    place(car.chassis, car.chassis.getWorldTransform().getOrigin() + btVector3(0, 1, 0));
    car.chassis.setLinearVelocity(btVector3(0, 0, 0));
    for (int i = 1; i <= 8; ++i) {
        substep(scene);
        // The first substep's push was found where it stood.
        if (i == 1) car.chassis.setLinearVelocity(btVector3(0, 0, 0));
        const double fallen_m_s = kGravity_m_s2 * static_cast<double>(kSubstepS) * (i - 1);
        EXPECT_NEAR(static_cast<double>(car.chassis.getLinearVelocity().y()), -fallen_m_s, 1e-3);
        EXPECT_EQ(car.suspension_n(), 0) << i;
    }
    scene.run(2, 4);
    EXPECT_NEAR(car.suspension_n(), 800 * kGravity_m_s2, 400);
}

}  // namespace
}  // namespace bsoil::bullet::put_elsewhere_test
