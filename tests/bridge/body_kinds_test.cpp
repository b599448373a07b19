// Every kind of body, put in, changed and taken out while the soil runs.
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <new>
#include <optional>

#include "test_box.h"

namespace bsoil::bullet::body_kinds_test {
namespace {

void make_kinematic(btRigidBody& body) {
    body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    body.setActivationState(DISABLE_DEACTIVATION);
}

void make_dynamic(btRigidBody& body) {
    body.setCollisionFlags(body.getCollisionFlags() & ~btCollisionObject::CF_KINEMATIC_OBJECT);
    body.forceActivationState(ACTIVE_TAG);
    body.setLinearVelocity(btVector3(0, 0, 0));
    body.setAngularVelocity(btVector3(0, 0, 0));
}

/// Largest speed [m/s] during the next frames of 1/60 s.
double top_speed_m_s(BulletScene& scene, const btRigidBody& body, int frames) {
    double top = 0;
    for (int i = 0; i < frames; ++i) {
        scene.run(1.0 / 60);
        top = std::max(top, static_cast<double>(body.getLinearVelocity().length()));
    }
    return top;
}

/// The same, of what is more than a free fall since the first frame.
double top_kick_m_s(BulletScene& scene, const btRigidBody& body, int frames) {
    double top = 0;
    for (int i = 1; i <= frames; ++i) {
        scene.run(1.0 / 60);
        btVector3 velocity = body.getLinearVelocity();
        const auto fall = static_cast<btScalar>(kGravity_m_s2 * i / 60);
        velocity.setY(velocity.y() - std::clamp(velocity.y(), -fall, btScalar(0)));
        top = std::max(top, static_cast<double>(velocity.length()));
    }
    return top;
}

// --- kinds

TEST(BodyKinds, static_body_that_is_turned_dynamic_is_held) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(0, kHalfBox, btVector3(0, 0.5f, 0));
    scene.run(0.5);
    EXPECT_EQ(length(soil->body_report(box).force_n), 0);
    // As Bullet asks for it: out of the world, new mass, in again.
    scene.world->removeRigidBody(&box);
    btVector3 inertia;
    box.getCollisionShape()->calculateLocalInertia(kMassKg, inertia);
    box.setMassProps(kMassKg, inertia);
    box.updateInertiaTensor();
    scene.world->addRigidBody(&box);
    box.activate();
    scene.run(2);
    EXPECT_NEAR(mean_lift_n(scene, *soil, box), kWeightN, 0.01 * kWeightN);
}

TEST(BodyKinds, kinematic_to_dynamic_and_back_at_run_time) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    const int64_t before = units_of(*soil);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    for (int round = 0; round < 3; ++round) {
        make_kinematic(box);
        for (int frame = 0; frame < 20; ++frame) {
            place(box, box.getWorldTransform().getOrigin() - btVector3(0, 0.002f, 0));
            scene.run(1.0 / 60);
        }
        EXPECT_EQ(soil->body_report(box).patch_count > 0, true);
        EXPECT_GT(soil->body_report(box).force_n.y, kWeightN / 2) << "of its motion";
        make_dynamic(box);
        // Nothing that was stored while it was driven may throw it: sand does not give back.
        EXPECT_LT(top_speed_m_s(scene, box, 60), 0.2) << round;
        EXPECT_NEAR(mean_lift_n(scene, *soil, box), kWeightN, 0.02 * kWeightN) << round;
    }
    EXPECT_EQ(units_of(*soil), before);
}

// Bullet's feedback leaves out what a locked axis takes: the soil seemed not to lift it.
TEST(BodyKinds, body_that_is_guided_along_x_feels_the_soil_along_y_too) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& ball = scene.add(kMassKg, scene.shape<btSphereShape>(btScalar(0.2)),
                                  btVector3(-0.5f, btScalar(kBedTopM), 0));
    ball.setLinearFactor(btVector3(1, 0, 0));
    ball.setAngularFactor(0);
    ASSERT_TRUE(soil->set_options(ball, {.surface = {.friction = 0, .adhesion_pa = 0}}));
    for (int frame = 0; frame < 45; ++frame) {
        ball.setLinearVelocity(btVector3(1, 0, 0));
        scene.run(1.0 / 60);
    }
    // Without friction: the soil is pushed by what of its front lies below its middle.
    const Vec3 force_n = soil->body_report(ball).force_n;
    EXPECT_LT(force_n.x, -50);
    EXPECT_GT(force_n.y, -0.1 * force_n.x);
}

/// A motion state whose pose the test sets.
struct GivenPose final : btMotionState {
    btTransform pose = btTransform::getIdentity();
    void getWorldTransform(btTransform& out) const override { out = pose; }
    void setWorldTransform(const btTransform&) override {}
};

