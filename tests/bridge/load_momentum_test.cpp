// Soil that falls on bodies, is taken aboard, or slides on them: what it does to their motion.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <cmath>
#include <numbers>

#include "bullet_types.h"
#include "sand_bed.h"

namespace bsoil::bullet::load_momentum_test {
namespace {

constexpr double kTrayKg = 20;
constexpr double kTrayTopM = 0.4;

/// 4 x 1.5 x 2 m, empty.
SoilDef air() {
    SoilDef def = small_bed();
    def.size_m = {4, 1.5, 2};
    return def;
}

/// A floor of 1.4 x 1 m with walls of 0.2 m around it; its upper face is 0.05 m above its origin.
btCollisionShape& tray_shape(BulletScene& scene) {
    auto& tray = static_cast<btCompoundShape&>(scene.shape<btCompoundShape>());
    const auto add = [&](const btVector3& half, const btVector3& at) {
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(at);
        tray.addChildShape(pose, &scene.shape<btBoxShape>(half));
    };
    add(btVector3(0.7f, 0.05f, 0.5f), btVector3(0, 0, 0));
    for (const btScalar side : {btScalar(-1), btScalar(1)}) {
        add(btVector3(0.05f, 0.15f, 0.5f), btVector3(side * 0.75f, 0.1f, 0));
        add(btVector3(0.8f, 0.15f, 0.05f), btVector3(0, 0.1f, side * 0.55f));
    }
    return tray;
}

/// A rigid body that moves along x alone, and without resistance.
btRigidBody& add_sled(BulletScene& scene, btCollisionShape& shape, double mass_kg, double x_m) {
    btRigidBody& sled = scene.add(btScalar(mass_kg), shape,
                                  btVector3(btScalar(x_m), btScalar(kTrayTopM - 0.05), 0));
    sled.setLinearFactor(btVector3(1, 0, 0));
    sled.setAngularFactor(btVector3(0, 0, 0));
    sled.setActivationState(DISABLE_DEACTIVATION);
    return sled;
}

double x_speed(const btRigidBody& body) {
    return static_cast<double>(body.getLinearVelocity().x());
}

// Sand hangs in the air over a sled's way, and falls straight down onto it: M v0 = (M + m) v.
TEST(LoadMomentum, of_a_sled_that_sand_falls_on_is_kept) {
    for (const int substeps : {1, 4}) {
        BulletScene scene;
        const auto soil = SoilAction::create(*scene.world, air());
        ASSERT_TRUE(soil);
        btRigidBody& sled = add_sled(scene, tray_shape(scene), kTrayKg, -0.7);
        sled.setLinearVelocity(btVector3(1, 0, 0));
        ASSERT_TRUE((*soil)->fill(BoxFill{{{-0.4, 0.8, -0.2}, {0, 1.0, 0.2}}, {}}));
        Vec3 given_n_s;
        for (int i = 0; i < 120; ++i) {
            scene.run(1.0 / 60, substeps);
            for (const BodyLoad& load : (*soil)->last_report().loads) given_n_s += load.impulse_n_s;
        }
        const double load_kg = (*soil)->body_report(sled).load_kg;
        EXPECT_GT(load_kg, 40);
        EXPECT_NEAR(x_speed(sled), kTrayKg / (kTrayKg + load_kg), 0.01) << substeps;
        EXPECT_NEAR(given_n_s.x, kTrayKg * (1 - x_speed(sled)), 1e-3 * kTrayKg) << substeps;
    }
}

/// The same as a link of a multibody that slides along x. Where its tray is a link of its own, that
/// has next to no mass.
void expect_kept_by_link(bool is_tray_apart) {
    BulletScene scene;
    const auto soil = SoilAction::create(*scene.world, air());
    ASSERT_TRUE(soil);
    btMultiBody rail(is_tray_apart ? 2 : 1, 0, btVector3(0, 0, 0), true, false);
    rail.setBasePos(btVector3(-0.7f, btScalar(kTrayTopM - 0.05), 0));
    rail.setupPrismatic(0, btScalar(kTrayKg), btVector3(1, 1, 1), -1, btQuaternion::getIdentity(),
                        btVector3(1, 0, 0), btVector3(0, 0, 0), btVector3(0, 0, 0), true);
    if (is_tray_apart) {
        constexpr btScalar kKg = 0.001f;
        rail.setupFixed(1, kKg, btVector3(kKg, kKg, kKg), 0, btQuaternion::getIdentity(),
                        btVector3(0, 0, 0), btVector3(0, 0, 0));
    }
    rail.finalizeMultiDof();
    rail.setLinearDamping(0);
    rail.setAngularDamping(0);
    rail.setCanSleep(false);
    rail.setJointVel(0, 1);
    scene.world->addMultiBody(&rail);
    const int last = rail.getNumLinks() - 1;
    btMultiBodyLinkCollider tray(&rail, last);
    tray.setCollisionShape(&tray_shape(scene));
    btTransform pose = btTransform::getIdentity();
    pose.setOrigin(rail.getBasePos());
    tray.setWorldTransform(pose);
    rail.getLink(last).m_collider = &tray;
    scene.world->addCollisionObject(&tray);
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-0.4, 0.8, -0.2}, {0, 1.0, 0.2}}, {}}));
    scene.run(2);
    const double load_kg = (*soil)->body_report(tray).load_kg;
    EXPECT_GT(load_kg, 40);
    EXPECT_NEAR(static_cast<double>(rail.getJointVel(0)), kTrayKg / (kTrayKg + load_kg), 0.01);
    scene.world->removeCollisionObject(&tray);
    scene.world->removeMultiBody(&rail);
}

