// Rows in a Bullet world, with a flat stand-in for the soil.
#include "contact_coupling.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "bsoil/contact/granular_law.h"
#include "bullet_scene.h"
#include "bullet_types.h"
#include "flat_soil.h"
#include "torque_constraint.h"

namespace bsoil::bullet::contact_coupling_test {
namespace {

constexpr double kGravity_m_s2 = 9.81;

struct RestCase {
    const char* name;
    double mass_kg, half_m;
};

class BodyAtRest : public testing::TestWithParam<std::tuple<RestCase, int>> {};

TEST_P(BodyAtRest, settles_without_jitter_and_sleeps) {
    const auto [c, substeps] = GetParam();
    BulletScene scene;
    const btScalar h = btScalar(c.half_m);
    btRigidBody& body =
        scene.add_box(btScalar(c.mass_kg), btVector3(h, h, h), btVector3(0, h + btScalar(0.05), 0));
    FlatSoil soil(*scene.world, MaterialDef{});
    scene.run(2, substeps);
    const btVector3 rest = body.getWorldTransform().getOrigin();
    const double weight_n = c.mass_kg * kGravity_m_s2;
    for (int frame = 0; frame < 30; ++frame) {
        scene.run(1.0 / 60, substeps);
        EXPECT_LT(body.getLinearVelocity().length(), 1e-3f);
        EXPECT_LT(body.getAngularVelocity().length() * h, 1e-3f);
        EXPECT_NEAR(soil.report(body).force_n.y, weight_n, 0.05 * weight_n);
    }
    // Bullet lets a body sleep after two seconds of rest.
    scene.run(2.5, substeps);
    EXPECT_FALSE(body.isActive());
    EXPECT_NEAR(soil.report(body).force_n.y, weight_n, 0.05 * weight_n);
    EXPECT_LT((body.getWorldTransform().getOrigin() - rest).length(), 1e-3f);
    EXPECT_GT(soil.report(body).sinkage_m, 0);
    // It sleeps on, whatever else happens in the world.
    scene.run(2, substeps);
    EXPECT_FALSE(body.isActive());
}

TEST(TorqueConstraint, turns_the_smallest_body_as_it_should) {
    BulletScene scene;
    scene.world->setGravity(btVector3(0, 0, 0));
    const auto h = btScalar(0.005);
    btRigidBody& pebble = scene.add_box(btScalar(0.0025), btVector3(h, h, h), btVector3(0, 0, 0));
    TorqueConstraint torque(pebble);
    torque.torque_n_m = btVector3(0, btScalar(2e-8), 0);
    scene.world->addConstraint(&torque);
    scene.run(1.0 / 60);
    scene.world->removeConstraint(&torque);
    // 2.5 g of 1 cm: 4.2e-8 kg m2.
    EXPECT_NEAR(static_cast<double>(pebble.getAngularVelocity().y()), 2e-8 / 60 / (0.0025e-4 / 6),
                1e-5);
}

INSTANTIATE_TEST_SUITE_P(Masses, BodyAtRest,
                         testing::Combine(testing::Values(RestCase{"pebble_5_g", 0.005, 0.0075},
                                                          RestCase{"box_50_kg", 50, 0.2},
                                                          RestCase{"machine_20_t", 20000, 1}),
                                          testing::Values(1, 4)),
                         [](const auto& test) {
                             return std::string(std::get<0>(test.param).name) + "_substeps_" +
                                    std::to_string(std::get<1>(test.param));
                         });

TEST(ContactCoupling, box_released_on_the_surface_sinks_twice_as_deep_as_it_needs) {
    BulletScene scene;
    btRigidBody& body = scene.add_box(500, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.2f, 0));
    FlatSoil soil(*scene.world, MaterialDef{});
    scene.run(2);
    // Resistance grows with depth as a spring's force does but gives nothing back: work balances at
    // twice the depth where 0.875 xi depth area = weight, within a step's travel.
    const double xi = strength_of(MaterialDef{}, kGravity_m_s2).stiffness_pa_m;
    const double depth = 500 * kGravity_m_s2 / (0.875 * xi * 0.16);
    EXPECT_NEAR(soil.report(body).sinkage_m, 2 * depth, 0.1 * depth);
}

/// How far a box of 50 kg is pushed in one second by a horizontal force of so many times its
/// weight.
double pushed_m(double force_fraction, const btVector3& direction, int substeps = 1) {
    BulletScene scene;
    MaterialDef firm;  // stiff, so that the box hardly sinks and its front has little to plough
    firm.friction_angle_rad = 0.9;
    firm.tool_friction = 0.4;
    btRigidBody& body = scene.add_box(50, btVector3(0.3f, 0.1f, 0.3f), btVector3(0, 0.101f, 0));
    FlatSoil soil(*scene.world, firm);
    scene.run(1, substeps);
    const btVector3 start = body.getWorldTransform().getOrigin();
    for (int frame = 0; frame < 60; ++frame) {
        body.activate();
        body.applyCentralForce(direction * btScalar(force_fraction * 50 * kGravity_m_s2));
        scene.run(1.0 / 60, substeps);
    }
    return static_cast<double>((body.getWorldTransform().getOrigin() - start).length());
}

TEST(ContactCoupling, box_stays_below_the_friction_limit_and_slides_above) {
    for (const int substeps : {1, 4}) {
        EXPECT_LT(pushed_m(0.35, btVector3(1, 0, 0), substeps), 1e-3);
        EXPECT_GT(pushed_m(0.60, btVector3(1, 0, 0), substeps), 0.3);
    }
}

TEST(ContactCoupling, friction_is_the_same_along_the_diagonal) {
    const btScalar h = btScalar(std::numbers::sqrt2 / 2);
    EXPECT_LT(pushed_m(0.35, btVector3(h, 0, h)), 1e-3);
    EXPECT_GT(pushed_m(0.60, btVector3(h, 0, h)), 0.3);
}

TEST(ContactCoupling, soil_never_pulls) {
    BulletScene scene;
    btRigidBody& body = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.2f, 0));
    MaterialDef clay;
    clay.cohesion_pa = 20e3;
    FlatSoil soil(*scene.world, clay);
    scene.run(1);
    body.setLinearVelocity(btVector3(0, 2, 0));
    const btScalar before = body.getLinearVelocity().y();
    scene.run(1.0 / 60);
    EXPECT_NEAR(body.getLinearVelocity().y(), before - 9.81f / 60, 1e-3);
}

