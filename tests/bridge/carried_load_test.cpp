#include "carried_load.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>

#include <array>

#include "bullet_scene.h"
#include "world_anchor.h"

namespace bsoil::bullet::carried_load_test {
namespace {

constexpr btScalar kStep = btScalar(1) / 60;
constexpr double kTolerance = 1e-5;  // Bullet's floats
constexpr double kSweptMostM = 0.4;
constexpr double kSoilSpeed_m_s = 10;

/// Opens and closes the loads where the soil does: once Bullet has given bodies their weight, and
/// at the end of the substep.
class LoadAction final : public btActionInterface {
  public:
    LoadAction(btDiscreteDynamicsWorld& world, CarriedLoads& loads)
        : world_(world),
          loads_(loads),
          anchor_(
              world, btVector3(0, 0, 0), [&loads] { loads.open_substep(kSweptMostM); }, [] {}) {
        world.addAction(this);
    }
    ~LoadAction() override { world_.removeAction(this); }
    void updateAction(btCollisionWorld*, btScalar substep_s) override {
        loads_.close_substep(static_cast<double>(substep_s));
    }
    void debugDraw(btIDebugDraw*) override {}

  private:
    btDiscreteDynamicsWorld& world_;
    CarriedLoads& loads_;
    WorldAnchor anchor_;
};

/// A box of 2 kg that carries 6 kg.
class CarriedLoad : public testing::Test {
  protected:
    BulletScene scene;
    btRigidBody& box = scene.add_box(2, btVector3(1, 1, 1), btVector3(0, 0, 0));
    btScalar own_inverse_mass = box.getInvMass();