TEST(LoadMomentum, of_a_link_that_sand_falls_on_is_kept) { expect_kept_by_link(false); }
TEST(LoadMomentum, of_a_light_link_of_a_heavy_multibody_is_kept) { expect_kept_by_link(true); }

/// A platform that pulls away from under its load feels friction with it, and no more.
void expect_friction_alone(double heading_rad) {
    constexpr double kFriction = 0.2, kAcceleration_m_s2 = 8, kPlateKg = 60;
    BulletScene scene;
    const auto soil = SoilAction::create(*scene.world, air());
    ASSERT_TRUE(soil);
    auto& shape = scene.shape<btBoxShape>(btVector3(1, 0.05f, 0.8f));
    btRigidBody& plate = add_sled(scene, shape, kPlateKg, 0);
    plate.setLinearFactor(btVector3(1, 0, 1));
    BodyOptions options;
    options.surface.friction = kFriction;
    ASSERT_TRUE((*soil)->set_options(plate, options));
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-0.3, kTrayTopM, -0.3}, {0.3, kTrayTopM + 0.1, 0.3}}, {}}));
    scene.run(0.5);
    const double load_kg = (*soil)->body_report(plate).load_kg, before_m_s = x_speed(plate);
    const btVector3 ahead(btScalar(std::cos(heading_rad)), 0, btScalar(std::sin(heading_rad)));
    EXPECT_GT(load_kg, 50);
    EXPECT_NEAR(before_m_s, 0, 1e-3) << "it spreads to both sides";
    const double pull_n = kPlateKg * kAcceleration_m_s2 + kFriction * load_kg * kGravity_m_s2;
    constexpr int kFrames = 15;
    for (int i = 0; i < kFrames; ++i) {
        plate.applyCentralForce(btScalar(pull_n) * ahead);
        scene.run(1.0 / 60);
    }
    const double speed_m_s = kAcceleration_m_s2 * kFrames / 60;
    EXPECT_NEAR(static_cast<double>(plate.getLinearVelocity().dot(ahead)), speed_m_s,
                0.05 * speed_m_s)
        << heading_rad;
}

// Along the grid and across it: there it had 1.41 times as much, 10 % of this speed.
TEST(LoadMomentum, of_a_load_that_slides_is_what_friction_gives) {
    for (const double heading_rad : {0.0, 0.5, std::numbers::pi / 4}) {
        expect_friction_alone(heading_rad);
    }
}