TEST(ContactCoupling, eccentric_load_tilts_no_further_than_the_soil_lets_it) {
    BulletScene scene;
    btRigidBody& body = scene.add_box(100, btVector3(0.3f, 0.1f, 0.3f), btVector3(0, 0.1f, 0));
    FlatSoil soil(*scene.world, MaterialDef{});
    scene.run(1);
    for (int frame = 0; frame < 120; ++frame) {
        body.activate();
        body.applyForce(btVector3(0, -200, 0), btVector3(0.2f, 0, 0));
        scene.run(1.0 / 60);
    }
    const BodyReport report = soil.report(body);
    EXPECT_NEAR(report.force_n.y, 100 * kGravity_m_s2 + 200, 60);
    EXPECT_NEAR(report.torque_n_m.z, 40, 4);  // against -200 N at 0.2 m
    EXPECT_LT(body.getAngularVelocity().length(), 1e-3f);
}

TEST(ContactCoupling, vehicle_on_hinged_wheels_stays_up) {
    BulletScene scene;
    btRigidBody& chassis = scene.add_box(2000, btVector3(1, 0.2f, 0.5f), btVector3(0, 0.6f, 0));
    std::vector<btRigidBody*> wheels;
    std::vector<std::unique_ptr<btHingeConstraint>> hinges;
    btCollisionShape& wheel_shape = scene.shape<btCylinderShapeZ>(btVector3(0.35f, 0.35f, 0.12f));
    for (const btScalar x : {-0.8f, 0.8f}) {
        for (const btScalar z : {-0.65f, 0.65f}) {
            btRigidBody& wheel = scene.add(60, wheel_shape, btVector3(x, 0.36f, z));
            wheels.push_back(&wheel);
            hinges.push_back(std::make_unique<btHingeConstraint>(
                chassis, wheel, btVector3(x, -0.24f, z), btVector3(0, 0, 0), btVector3(0, 0, 1),
                btVector3(0, 0, 1)));
            scene.world->addConstraint(hinges.back().get(), true);
        }
    }
    {
        FlatSoil soil(*scene.world, MaterialDef{});
        scene.run(1.8);
        // Light wheels under a heavy chassis rock a little in Bullet's ten iterations, on a plane
        // of its own as well.
        EXPECT_LT(chassis.getLinearVelocity().length(), 0.05f);
        scene.run(1.2);
        EXPECT_GT(chassis.getWorldTransform().getOrigin().y(), 0.3f);
        EXPECT_FALSE(chassis.isActive());
        EXPECT_GT(chassis.getWorldTransform().getBasis()[1][1], 0.999f);
        double lift_n = 0;
        for (const btRigidBody* wheel : wheels) lift_n += soil.report(*wheel).force_n.y;
        // The force of the one substep in which it fell asleep, still rocking.
        EXPECT_NEAR(lift_n, 2240 * kGravity_m_s2, 0.15 * 2240 * kGravity_m_s2);

        // Driven, it moves along x.
        for (const auto& hinge : hinges) hinge->enableAngularMotor(true, 3, 200);
        chassis.activate();
        const btScalar start = chassis.getWorldTransform().getOrigin().x();
        scene.run(3);
        EXPECT_GT(std::abs(chassis.getWorldTransform().getOrigin().x() - start), 0.5f);
        EXPECT_GT(chassis.getWorldTransform().getOrigin().y(), 0.25f);
        EXPECT_GT(chassis.getWorldTransform().getBasis()[1][1], 0.98f);
    }
    EXPECT_EQ(scene.world->getNumConstraints(), 4);
    for (const auto& hinge : hinges) scene.world->removeConstraint(hinge.get());
}