    BodyState state_of_box() {
        BodyState state;
        state.object = &box;
        state.proxy_id = box.getBroadphaseHandle()->getUid();
        state.internal_type = box.getInternalType();
        state.role = BodyRole::rigid;
        return state;
    }
    void substep(double gravity_m_s2, Vec3 load_center_m) {
        CarriedLoads carried(*scene.world, {0, 1, 0}, gravity_m_s2);
        const BodyState state = state_of_box();
        carried.set_loads({&state, 1}, std::array{BodyLoad{0, 6, load_center_m, {}}}, 1.0 / 60,
                          kSoilSpeed_m_s);
        LoadAction action(*scene.world, carried);
        scene.world->stepSimulation(kStep, 0);
    }
};

TEST_F(CarriedLoad, falls_with_its_body) {
    substep(9.81, {});
    EXPECT_NEAR(box.getLinearVelocity().y(), -9.81 / 60, kTolerance);
}

TEST_F(CarriedLoad, is_accelerated_by_its_body) {
    scene.world->setGravity(btVector3(0, 0, 0));
    box.setGravity(btVector3(0, 0, 0));
    box.applyCentralForce(btVector3(16, 0, 0));
    substep(0, {});
    EXPECT_NEAR(box.getLinearVelocity().x(), 16.0 / (2 + 6) / 60, kTolerance);
}

TEST_F(CarriedLoad, is_turned_with_its_body) {
    box.setGravity(btVector3(0, 0, 0));
    // a cube of side 2 m: 2 kg * 2^2 / 6 about each axis; the load half a metre off two of them
    const double inertia = 2 * 4.0 / 6 + 6 * 0.5 * 0.5;
    box.applyTorque(btVector3(3, 0, 0));
    box.applyTorque(btVector3(0, 0, 3));
    substep(0, {0.5, 0, 0});
    EXPECT_NEAR(box.getAngularVelocity().z(), 3 / inertia / 60, kTolerance);
    EXPECT_NEAR(box.getAngularVelocity().x(), 3 / (2 * 4.0 / 6) / 60, kTolerance);
}

TEST_F(CarriedLoad, weighs_at_its_own_place) {
    box.setGravity(btVector3(0, 0, 0));
    substep(9.81, {0.5, 0, 0});
    const double inertia = 2 * 4.0 / 6 + 6 * 0.5 * 0.5;
    EXPECT_NEAR(box.getAngularVelocity().z(), -6 * 9.81 * 0.5 / inertia / 60, kTolerance);
    EXPECT_NEAR(box.getLinearVelocity().y(), -6 * 9.81 / (2 + 6) / 60, kTolerance);
}

// Hosts and vehicles give their impulses between substeps, when the box has its own mass alone.
TEST_F(CarriedLoad, takes_its_share_of_impulses_between_substeps) {
    scene.world->setGravity(btVector3(0, 0, 0));
    box.setGravity(btVector3(0, 0, 0));
    box.setActivationState(DISABLE_DEACTIVATION);
    const BodyState state = state_of_box();
    CarriedLoads carried(*scene.world, {0, 1, 0}, 0);
    const BodyLoad load{0, 6, {0.5, 0, 0}, {}};
    carried.set_loads({&state, 1}, std::array{load}, 1.0 / 60, kSoilSpeed_m_s);
    LoadAction action(*scene.world, carried);
    scene.world->stepSimulation(kStep, 0);
    box.applyCentralImpulse(btVector3(16, 0, 0));
    box.applyTorqueImpulse(btVector3(0, 0, 3));
    scene.world->stepSimulation(kStep, 0);
    const double inertia = 2 * 4.0 / 6 + 6 * 0.5 * 0.5;
    EXPECT_NEAR(box.getLinearVelocity().x(), 16.0 / (2 + 6), kTolerance);
    EXPECT_NEAR(box.getAngularVelocity().z(), 3 / inertia, kTolerance);
    scene.world->stepSimulation(kStep, 0);
    EXPECT_NEAR(box.getLinearVelocity().x(), 16.0 / (2 + 6), kTolerance) << "once";
}

// What is gone takes its share of a debt along, so that box and load turn and go as one body would
// have. By hand: 2 + 6 kg, and 4/3 + 6 2^2 kg m^2. A turn shared by mass was five times as fast.
TEST_F(CarriedLoad, that_is_gone_has_taken_its_share_of_a_debt) {
    scene.world->setGravity(btVector3(0, 0, 0));
    box.setGravity(btVector3(0, 0, 0));
    CarriedLoads carried(*scene.world, {0, 1, 0}, 0);
    BodyLoad load{0, 6, {2, 0, 0}, {}};
    load.impulse_n_s = {0, 0, 16};
    const BodyState state = state_of_box();
    carried.note_given({&load, 1});
    carried.set_loads({&state, 1}, {&load, 1}, 1.0 / 60, kSoilSpeed_m_s);
    carried.set_loads({&state, 1}, {}, 1.0 / 60, kSoilSpeed_m_s);
    LoadAction action(*scene.world, carried);
    scene.world->stepSimulation(kStep, 0);
    EXPECT_NEAR(box.getLinearVelocity().z(), -16.0 / (2 + 6), kTolerance);
    EXPECT_NEAR(box.getAngularVelocity().y(), 2 * 16.0 / (4.0 / 3 + 24), kTolerance);
}

// The kernels take soil along as if the box could not be stopped: 200 N s of 2 kg. Soil of 10 m/s
// makes nothing faster than that, whichever way it flew.
TEST_F(CarriedLoad, makes_no_free_body_faster_than_soil) {
    scene.world->setGravity(btVector3(0, 0, 0));
    box.setGravity(btVector3(0, 0, 0));
    BodyLoad hit{0, 0, {}, {}};
    hit.impulse_n_s = {0, 0, 200};
    for (const double before_m_s : {0.0, 6.0, -6.0, -9.0}) {
        CarriedLoads carried(*scene.world, {0, 1, 0}, 0);
        box.setLinearVelocity(btVector3(0, 0, static_cast<btScalar>(before_m_s)));
        BodyState state = state_of_box();
        state.motion.linear_velocity_m_s = {0, 0, before_m_s};
        carried.note_given({&hit, 1});
        carried.set_loads({&state, 1}, {&hit, 1}, 1.0 / 60, kSoilSpeed_m_s);
        LoadAction action(*scene.world, carried);
        scene.world->stepSimulation(kStep, 0);
        EXPECT_NEAR(box.getLinearVelocity().z(), -kSoilSpeed_m_s, 1e-4) << before_m_s;
    }
}

// A light plate that a machine holds bears all of it.
TEST_F(CarriedLoad, pushes_a_body_that_is_held_with_all_that_it_gave) {
    scene.world->setGravity(btVector3(0, 0, 0));
    box.setGravity(btVector3(0, 0, 0));
    btTransform at = btTransform::getIdentity();
    btFixedConstraint joint(box, btTypedConstraint::getFixedBody(), at, at);
    scene.world->addConstraint(&joint);
    BodyLoad hit{0, 0, {}, {}};
    hit.impulse_n_s = {0, 0, 200};
    const BodyState state = state_of_box();
    CarriedLoads carried(*scene.world, {0, 1, 0}, 0);
    carried.note_given({&hit, 1});
    carried.set_loads({&state, 1}, {&hit, 1}, 1.0 / 60, kSoilSpeed_m_s);
    LoadAction action(*scene.world, carried);
    scene.world->stepSimulation(kStep, 0);
    EXPECT_NEAR(carried.felt_n(0).z, -200 * 60, 1e-6);
    scene.world->removeConstraint(&joint);
}

// The load kept its speed and pushed the body on, at 2.25 m/s.
TEST_F(CarriedLoad, stays_behind_where_its_body_is_put_elsewhere) {
    scene.world->setGravity(btVector3(0, 0, 0));
    box.setGravity(btVector3(0, 0, 0));
    box.setActivationState(DISABLE_DEACTIVATION);
    box.setLinearVelocity(btVector3(3, 0, 0));
    const BodyState state = state_of_box();
    CarriedLoads carried(*scene.world, {0, 1, 0}, 0);
    carried.set_loads({&state, 1}, std::array{BodyLoad{0, 6, {}, {}}}, 1.0 / 60, kSoilSpeed_m_s);
    LoadAction action(*scene.world, carried);
    scene.world->stepSimulation(kStep, 0);
    ASSERT_NEAR(box.getLinearVelocity().x(), 3, kTolerance);
    btTransform pose = box.getWorldTransform();
    pose.setOrigin(btVector3(0, 0, 5));
    box.setWorldTransform(pose);
    box.setLinearVelocity(btVector3(0, 0, 0));
    box.applyCentralForce(btVector3(0, 0, 6));
    scene.world->stepSimulation(kStep, 0);
    EXPECT_NEAR(box.getLinearVelocity().x(), 0, kTolerance);
    EXPECT_NEAR(box.getLinearVelocity().z(), 6.0 / 2 / 60, kTolerance) << "it is light again";
    EXPECT_EQ(box.getInvMass(), own_inverse_mass);
}

// As the soil goes with what it sweeps.
TEST_F(CarriedLoad, comes_along_where_its_body_is_moved_a_little) {
    scene.world->setGravity(btVector3(0, 0, 0));
    box.setGravity(btVector3(0, 0, 0));
    box.setActivationState(DISABLE_DEACTIVATION);
    const BodyState state = state_of_box();
    CarriedLoads carried(*scene.world, {0, 1, 0}, 0);
    carried.set_loads({&state, 1}, std::array{BodyLoad{0, 6, {}, {}}}, 1.0 / 60, kSoilSpeed_m_s);
    LoadAction action(*scene.world, carried);
    scene.world->stepSimulation(kStep, 0);
    btTransform pose = box.getWorldTransform();
    pose.setOrigin(btVector3(0, 0, btScalar(0.9 * kSweptMostM)));
    box.setWorldTransform(pose);
    box.applyCentralForce(btVector3(0, 0, 6));
    scene.world->stepSimulation(kStep, 0);
    EXPECT_NEAR(box.getLinearVelocity().z(), 6.0 / (2 + 6) / 60, kTolerance);
}

TEST_F(CarriedLoad, leaves_the_host_its_own_mass_bit_for_bit) {
    const btVector3 own_inertia = box.getInvInertiaDiagLocal();
    for (int i = 0; i < 100; ++i) substep(9.81, {0.1, 0.2, 0.3});
    EXPECT_EQ(box.getInvMass(), own_inverse_mass);
    EXPECT_EQ(box.getInvInertiaDiagLocal(), own_inertia);
    EXPECT_EQ(box.getTotalForce().length(), 0);
}

// With the same mass, between two substeps.
TEST_F(CarriedLoad, leaves_the_host_the_inertia_that_it_sets) {
    box.setActivationState(DISABLE_DEACTIVATION);
    const BodyState state = state_of_box();
    CarriedLoads carried(*scene.world, {0, 1, 0}, 9.81);
    carried.set_loads({&state, 1}, std::array{BodyLoad{0, 6, {}, {}}}, 1.0 / 60, kSoilSpeed_m_s);
    LoadAction action(*scene.world, carried);
    for (const btScalar inertia : {btScalar(5), btScalar(7)}) {
        box.setMassProps(2, btVector3(inertia, inertia, 0));
        scene.world->stepSimulation(kStep, 0);
        EXPECT_EQ(box.getInvInertiaDiagLocal(), btVector3(1 / inertia, 1 / inertia, 0));
    }
}

/// A link of 2 kg on a hinge about z, 1 m from its centre of mass, that carries 6 kg.
class CarriedLoadOfLink : public testing::Test {
  protected:
    BulletScene scene;
    btMultiBody arm{1, 0, btVector3(0, 0, 0), true, false};
    std::unique_ptr<btMultiBodyLinkCollider> collider;