// A plate of a few grams goes through falling sand that slides off it again. Sand at rest cannot
// make it faster, nor drive it back.
TEST(LoadMomentum, of_a_heavy_load_that_leaves_does_not_throw_a_light_body) {
    constexpr double kPlateKg = 0.005, kSpeed_m_s = 3;
    BulletScene scene;
    const auto soil = SoilAction::create(*scene.world, air());
    ASSERT_TRUE(soil);
    auto& shape = scene.shape<btBoxShape>(btVector3(0.06f, 0.05f, 0.2f));
    btRigidBody& plate = add_sled(scene, shape, kPlateKg, -1.4);
    plate.setLinearVelocity(btVector3(btScalar(kSpeed_m_s), 0, 0));
    for (int k = 0; k < 8; ++k) {
        const double x_m = -0.8 + 0.3 * k;
        ASSERT_TRUE((*soil)->fill(BoxFill{{{x_m, 0.6, -0.3}, {x_m + 0.1, 0.9, 0.3}}, {}}));
    }
    double most_kg = 0, least_m_s = kSpeed_m_s, most_m_s = 0;
    for (int i = 0; i < 60; ++i) {
        scene.run(1.0 / 60);
        most_kg = std::max(most_kg, (*soil)->body_report(plate).load_kg);
        least_m_s = std::min(least_m_s, x_speed(plate));
        most_m_s = std::max(most_m_s, x_speed(plate));
    }
    EXPECT_GT(most_kg, 100 * kPlateKg);
    EXPECT_LT(most_m_s, 1.01 * kSpeed_m_s);
    EXPECT_GT(least_m_s, -kSpeed_m_s);
}

// A plate of 5 g falls to the ground with some kilograms of sand on it, more on its one side. What
// the ground stops it may not pay for alone: nothing is faster than sand that has fallen as far.
TEST(LoadMomentum, of_a_heavy_load_throws_no_light_body) {
    constexpr double kFall_m = 0.6;
    BulletScene scene;
    const auto soil = sand_bed(*scene.world, air());
    btRigidBody& plate = scene.add_box(btScalar(0.005), btVector3(0.15f, 0.05f, 0.15f),
                                       btVector3(0, btScalar(kBedTopM + 0.05 + kFall_m), 0));
    const double above_m = kBedTopM + kFall_m + 0.1;
    ASSERT_TRUE(soil->fill(BoxFill{{{0, above_m, -0.1}, {0.15, above_m + 0.2, 0.1}}, {}}));
    double fastest_m_s = 0, most_kg = 0;
    for (int i = 0; i < 180; ++i) {
        scene.run(1.0 / 60);
        fastest_m_s =
            std::max(fastest_m_s, static_cast<double>(plate.getLinearVelocity().length()));
        most_kg = std::max(most_kg, soil->body_report(plate).load_kg);
    }
    EXPECT_GT(most_kg, 1);
    EXPECT_LT(fastest_m_s, 1.1 * std::sqrt(2 * kGravity_m_s2 * (kFall_m + 0.3)));
}