TEST(BodyKinds, kinematic_by_motion_state_and_by_pose_are_the_same_to_the_soil) {
    double drafts_n[2];
    for (const bool by_motion_state : {false, true}) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world);
        GivenPose state;
        btRigidBody& blade =
            scene.add_box(0, btVector3(0.05f, 0.2f, 0.3f), btVector3(-0.5f, 0.5f, 0));
        make_kinematic(blade);
        state.pose.setOrigin(btVector3(-0.5f, 0.5f, 0));
        if (by_motion_state) blade.setMotionState(&state);
        for (int frame = 0; frame <= 60; ++frame) {
            const btVector3 at(-0.5f + 0.4f * btScalar(frame) / 60, 0.5f, 0);
            state.pose.setOrigin(at);
            if (!by_motion_state) blade.setWorldTransform(state.pose);
            scene.run(1.0 / 60);
        }
        drafts_n[by_motion_state] = -soil->body_report(blade).force_n.x;
        blade.setMotionState(nullptr);
    }
    EXPECT_GT(drafts_n[0], 50);
    // Bullet derives the motion state's velocity in single precision.
    EXPECT_NEAR(drafts_n[0], drafts_n[1], 0.02 * drafts_n[0]);
}

/// One link on a slider along y, or a free base that is a box itself.
struct Robot {
    btBoxShape box{kHalfBox};
    std::unique_ptr<btMultiBody> multibody;
    std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
    btMultiBodyDynamicsWorld& world;

    Robot(btMultiBodyDynamicsWorld& in, bool fixed_base) : world(in) {
        btVector3 inertia;
        box.calculateLocalInertia(kMassKg, inertia);
        const int links = fixed_base ? 1 : 0;
        multibody = std::make_unique<btMultiBody>(links, fixed_base ? 0 : kMassKg, inertia,
                                                  fixed_base, true);
        multibody->setBasePos(fixed_base ? btVector3(0, 2, 0) : kAbove);
        if (fixed_base) {
            multibody->setupPrismatic(0, kMassKg, inertia, -1, btQuaternion::getIdentity(),
                                      btVector3(0, 1, 0), kAbove - btVector3(0, 2, 0),
                                      btVector3(0, 0, 0), true);
        }
        multibody->finalizeMultiDof();
        world.addMultiBody(multibody.get());
        add_collider(fixed_base ? 0 : -1);
    }
    void add_collider(int link) {
        colliders.push_back(std::make_unique<btMultiBodyLinkCollider>(multibody.get(), link));
        btMultiBodyLinkCollider* collider = colliders.back().get();
        collider->setCollisionShape(&box);
        place(*collider, kAbove);
        world.addCollisionObject(collider);
        if (link < 0) {
            multibody->setBaseCollider(collider);
        } else {
            multibody->getLink(link).m_collider = collider;
        }
    }
    ~Robot() {
        for (const auto& collider : colliders) world.removeCollisionObject(collider.get());
        world.removeMultiBody(multibody.get());
    }
};

TEST(BodyKinds, multibody_with_fixed_and_with_free_base_rests_on_soil) {
    for (const bool fixed_base : {true, false}) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world);
        {
            Robot robot(*scene.world, fixed_base);
            const btMultiBodyLinkCollider& collider = *robot.colliders[0];
            scene.run(2);
            EXPECT_NEAR(mean_lift_n(scene, *soil, collider), kWeightN, 0.02 * kWeightN)
                << fixed_base;
            EXPECT_GT(height_of(collider), kBedTopM) << fixed_base;
            scene.run(3);
            EXPECT_FALSE(robot.multibody->isAwake()) << fixed_base;
            // Let go in its sleep, it has to fall.
            ASSERT_TRUE(soil->set_options(collider, {.ignored = true}));
            const double from_m = height_of(collider);
            scene.run(0.25);
            EXPECT_LT(height_of(collider), from_m - 0.15) << fixed_base;
        }
        scene.run(0.1);  // the multibody is gone
        EXPECT_TRUE(soil->last_report().contacts.empty());
    }
}

// Its rows found no mass to push, and the report had no force.
TEST(BodyKinds, kinematic_base_of_a_multibody_is_a_kinematic_body) {
    double drafts_n[2];
    for (const bool is_base : {false, true}) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world);
        const btVector3 start(-0.4f, 0.45f, 0);
        std::optional<Robot> robot;
        btCollisionObject* box = nullptr;
        if (is_base) {
            robot.emplace(*scene.world, false);
            robot->multibody->setCanSleep(false);
            robot->multibody->setBasePos(start);  // no jump in the first frame
            box = robot->colliders[0].get();
            box->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        } else {
            btRigidBody& rigid = scene.add_box(0, kHalfBox, start);
            make_kinematic(rigid);
            box = &rigid;
        }
        for (int frame = 0; frame <= 45; ++frame) {
            const btVector3 at = start + btVector3(0.4f * btScalar(frame) / 60, 0, 0);
            place(*box, at);
            if (is_base) robot->multibody->setBasePos(at);
            scene.run(1.0 / 60);
        }
        drafts_n[is_base] = -soil->body_report(*box).force_n.x;
    }
    EXPECT_GT(drafts_n[0], 50);
    EXPECT_NEAR(drafts_n[1], drafts_n[0], 0.05 * drafts_n[0]);
}