    void SetUp() override {
        scene.world->setGravity(btVector3(0, 0, 0));
        arm.setupRevolute(0, 2, btVector3(0.5f, 0.5f, 0.5f), -1, btQuaternion::getIdentity(),
                          btVector3(0, 0, 1), btVector3(0, 0, 0), btVector3(1, 0, 0), true);
        arm.finalizeMultiDof();
        arm.setLinearDamping(0);
        arm.setAngularDamping(0);
        scene.world->addMultiBody(&arm);
        collider = std::make_unique<btMultiBodyLinkCollider>(&arm, 0);
        collider->setCollisionShape(&scene.shape<btBoxShape>(btVector3(0.1f, 0.1f, 0.1f)));
        collider->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(1, 0, 0)));
        arm.getLink(0).m_collider = collider.get();
        scene.world->addCollisionObject(collider.get());
    }
    void TearDown() override {
        scene.world->removeCollisionObject(collider.get());
        scene.world->removeMultiBody(&arm);
    }
    void substep(double gravity_m_s2, Vec3 load_center_m) {
        CarriedLoads carried(*scene.world, {0, 1, 0}, gravity_m_s2);
        BodyState state;
        state.object = collider.get();
        state.proxy_id = collider->getBroadphaseHandle()->getUid();
        state.internal_type = collider->getInternalType();
        state.role = BodyRole::link;
        carried.set_loads({&state, 1}, std::array{BodyLoad{0, 6, load_center_m, {}}}, 1.0 / 60,
                          kSoilSpeed_m_s);
        LoadAction action(*scene.world, carried);
        scene.world->stepSimulation(kStep, 0);
    }
};