// Poured soil pushes with what stops it, besides its weight: rate times speed.
TEST(LoadMomentum, of_poured_soil_pushes_beside_its_weight) {
    constexpr double kRate_kg_s = 30, kFall_m = 0.7;
    BulletScene scene;
    const auto soil = SoilAction::create(*scene.world, air());
    ASSERT_TRUE(soil);
    btRigidBody& plate =
        scene.add_box(0, btVector3(0.8f, 0.05f, 0.8f), btVector3(0, btScalar(kTrayTopM - 0.05), 0));
    plate.setCollisionFlags(plate.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    plate.setActivationState(DISABLE_DEACTIVATION);
    SourceDef source;
    source.center_m = {0, kTrayTopM + kFall_m, 0};
    source.radius_m = 0.4;
    source.rate_kg_s = kRate_kg_s;
    ASSERT_TRUE((*soil)->soil().add_source(source));
    scene.run(0.8);
    double push_n = 0;
    constexpr int kFrames = 30;
    for (int i = 0; i < kFrames; ++i) {
        scene.run(1.0 / 60);
        const BodyReport report = (*soil)->body_report(plate);
        push_n -= (report.load_n.y + report.load_kg * kGravity_m_s2) / kFrames;
    }
    // It falls onto what lies there: up to a voxel above the plate and the heap of these seconds.
    const double speed_m_s = std::sqrt(2 * kGravity_m_s2 * kFall_m);
    EXPECT_LT(push_n, 1.05 * kRate_kg_s * speed_m_s);
    EXPECT_GT(push_n, 0.85 * kRate_kg_s * speed_m_s);
}

/// On rigid ground, with soil from one side to the other of its length.
struct ParkedTray {
    BulletScene scene;
    std::unique_ptr<SoilAction> soil;
    btRigidBody* tray = nullptr;

    ParkedTray(double from_m, double to_m) {
        auto made = SoilAction::create(*scene.world, air());
        EXPECT_TRUE(made);
        soil = std::move(*made);
        scene.add_box(0, btVector3(2, 0.1f, 1), btVector3(0, btScalar(kTrayTopM - 0.2), 0));
        tray = &scene.add(btScalar(kTrayKg), tray_shape(scene),
                          btVector3(0, btScalar(kTrayTopM - 0.05), 0));
        EXPECT_TRUE(soil->fill(BoxFill{{{from_m, 0.45, -0.3}, {to_m, 0.6, 0.3}}, {}}));
    }
};

// A parked one is pushed by nothing but its load's weight, and falls asleep.
TEST(LoadMomentum, of_a_load_at_rest_is_none) {
    ParkedTray parked(-0.4, 0.4);
    parked.scene.run(6);
    const BodyReport report = parked.soil->body_report(*parked.tray);
    EXPECT_GT(report.load_kg, 50);
    EXPECT_NEAR(report.load_n.y, -report.load_kg * kGravity_m_s2, 1e-3 * report.load_kg);
    EXPECT_NEAR(std::hypot(report.load_n.x, report.load_n.z), 0, 1e-3 * report.load_kg);
    EXPECT_FALSE(parked.tray->isActive());
}

// One that lies beside a tray's middle turns it, which Bullet's friction did not see: it crept at
// 12 mm/s for good.
TEST(LoadMomentum, of_a_load_at_rest_beside_the_middle_is_none) {
    ParkedTray parked(0.3, 0.6);
    parked.tray->setActivationState(DISABLE_DEACTIVATION);
    parked.scene.run(1);
    EXPECT_GT(parked.soil->body_report(*parked.tray).load_kg, 40);
    const btVector3 from = parked.tray->getWorldTransform().getOrigin();
    parked.scene.run(4);
    EXPECT_LT((parked.tray->getWorldTransform().getOrigin() - from).length(), 5e-4f);
}

/// Four walls of a shaft of 0.6 m over a tray's height, 1 m high, standing 0.05 m above the plate.
btCollisionShape& tube_shape(BulletScene& scene) {
    auto& tube = static_cast<btCompoundShape&>(scene.shape<btCompoundShape>());
    for (const btScalar side : {btScalar(-1), btScalar(1)}) {
        for (const bool is_across : {false, true}) {
            btTransform pose = btTransform::getIdentity();
            pose.setOrigin(is_across ? btVector3(0, 0, side * 0.4f) : btVector3(side * 0.4f, 0, 0));
            tube.addChildShape(pose,
                               &scene.shape<btBoxShape>(is_across ? btVector3(0.5f, 0.5f, 0.1f)
                                                                  : btVector3(0.1f, 0.5f, 0.5f)));
        }
    }
    return tube;
}

// A loose plate under soil in a loose tube: each bears its share, both have the whole weight, and
// all comes to rest. docs/decisions/silo_walls.md
TEST(SiloWalls, and_floor_bear_the_whole_weight_and_sleep) {
    BulletScene scene;
    const auto soil = SoilAction::create(*scene.world, air());
    ASSERT_TRUE(soil);
    constexpr btScalar kPlateTop = 0.2f;
    scene.add_box(0, btVector3(2, 0.05f, 1), btVector3(0, 0.05f, 0));
    btRigidBody& plate =
        scene.add_box(40, btVector3(0.7f, 0.05f, 0.7f), btVector3(0, kPlateTop - 0.05f, 0));
    btRigidBody& tube = scene.add(60, tube_shape(scene), btVector3(0, kPlateTop + 0.5f, 0));
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-0.3, 0.2, -0.3}, {0.3, 1.1, 0.3}}, {}}));
    scene.run(2);
    const BodyReport floor = (*soil)->body_report(plate), wall = (*soil)->body_report(tube);
    EXPECT_GT(floor.load_kg, 400);
    EXPECT_LT(wall.load_kg, 0.01);  // crumbs on its lower rim, measured: 2 g of 575 kg
    const double weight_n = floor.load_kg * kGravity_m_s2;
    // Janssen, with the default sand: K = 0.455, a friction of 0.4, 0.6 m wide, 0.9 m deep.
    const double deep = 0.9 / (0.6 / (4 * 0.455 * 0.4));
    EXPECT_NEAR(floor.load_n.y / -weight_n, -std::expm1(-deep) / deep, 0.06);
    EXPECT_NEAR(floor.load_n.y + wall.load_n.y, -weight_n, 1e-3 * weight_n);
    EXPECT_NEAR(static_cast<double>(plate.getWorldTransform().getOrigin().y()), 0.15, 2e-3);
    // What pulled down beside its middle made it creep.
    const btVector3 at = tube.getWorldTransform().getOrigin();
    EXPECT_LT(std::hypot(static_cast<double>(at.x()), static_cast<double>(at.z())), 1e-3);
    scene.run(5);
    EXPECT_FALSE(plate.isActive());
    EXPECT_FALSE(tube.isActive());
}