// --- changes while running

TEST(BodyChanges, heavier_by_set_mass_props_is_carried) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = sleeping_box(scene);
    btVector3 inertia;
    box.getCollisionShape()->calculateLocalInertia(10 * kMassKg, inertia);
    box.setMassProps(10 * kMassKg, inertia);
    box.updateInertiaTensor();
    box.setGravity(scene.world->getGravity());
    box.activate();
    scene.run(2);
    EXPECT_NEAR(mean_lift_n(scene, *soil, box), 10 * kWeightN, 0.01 * 10 * kWeightN);
}

TEST(BodyChanges, other_shape_other_contact) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    scene.run(2);
    const double small_m2 = soil->body_report(box).contact_area_m2;
    box.setCollisionShape(&scene.shape<btBoxShape>(btVector3(0.4f, kHalf, 0.4f)));
    box.activate();
    EXPECT_LT(top_speed_m_s(scene, box, 60), 0.3);
    EXPECT_GT(soil->body_report(box).contact_area_m2, 2 * small_m2);
    EXPECT_NEAR(mean_lift_n(scene, *soil, box), kWeightN, 0.02 * kWeightN);
}

TEST(BodyChanges, child_added_to_a_compound_in_the_soil_is_seen) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    auto& compound = static_cast<btCompoundShape&>(scene.shape<btCompoundShape>());
    btTransform at = btTransform::getIdentity();
    compound.addChildShape(at, &scene.shape<btBoxShape>(kHalfBox));
    btRigidBody& body = scene.add(kMassKg, compound, kAbove);
    scene.run(1);
    const double one_m2 = soil->body_report(body).contact_area_m2;
    at.setOrigin(btVector3(0.4f, 0, 0));
    compound.addChildShape(at, &scene.shape<btBoxShape>(kHalfBox));
    body.activate();
    scene.run(0.2);
    EXPECT_GT(soil->body_report(body).contact_area_m2, 1.3 * one_m2);
    compound.removeChildShapeByIndex(1);
    body.activate();
    scene.run(1);
    EXPECT_LT(soil->body_report(body).contact_area_m2, 1.3 * one_m2);
}

TEST(BodyChanges, teleported_into_the_soil_gets_no_kick) {
    // Near: within what is swept. Far: placed. Deep: all of it buried.
    for (const btVector3& to : {btVector3(0, 0.45f, 0), btVector3(0.15f, 0.5f, 0.15f),
                                btVector3(0.5f, 0.3f, 0.5f), btVector3(-0.6f, 0.2f, 0.6f)}) {
        BulletScene scene;
        const auto soil = sand_bed(*scene.world);
        const int64_t before = units_of(*soil);
        btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
        scene.run(1);
        place(box, to);
        box.setLinearVelocity(btVector3(0, 0, 0));
        box.activate();
        // Sand has no springs: no faster than gravity makes it where the soil below has made way.
        EXPECT_LT(top_kick_m_s(scene, box, 30), 0.1) << to.x() << " " << to.y();
        EXPECT_LT(box.getLinearVelocity().length(), 0.1) << to.x() << " " << to.y();
        EXPECT_GT(height_of(box), static_cast<double>(to.y()) - 0.03) << to.x();
        EXPECT_TRUE(is_finite(box));
        EXPECT_LT(height_of(box), static_cast<double>(to.y()) + 0.02);
        EXPECT_EQ(units_of(*soil), before);
    }
}

TEST(BodyChanges, teleported_away_in_the_middle_of_an_impact_gets_no_kick) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    box.setLinearVelocity(btVector3(0, -4, 0));
    scene.run(2.0 / 60);
    ASSERT_GT(soil->body_report(box).force_n.y, 5 * kWeightN);
    place(box, btVector3(0, 5, 0));
    box.setLinearVelocity(btVector3(0, 0, 0));
    scene.run(0.1);
    EXPECT_LT(box.getLinearVelocity().y(), btScalar(0.01)) << "nothing pushes it up";
    EXPECT_GT(box.getLinearVelocity().y(), btScalar(-0.12 * kGravity_m_s2));
}

TEST(BodyChanges, removed_while_asleep_frees_its_place) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = sleeping_box(scene);
    ASSERT_FALSE(soil->last_report().contacts.empty());
    scene.remove(box);
    scene.run(0.1);
    EXPECT_TRUE(soil->last_report().contacts.empty());
    EXPECT_EQ(scene.world->getNumConstraints(), 0);
}