/// About a body's centre, of the impulses in its contacts with other bodies in the last step.
btVector3 contact_impulse_moment_n_m_s(btDynamicsWorld& world, const btRigidBody& body) {
    btVector3 moment(0, 0, 0);
    btDispatcher& dispatcher = *world.getDispatcher();
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
        const bool is_first = manifold.getBody0() == &body;
        if (!is_first && manifold.getBody1() != &body) continue;
        for (int i = 0; i < manifold.getNumContacts(); ++i) {
            const btManifoldPoint& point = manifold.getContactPoint(i);
            const btVector3 on_first = point.m_appliedImpulse * point.m_normalWorldOnB +
                                       point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1;
            const btVector3 at =
                is_first ? point.getPositionWorldOnA() : point.getPositionWorldOnB();
            moment += (at - body.getCenterOfMassPosition()).cross(is_first ? on_first : -on_first);
        }
    }
    return moment;
}

TEST(ContactCoupling, wheel_that_rests_beside_a_plates_middle_does_not_turn) {
    BulletScene scene;
    btRigidBody& plate =
        scene.add_box(4, btVector3(0.06f, 0.02f, 0.15f), btVector3(-0.02f, 0.02f, 0));
    btRigidBody& wheel = scene.add(8, scene.shape<btCylinderShapeZ>(btVector3(0.1f, 0.1f, 0.1f)),
                                   btVector3(0, 0.14f, 0));
    btRigidBody& load = scene.add_box(100, btVector3(0.1f, 0.1f, 0.1f), btVector3(0, 0.5f, 0));
    // The load moves up and down only; the wheel turns on it without friction.
    load.setLinearFactor(btVector3(0, 1, 0));
    load.setAngularFactor(btVector3(0, 0, 0));
    btHingeConstraint axle(load, wheel, btVector3(0, -0.36f, 0), btVector3(0, 0, 0),
                           btVector3(0, 0, 1), btVector3(0, 0, 1));
    scene.world->addConstraint(&axle, true);
    {
        FlatSoil soil(*scene.world, MaterialDef{});
        scene.run(1, 4);
        std::vector<double> spins_rad_s, torques_n_m, errors_n_m;
        for (int frame = 0; frame < 30; ++frame) {
            scene.run(1.0 / 60, 4);
            spins_rad_s.push_back(std::abs(wheel.getAngularVelocity().z()));
            const double torque_n_m = soil.report(plate).torque_n_m.z;
            const btVector3 pressed_n_m = contact_impulse_moment_n_m_s(*scene.world, plate) * 240;
            torques_n_m.push_back(std::abs(torque_n_m));
            errors_n_m.push_back(std::abs(torque_n_m + static_cast<double>(pressed_n_m.z())));
        }
        const auto median = [](std::vector<double> values) {
            std::nth_element(values.begin(), values.begin() + 15, values.end());
            return values[15];
        };
        constexpr double kWeightN = (100 + 8 + 4) * 9.81;
        // The soil's torque is that of the wheel's press beside the plate's middle, but nothing
        // turns.
        EXPECT_GT(median(torques_n_m), 0.6e-3 * kWeightN);
        // The two act within 0.3 mm of each other (0.1 mm measured in double precision).
        EXPECT_LT(median(errors_n_m), 0.3e-3 * kWeightN);
        EXPECT_LT(median(spins_rad_s), 0.1);
    }
    scene.world->removeConstraint(&axle);
}