TEST_F(CarriedLoadOfLink, is_turned_with_it) {
    arm.addJointTorque(0, 40);
    substep(0, {1, 0, 0});
    // 2 kg and 6 kg 1 m from the hinge, and the link's own 0.5 kg m2
    EXPECT_NEAR(arm.getJointVel(0), 40.0 / (8 * 1.0 + 0.5) / 60, 1e-4);
}

TEST_F(CarriedLoadOfLink, weighs_at_its_own_place) {
    substep(9.81, {1, 0.5, 0});
    // The weight's arm is 1 m. Of the load's inertia about the hinge, 6 (1^2 + 0.5^2), all is felt:
    // it lies across the link.
    EXPECT_NEAR(arm.getJointVel(0), -6 * 9.81 * 1.0 / (8.5 + 6 * 0.25) / 60, 1e-4);
}

TEST_F(CarriedLoadOfLink, leaves_the_host_its_own_mass_bit_for_bit) {
    for (int i = 0; i < 100; ++i) substep(9.81, {1.1, 0.2, 0.3});
    EXPECT_EQ(arm.getLink(0).m_mass, 2);
    EXPECT_EQ(arm.getLink(0).m_inertiaLocal, btVector3(0.5f, 0.5f, 0.5f));
    EXPECT_EQ(arm.getLinkForce(0).length(), 0);
    EXPECT_EQ(arm.getLinkTorque(0).length(), 0);
}

}  // namespace
}  // namespace bsoil::bullet::carried_load_test