// Nothing has borne it yet. Bullet itself lets what is put in asleep hang wherever it is.
TEST(BodyChanges, put_back_asleep_is_woken_and_weighs_what_it_weighs) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& box = scene.add_box(kMassKg, kHalfBox, kAbove);
    scene.run(4);
    ASSERT_FALSE(box.isActive());
    scene.world->removeRigidBody(&box);
    scene.world->addRigidBody(&box);
    scene.run(0.1);
    EXPECT_TRUE(box.isActive());
    EXPECT_LT(top_speed_m_s(scene, box, 240), 0.01);
    EXPECT_FALSE(box.isActive());
    EXPECT_NEAR(soil->body_report(box).force_n.y, kWeightN, 0.02 * kWeightN);
}

// A box sleeps on a slab, and soil is filled in around it.
TEST(BodyChanges, is_woken_by_soil_that_it_meets_asleep) {
    BulletScene scene;
    const auto soil = SoilAction::create(*scene.world, small_bed());
    ASSERT_TRUE(soil);
    scene.add_box(0, btVector3(1, 0.1f, 1), btVector3(0, 0, 0));
    btRigidBody& box =
        scene.add_box(kMassKg, kHalfBox, btVector3(0, 0.1f, 0) + btVector3(0, kHalfBox.y(), 0));
    scene.run(4);
    ASSERT_FALSE(box.isActive());
    const double higher_m = height_of(box) + kHalfBox.y() + 0.1;
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-1, 0.1, -1}, {1, higher_m, 1}}, "dry_sand"}));
    scene.run(0.1);
    EXPECT_TRUE(box.isActive());
    scene.run(4);
    EXPECT_FALSE(box.isActive());
}

TEST(BodyChanges, new_object_of_another_kind_at_an_old_address_is_taken_for_what_it_is) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btCollisionShape& shape = scene.shape<btBoxShape>(kHalfBox);
    alignas(16) unsigned char room[sizeof(btRigidBody)];
    auto* body = new (room) btRigidBody(kMassKg, nullptr, &shape, btVector3(1, 1, 1));
    place(*body, kAbove);
    scene.world->addRigidBody(body);
    scene.run(0.5);
    const int first_id = soil->body_id(*body);
    ASSERT_GT(soil->body_report(*body).patch_count, 0);
    scene.world->removeRigidBody(body);
    body->~btRigidBody();
    // No btRigidBody: rows on it would write beyond its end.
    auto* object = new (room) btCollisionObject;
    object->setCollisionShape(&shape);
    place(*object, kAbove);
    scene.world->addCollisionObject(object);
    scene.run(1.0 / 60);
    EXPECT_NE(soil->body_id(*object), first_id);
    EXPECT_EQ(length(soil->body_report(*object).force_n), 0);
    scene.world->removeCollisionObject(object);
    object->~btCollisionObject();
}

TEST(BodyChanges, bodies_joined_by_constraints_are_carried_together) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    btRigidBody& a = scene.add_box(kMassKg, kHalfBox, kAbove - btVector3(0.25f, 0, 0));
    btRigidBody& b = scene.add_box(kMassKg, kHalfBox, kAbove + btVector3(0.25f, 0, 0));
    btFixedConstraint weld(a, b, btTransform(btQuaternion::getIdentity(), btVector3(0.25f, 0, 0)),
                           btTransform(btQuaternion::getIdentity(), btVector3(-0.25f, 0, 0)));
    scene.world->addConstraint(&weld, true);
    // A third hangs on it by a hinge, off the ground.
    btRigidBody& c =
        scene.add_box(10, btVector3(0.05f, 0.05f, 0.05f), kAbove + btVector3(0.25f, 0.4f, 0));
    btFixedConstraint mast(b, c, btTransform(btQuaternion::getIdentity(), btVector3(0, 0.4f, 0)),
                           btTransform::getIdentity());
    scene.world->addConstraint(&mast, true);
    scene.run(2);
    double lift_n = 0;
    for (int i = 0; i < 60; ++i) {
        scene.run(1.0 / 60);
        lift_n += (soil->body_report(a).force_n.y + soil->body_report(b).force_n.y) / 60;
    }
    EXPECT_NEAR(lift_n, (2 * static_cast<double>(kMassKg) + 10) * kGravity_m_s2,
                0.01 * 2 * kWeightN);
    // The host's constraints are there, in its order, and nothing else.
    ASSERT_EQ(scene.world->getNumConstraints(), 2);
    EXPECT_EQ(scene.world->getConstraint(0), &weld);
    EXPECT_EQ(scene.world->getConstraint(1), &mast);
    scene.world->removeConstraint(&mast);
    scene.world->removeConstraint(&weld);
}

}  // namespace
}  // namespace bsoil::bullet::body_kinds_test