/// A multibody of one vertical slider on a fixed base, with a box as its link.
struct Press {
    explicit Press(BulletScene& scene, btScalar mass_kg)
        : multibody(1, 0, btVector3(1, 1, 1), true, true),
          box(btVector3(0.2f, 0.2f, 0.2f)),
          collider(&multibody, 0) {
        btVector3 inertia;
        box.calculateLocalInertia(mass_kg, inertia);
        multibody.setBasePos(btVector3(0, 0.25f, 0));
        multibody.setupPrismatic(0, mass_kg, inertia, -1, btQuaternion::getIdentity(),
                                 btVector3(0, 1, 0), btVector3(0, 0, 0), btVector3(0, 0, 0), true);
        multibody.finalizeMultiDof();
        scene.world->addMultiBody(&multibody);
        collider.setCollisionShape(&box);
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(btVector3(0, 0.25f, 0));
        collider.setWorldTransform(pose);
        scene.world->addCollisionObject(&collider, 2, 1);
        multibody.getLink(0).m_collider = &collider;
    }
    btMultiBody multibody;
    btBoxShape box;
    btMultiBodyLinkCollider collider;
};

TEST(ContactCoupling, multibody_link_pressed_by_its_weight_stops_and_sleeps) {
    for (const int substeps : {1, 4}) {
        BulletScene scene;
        Press press(scene, 300);
        {
            FlatSoil soil(*scene.world, MaterialDef{});
            scene.run(2, substeps);
            EXPECT_LT(std::abs(press.multibody.getJointVel(0)), 1e-3f);
            const BodyReport report = soil.report(press.collider);
            EXPECT_NEAR(report.force_n.y, 300 * kGravity_m_s2, 0.05 * 300 * kGravity_m_s2);
            EXPECT_GT(report.sinkage_m, 0);
            EXPECT_LT(report.sinkage_m, 0.1);
            scene.run(4, substeps);
            EXPECT_FALSE(press.multibody.isAwake());
        }
        scene.world->removeCollisionObject(&press.collider);
        scene.world->removeMultiBody(&press.multibody);
    }
}