// A gate that is drawn from under a silo pushes its walls by friction with the sand alone: 1.3 kN,
// where passive pressure of sand that goes with the gate is 27.
TEST(SiloWalls, feel_the_friction_of_a_gate_that_slides_aside) {
    BulletScene scene;
    const auto soil = SoilAction::create(*scene.world, air());
    ASSERT_TRUE(soil);
    constexpr btScalar kGateTop = 0.2f;
    btRigidBody& gate =
        scene.add_box(0, btVector3(0.7f, 0.05f, 0.5f), btVector3(0, kGateTop - 0.05f, 0));
    gate.setCollisionFlags(gate.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    gate.setActivationState(DISABLE_DEACTIVATION);
    btRigidBody& tube = scene.add(60, tube_shape(scene), btVector3(0, kGateTop + 0.5f, 0));
    // What holds the tube tells the force on it.
    btGeneric6DofSpring2Constraint hold(tube, btTransform::getIdentity());
    for (int axis = 0; axis < 6; ++axis) hold.setLimit(axis, 0, 0);
    btJointFeedback feedback;
    hold.setJointFeedback(&feedback);
    scene.world->addConstraint(&hold);
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-0.3, 0.2, -0.3}, {0.3, 1.1, 0.3}}, {}}));
    scene.run(1);
    const double load_kg = (*soil)->body_report(gate).load_kg;
    EXPECT_GT(load_kg, 400);
    double most_n = 0;
    for (int i = 0; i < 60; ++i) {  // 0.2 m/s
        place(gate, btVector3(btScalar(0.2 / 60 * i), kGateTop - 0.05f, 0));
        scene.run(1.0 / 60);
        const double on_tube_n = std::abs(static_cast<double>(feedback.m_appliedForceBodyA.x()));
        if (i > 5) most_n = std::max(most_n, on_tube_n);
    }
    RecordProperty("most_n", std::to_string(most_n));
    EXPECT_LT(most_n, 1.2 * 0.4 * load_kg * kGravity_m_s2);
    scene.world->removeConstraint(&hold);
}

// The same soil between a tray's own walls: they are the floor's.
TEST(SiloWalls, of_the_floor_itself_change_nothing) {
    BulletScene scene;
    const auto soil = SoilAction::create(*scene.world, air());
    ASSERT_TRUE(soil);
    scene.add_box(0, btVector3(2, 0.1f, 1), btVector3(0, btScalar(kTrayTopM - 0.2), 0));
    scene.add(btScalar(kTrayKg), tray_shape(scene), btVector3(0, btScalar(kTrayTopM - 0.05), 0));
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-0.7, 0.4, -0.5}, {0.7, 0.55, 0.5}}, {}}));
    scene.run(0.5);
    ASSERT_FALSE((*soil)->last_report().loads.empty());
    for (const BodyLoad& load : (*soil)->last_report().loads) EXPECT_EQ(load.held_kg, 0);
}

// Soil under a body is not its load, however much of the voxel the body fills that it lies in.
TEST(CarriedSoil, is_not_what_a_body_stands_on) {
    for (const double raised_voxels : {0.0, 0.25, 0.5, 0.75}) {
        BulletScene scene;
        const auto soil = SoilAction::create(*scene.world, small_bed());
        ASSERT_TRUE(soil);
        const double top_m = kBedTopM + 0.05 * raised_voxels;
        ASSERT_TRUE((*soil)->fill(BoxFill{{{-9, -9, -9}, {9, top_m, 9}}, {}}));
        btRigidBody& box = scene.add_box(20, btVector3(0.15f, 0.15f, 0.15f),
                                         btVector3(0, btScalar(top_m + 0.16), 0));
        scene.run(3);
        const BodyReport report = (*soil)->body_report(box);
        EXPECT_EQ(report.load_kg, 0) << raised_voxels;
        EXPECT_NEAR(report.force_n.y, 20 * kGravity_m_s2, 0.01 * 20 * kGravity_m_s2);
    }
}

}  // namespace
}  // namespace bsoil::bullet::load_momentum_test
