// Arms of a multibody that is fixed to the ground.
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>

#include "sand_bed.h"

namespace bsoil::bullet::multibody_arm_test {
namespace {

constexpr btScalar kLinkKg = 10;
constexpr int kLinks = 2;
const btVector3 kHalfLink(0.2f, 0.1f, 0.2f);

/// Two links on hinges across x, one behind the other along x, that a bed of sand stops as they
/// fall: they stay in one plane whatever pushes them.
struct Arm {
    btBoxShape box{kHalfLink};
    std::unique_ptr<btMultiBody> multibody;
    std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
    btMultiBodyDynamicsWorld& world;

    Arm(btMultiBodyDynamicsWorld& in, const btVector3& base_m) : world(in) {
        btVector3 inertia;
        box.calculateLocalInertia(kLinkKg, inertia);
        multibody = std::make_unique<btMultiBody>(kLinks, kLinkKg, inertia, true, true);
        multibody->setBasePos(base_m);
        const btVector3 half_pitch(kHalfLink.x() + 0.01f, 0, 0);
        for (int i = 0; i < kLinks; ++i) {
            multibody->setupRevolute(i, kLinkKg, inertia, i - 1, btQuaternion::getIdentity(),
                                     btVector3(0, 0, 1), half_pitch, half_pitch, true);
        }
        multibody->finalizeMultiDof();
        world.addMultiBody(multibody.get());
        for (int i = 0; i < kLinks; ++i) {
            colliders.push_back(std::make_unique<btMultiBodyLinkCollider>(multibody.get(), i));
            colliders.back()->setCollisionShape(&box);
            place(*colliders.back(), base_m + btScalar(2 * (i + 1)) * half_pitch);
            world.addCollisionObject(colliders.back().get());
            multibody->getLink(i).m_collider = colliders.back().get();
        }
    }
    ~Arm() {
        for (const auto& collider : colliders) world.removeCollisionObject(collider.get());
        world.removeMultiBody(multibody.get());
    }
};

// Rows across the arm's plane made Bullet stop after its first iteration: the last link rocked by
// 0.4 rad/s for good, and dug itself in.
TEST(MultibodyArm, that_can_not_move_aside_comes_to_rest_on_soil) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    Arm arm(*scene.world, btVector3(-0.4f, btScalar(kBedTopM) + 0.4f, 0));
    scene.run(2);
    const btMultiBodyLinkCollider& tip = *arm.colliders.back();
    const double height_m = height_of(tip);
    double fastest_rad_s = 0;
    for (int frame = 0; frame < 60; ++frame) {
        scene.run(1.0 / 60);
        for (int i = 0; i < kLinks; ++i) {
            fastest_rad_s = std::max(fastest_rad_s,
                                     std::abs(static_cast<double>(arm.multibody->getJointVel(i))));
        }
    }
    EXPECT_LT(fastest_rad_s, 0.01);
    EXPECT_NEAR(height_of(tip), height_m, 1e-4);
    scene.run(2);
    EXPECT_FALSE(arm.multibody->isAwake());
    EXPECT_GT(soil->body_report(tip).force_n.y, 0.5 * kLinkKg * kGravity_m_s2);
}

}  // namespace
}  // namespace bsoil::bullet::multibody_arm_test