TEST(ContactCoupling, kinematic_blade_only_reports) {
    BulletScene scene;
    btRigidBody& blade = scene.add_box(0, btVector3(0.02f, 0.3f, 0.1f), btVector3(0, 0.2f, 0));
    blade.setCollisionFlags(blade.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    blade.setActivationState(DISABLE_DEACTIVATION);
    FlatSoil soil(*scene.world, MaterialDef{});
    soil.points_per_side = 60;
    const double speed_m_s = 0.2;
    for (int frame = 1; frame <= 60; ++frame) {
        btTransform pose = blade.getWorldTransform();
        pose.setOrigin(btVector3(btScalar(speed_m_s * frame / 60), 0.2f, 0));
        blade.setWorldTransform(pose);
        scene.run(1.0 / 60);
        EXPECT_EQ(scene.world->getNumConstraints(), 0);
    }
    EXPECT_NEAR(blade.getWorldTransform().getOrigin().x(), speed_m_s, 1e-5);
    // Coulomb's passive wedge of 0.1 m of soil before 0.2 m of blade, with its sides: less than
    // resistive force theory's 423 N, as for Obermayr's blade. Plus the momentum flux, 1600 v^2 on
    // 0.1 m x 0.2 m.
    const SoilStrength strength = strength_of(MaterialDef{}, kGravity_m_s2);
    const double sides = 1 + strength.wedge_sides * 0.1 / 0.2;
    const double draft = strength.passive_factor * strength.weight_n_m3 * 0.01 / 2 * 0.2 * sides +
                         1600 * speed_m_s * speed_m_s * 0.02;
    // 3 %: the face's size is that between the outermost contacts.
    EXPECT_NEAR(-soil.report(blade).force_n.x, draft, 0.03 * draft);
    EXPECT_GT(soil.report(blade).peak_force_n, 0.97 * draft);
}

TEST(ContactCoupling, kinematic_body_moved_by_its_pose_alone_has_a_velocity) {
    BulletScene scene;
    btCollisionObject object;
    btBoxShape box(btVector3(0.02f, 0.3f, 0.1f));
    object.setCollisionShape(&box);
    object.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    object.setActivationState(DISABLE_DEACTIVATION);
    scene.world->addCollisionObject(&object);
    BodyCollector collector({{-2, -2, -2}, {2, 2, 2}});
    collector.collect(*scene.world, 0.1);
    btTransform pose(btQuaternion(btVector3(0, 0, 1), 0.05f), btVector3(0.02f, 0, 0));
    object.setWorldTransform(pose);
    collector.collect(*scene.world, 0.1);
    ASSERT_EQ(collector.bodies().size(), 1u);
    const BodyMotion& motion = collector.bodies()[0].motion;
    EXPECT_NEAR(motion.linear_velocity_m_s.x, 0.2, 1e-5);
    EXPECT_NEAR(motion.angular_velocity_rad_s.z, 0.5, 1e-5);
    EXPECT_EQ(collector.bodies()[0].role, BodyRole::driven);
    scene.world->removeCollisionObject(&object);
}

TEST(ContactCoupling, link_velocities_are_those_of_its_joints) {
    BulletScene scene;
    Press press(scene, 300);
    press.multibody.setJointVel(0, -0.3f);
    BodyCollector collector({{-2, -2, -2}, {2, 2, 2}});
    collector.collect(*scene.world, 0.1);
    ASSERT_EQ(collector.bodies().size(), 1u);
    EXPECT_EQ(collector.bodies()[0].role, BodyRole::link);
    EXPECT_NEAR(collector.bodies()[0].motion.linear_velocity_m_s.y, -0.3, 1e-6);
    EXPECT_NEAR(collector.bodies()[0].weight_n, 300 * kGravity_m_s2, 1);
    scene.world->removeCollisionObject(&press.collider);
    scene.world->removeMultiBody(&press.multibody);
}

TEST(ContactCoupling, sleeping_body_wakes_when_the_soil_under_it_changes) {
    BulletScene scene;
    btRigidBody& body = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.21f, 0));
    FlatSoil soil(*scene.world, MaterialDef{});
    while (body.getActivationState() == ACTIVE_TAG) scene.run(1.0 / 60);
    soil.level_m = 0.1;  // in its first step asleep its contact is found as that of a moving body
    scene.run(1.0 / 60);
    soil.level_m = 0;
    scene.run(2);
    ASSERT_FALSE(body.isActive());
    const btScalar before = body.getWorldTransform().getOrigin().y();
    soil.level_m = -0.1;
    scene.run(1);
    EXPECT_TRUE(body.isActive());
    EXPECT_NEAR(body.getWorldTransform().getOrigin().y(), before - 0.1f, 0.03f);
    scene.run(6);
    ASSERT_FALSE(body.isActive());
    soil.level_m = 0.1;  // buried deeper
    scene.run(1.0 / 20);
    EXPECT_TRUE(body.isActive());
}

TEST(ContactCoupling, no_rows_are_left_in_the_world_between_steps) {
    BulletScene scene;
    Press press(scene, 300);
    scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(2, 0.2f, 0));
    {
        FlatSoil soil(*scene.world, MaterialDef{});
        for (int frame = 0; frame < 30; ++frame) {
            scene.run(1.0 / 60);
            EXPECT_EQ(scene.world->getNumConstraints(), 0);
            EXPECT_EQ(scene.world->getNumMultiBodyConstraints(), 0);
        }
        EXPECT_GT(soil.report(press.collider).patch_count, 0);
        // Drawing the boxes asks for them too.
        struct : btIDebugDraw {
            void drawLine(const btVector3&, const btVector3&, const btVector3&) override {}
            void drawContactPoint(const btVector3&, const btVector3&, btScalar, int,
                                  const btVector3&) override {}
            void reportErrorWarning(const char*) override {}
            void draw3dText(const btVector3&, const char*) override {}
            void setDebugMode(int) override {}
            int getDebugMode() const override { return DBG_DrawAabb | DBG_DrawWireframe; }
        } drawer;
        scene.world->setDebugDrawer(&drawer);
        scene.world->debugDrawWorld();
        scene.world->setDebugDrawer(nullptr);
        EXPECT_EQ(scene.world->getNumConstraints(), 0);
        EXPECT_EQ(scene.world->getNumMultiBodyConstraints(), 0);
    }
    scene.world->removeCollisionObject(&press.collider);
    scene.world->removeMultiBody(&press.multibody);
}

TEST(ContactCoupling, body_deleted_between_steps_is_forgotten) {
    BulletScene scene;
    btRigidBody* body = &scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.2f, 0));
    btRigidBody& other = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(2, 0.2f, 0));
    FlatSoil soil(*scene.world, MaterialDef{});
    scene.run(0.5);
    EXPECT_GT(soil.report(*body).patch_count, 0);
    scene.remove(*body);
    scene.run(0.5);
    EXPECT_EQ(soil.collector.bodies().size(), 1u);
    // Many new bodies: one of them may get the old one's address.
    for (int i = 0; i < 20; ++i) {
        scene.add_box(5, btVector3(0.2f, 0.2f, 0.2f), btVector3(btScalar(i) - 10, 3, 5));
    }
    scene.run(2);
    EXPECT_NEAR(soil.report(other).force_n.y, 50 * kGravity_m_s2, 25);
}

TEST(ContactCoupling, same_run_gives_the_same_bits) {
    const auto run = [] {
        BulletScene scene;
        for (int i = 0; i < 5; ++i) {
            scene.add_box(btScalar(10 * (i + 1)), btVector3(0.2f, 0.1f, 0.15f),
                          btVector3(btScalar(i), 0.4f, 0));
        }
        FlatSoil soil(*scene.world, MaterialDef{});
        for (const auto& body : scene.bodies) body->setAngularVelocity(btVector3(1, 2, 3));
        scene.run(1, 4);
        std::vector<btScalar> out;
        for (const auto& body : scene.bodies) {
            for (int k = 0; k < 3; ++k) out.push_back(body->getWorldTransform().getOrigin()[k]);
        }
        return out;
    };
    EXPECT_EQ(run(), run());
}

TEST(WorldAnchor, is_unseen_by_rays_and_contacts) {
    BulletScene scene;
    int opened = 0;
    WorldAnchor anchor(
        *scene.world, btVector3(0, 0, 0), [&] { ++opened; }, [] {});
    EXPECT_EQ(opened, 0);
    scene.run(1.0 / 60, 4);
    EXPECT_EQ(opened, 4);
    btCollisionWorld::AllHitsRayResultCallback hits(btVector3(0, 1, 0), btVector3(0, -1, 0));
    scene.world->rayTest(hits.m_rayFromWorld, hits.m_rayToWorld, hits);
    EXPECT_FALSE(hits.hasHit());
}

TEST(WorldAnchor, knows_that_its_world_was_destroyed) {
    BulletScene scene;
    WorldAnchor anchor(
        *scene.world, btVector3(0, 0, 0), [] {}, [] {});
    EXPECT_TRUE(anchor.world_exists());
    scene.world.reset();
    EXPECT_FALSE(anchor.world_exists());
}

TEST(WorldAnchor, tells_when_the_host_deletes_it) {
    BulletScene scene;
    bool deleted = false;
    WorldAnchor anchor(
        *scene.world, btVector3(0, 0, 0), [] {}, [&] { deleted = true; });
    btCollisionObject* object = scene.world->getCollisionObjectArray()[0];
    scene.world->removeCollisionObject(object);
    delete object;
    EXPECT_TRUE(deleted);
    EXPECT_EQ(anchor.object(), nullptr);
}

}  // namespace
}  // namespace bsoil::bullet::contact_coupling_test
