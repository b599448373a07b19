// Snapshots of worlds: what is restored goes on bit for bit.
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include <limits>
#include <random>
#include <set>
#include <tuple>

#include "snapshot_worlds.h"

namespace bsoil::bullet::world_snapshot_test {
namespace {

/// Bodies that the soil does not carry lie on its surface while a heap of it slumps: their contacts
/// go whenever the surface has moved by a hundredth of a voxel since they met it.
std::unique_ptr<TestWorld> build_bodies_on_ground() {
    auto w = std::make_unique<TestWorld>();
    add_soil(*w);
    EXPECT_TRUE(w->soil->fill(CylinderFill{{0, 0.4, 0}, 0.3, 0.4, "dry_sand"}));
    for (int i = 0; i < 4; ++i) {
        const float x = 0.45f * static_cast<float>(i) - 0.7f;
        btRigidBody& body =
            i % 2 == 0
                ? w->scene.add_box(5, {0.1f, 0.05f, 0.1f}, {x, 0.9f, 0.1f})
                : w->scene.add(5, w->scene.shape<btSphereShape>(btScalar(0.1)), {x, 0.9f, 0.1f});
        EXPECT_TRUE(w->soil->set_options(body, {.ignored = true}));
    }
    return w;
}

/// A moving mesh that lies where soil is poured later, and one that falls over a heap: built anew,
/// the ground is below the first and reaches into the second.
std::unique_ptr<TestWorld> build_moving_meshes() {
    auto w = std::make_unique<TestWorld>();
    btGImpactCollisionAlgorithm::registerAlgorithm(&w->scene.dispatcher);
    add_soil(*w);
    EXPECT_TRUE(w->soil->fill(CylinderFill{{0.8, 0.4, 0}, 0.2, 0.4, "dry_sand"}));
    static const std::unique_ptr<btTriangleMesh> mesh = [] {
        auto made = std::make_unique<btTriangleMesh>();
        const btVector3 top(0, 0.1f, 0);
        const btVector3 base[] = {{0.1f, -0.1f, 0.1f}, {0.1f, -0.1f, -0.1f}, {-0.1f, -0.1f, 0}};
        for (int i = 0; i < 3; ++i) made->addTriangle(base[i], base[(i + 1) % 3], top);
        made->addTriangle(base[2], base[1], base[0]);
        return made;
    }();
    auto& shape = static_cast<btGImpactMeshShape&>(w->scene.shape<btGImpactMeshShape>(mesh.get()));
    shape.updateBound();
    for (const btVector3& place : {btVector3(-0.8f, 0.9f, 0), btVector3(0.8f, 2.4f, 0)}) {
        EXPECT_TRUE(w->soil->set_options(w->scene.add(5, shape, place), {.ignored = true}));
    }
    w->command = [](TestWorld& t) {
        if (t.frame != 5) return;
        EXPECT_TRUE(t.soil->fill(BoxFill{{{-1.2, 0.4, -0.4}, {-0.4, 0.6, 0.4}}, "dry_sand"}));
    };
    return w;
}

/// The same with compounds and a triangle mesh.
std::unique_ptr<TestWorld> build_compounds() {
    auto w = build_heap();
    BulletScene& s = w->scene;
    static const std::unique_ptr<btTriangleMesh> mesh = [] {
        auto made = std::make_unique<btTriangleMesh>();
        for (int i = -4; i < 4; ++i) {
            for (int k = -4; k < 4; ++k) {
                const auto point = [](int x, int z) {
                    return btVector3(btScalar(x) * 0.5f, 0.1f * btScalar((x + z) & 1),
                                     btScalar(z) * 0.5f);
                };
                made->addTriangle(point(i, k), point(i, k + 1), point(i + 1, k));
                made->addTriangle(point(i + 1, k), point(i, k + 1), point(i + 1, k + 1));
            }
        }
        return made;
    }();
    s.add(0, s.shape<btBvhTriangleMeshShape>(mesh.get(), true), {0, 0.05f, 0});
    for (int i = 0; i < 6; ++i) {
        auto& shape = static_cast<btCompoundShape&>(s.shape<btCompoundShape>());
        btTransform at = btTransform::getIdentity();
        for (const float side : {-1.0f, 1.0f}) {
            at.setOrigin(btVector3(0.2f * side, 0, 0));
            shape.addChildShape(at, &s.shape<btBoxShape>(btVector3(0.1f, 0.1f, 0.1f)));
        }
        s.add(5, shape, {0.2f * static_cast<float>(i - 3), 1.5f + 0.4f * static_cast<float>(i), 0});
    }
    return w;
}

/// A multibody of three links that scratches the soil with a motor.
std::unique_ptr<TestWorld> build_multibody() {
    auto w = std::make_unique<TestWorld>();
    add_soil(*w);
    BulletScene& s = w->scene;
    const int links = 3;
    w->multibody =
        std::make_unique<btMultiBody>(links, btScalar(20), btVector3(1, 1, 1), false, true);
    btMultiBody& m = *w->multibody;
    m.setBasePos(btVector3(0, 0.65f, 0));
    for (int i = 0; i < links; ++i) {
        m.setupRevolute(i, 4, btVector3(0.1f, 0.1f, 0.1f), i - 1, btQuaternion::getIdentity(),
                        btVector3(0, 0, 1), btVector3(i == 0 ? 0.25f : 0.2f, 0, 0),
                        btVector3(0.2f, 0, 0), true);
    }
    m.finalizeMultiDof();
    s.world->addMultiBody(&m);
    for (int i = -1; i < links; ++i) {
        auto collider = std::make_unique<btMultiBodyLinkCollider>(&m, i);
        collider->setCollisionShape(&s.shape<btBoxShape>(i < 0 ? btVector3(0.25f, 0.15f, 0.3f)
                                                               : btVector3(0.17f, 0.1f, 0.15f)));
        s.world->addCollisionObject(collider.get(), btBroadphaseProxy::DefaultFilter,
                                    btBroadphaseProxy::AllFilter);
        (i < 0 ? m.setBaseCollider(collider.get())
               : static_cast<void>(m.getLink(i).m_collider = collider.get()));
        w->colliders.push_back(std::move(collider));
    }
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    m.forwardKinematics(rotations, origins);
    m.updateCollisionObjectWorldTransforms(rotations, origins);
    auto motor = std::make_unique<btMultiBodyJointMotor>(&m, 1, btScalar(-0.8), btScalar(2));
    s.world->addMultiBodyConstraint(motor.get());
    w->multibody_constraints.push_back(std::move(motor));
    s.add_box(30, {0.2f, 0.15f, 0.2f}, {-0.8f, 0.6f, 0.5f});
    return w;
}

TEST_F(WorldSnapshot, machine_on_soil_goes_on_bit_for_bit) {
    for (const int before : {0, 1, 40}) expect_goes_on(build_machine, before, 40);
}

TEST_F(WorldSnapshot, bodies_on_the_ground_go_on_bit_for_bit_while_it_slumps) {
    // The ground is a mesh to Bullet: its contacts are found anew when the world is saved.
    for (const int before : {20, 30, 40, 50, 60}) {
        expect_goes_on(build_bodies_on_ground, before, 60, true);
    }
}

TEST_F(WorldSnapshot, a_ball_goes_on_bit_for_bit_from_anywhere_in_its_impact) {
    const auto dropped = [] {
        auto world = std::make_unique<TestWorld>();
        SoilDef def;
        def.size_m = {2, 1, 2};
        def.backend = Backend::cpu;
        auto soil = SoilAction::create(world->world(), def);
        EXPECT_TRUE(soil) << soil.error();
        world->soil = std::move(*soil);
        EXPECT_TRUE(world->soil->fill(BoxFill{{{-1, 0, -1}, {1, 0.4, 1}}, "dry_sand"}));
        world->scene.add(200, world->scene.shape<btSphereShape>(btScalar(0.3)),
                         {0, btScalar(1.4), 0});
        return world;
    };
    for (const int before : {21, 22, 23, 24, 26, 40}) expect_goes_on(dropped, before, 30);
}

TEST_F(WorldSnapshot, heap_goes_on_bit_for_bit_while_it_falls_and_sleeps) {
    for (const int before : {0, 25, 90, 300}) expect_goes_on(build_heap, before, 120);
}

TEST_F(WorldSnapshot, compounds_and_meshes_go_on_as_the_run_that_saved) {
    for (const int before : {30, 120}) expect_goes_on(build_compounds, before, 120, true);
}

// Where such a mesh touched the ground that was saved, and not the one that stood there before
// loading, or the other way round, the file was refused as damaged.
TEST_F(WorldSnapshot, moving_meshes_on_the_ground_go_on_as_the_run_that_saved) {
    for (const int before : {10, 35, 60}) {
        SCOPED_TRACE(before);
        expect_goes_on(build_moving_meshes, before, 40, true);
    }
}

/// How often Bullet has said that a contact begins.
int begun = 0;

TEST_F(WorldSnapshot, no_contact_begins_on_the_ground_while_a_world_is_saved_or_loaded) {
    const auto w = build_moving_meshes();
    w->run(60);
    gContactStartedCallback = [](btPersistentManifold* const&) { ++begun; };
    const Status saved = w->save(path("a")), loaded = w->load(path("a"));
    gContactStartedCallback = nullptr;
    ASSERT_TRUE(saved) << saved.error();
    ASSERT_TRUE(loaded) << loaded.error();
    EXPECT_EQ(begun, 0);
}

TEST_F(WorldSnapshot, multibody_on_soil_goes_on_bit_for_bit) {
    for (const int before : {1, 45}) expect_goes_on(build_multibody, before, 45);
}

// Bullet makes room for their impulses in the first step alone.
TEST_F(WorldSnapshot, multibody_constraints_that_no_step_has_solved_for_are_saved_and_loaded) {
    const auto build = [] {
        auto w = build_multibody();
        auto limit = std::make_unique<btMultiBodyJointLimitConstraint>(
            w->multibody.get(), 2, btScalar(-0.1), btScalar(0.1));
        w->scene.world->addMultiBodyConstraint(limit.get());
        w->multibody_constraints.push_back(std::move(limit));
        return w;
    };
    for (const int before : {0, 45}) {
        const auto saved = build(), restored = build();
        saved->run(before);
        ASSERT_TRUE(saved->save(path("a")));
        const Status loaded = restored->load(path("a"));
        ASSERT_TRUE(loaded) << loaded.error();
        ASSERT_TRUE(restored->save(path("b")));
        EXPECT_EQ(bytes_of(path("b")), bytes_of(path("a"))) << "an impulse was lost";
        for (int i = 0; i < 20; ++i) {
            saved->step();
            restored->step();
            ASSERT_EQ(restored->checksum(), saved->checksum())
                << "frame " << i << " after " << before;
        }
    }
}

TEST_F(WorldSnapshot, raycast_vehicle_goes_on_bit_for_bit) {
    const auto alone = build_car(1), saved = build_car(1);
    const auto report = [&](int i) { return saved->caster->wheel_report(i); };
    const auto in_contact = [&](int i) {
        return saved->car->vehicle->getWheelInfo(i).m_raycastInfo.m_isInContact;
    };
    const auto standing = [&] { return report(0).is_on_soil && report(3).is_on_soil; };
    const auto spinning = [&] { return report(0).slip > 0.3; };
    const auto steered = [&] {
        return saved->car->vehicle->getSteeringValue(0) > 0 && report(0).side_force_n != 0;
    };
    const auto some_in_the_air = [&] {
        int count = 0;
        for (int i = 0; i < 4; ++i) count += in_contact(i) ? 0 : 1;
        return count > 0;
    };
    const auto braked = [&] {
        return saved->car->vehicle->getWheelInfo(0).m_brake > 0 && std::abs(report(0).slip) > 0;
    };
    const auto asleep = [&] { return !saved->car->chassis.isActive(); };
    const std::pair<const char*, std::function<bool()>> moments[] = {
        {"at the start", [&] { return saved->frame == 0; }},
        {"after a step", [&] { return saved->frame == 1; }},
        {"one in the air", some_in_the_air},
        {"standing", standing},
        {"spinning", spinning},
        {"steered", steered},
        {"braked", braked},
        {"asleep", asleep}};
    constexpr int kFrames = 300, kAfter = 60;
    std::vector<uint64_t> expected{alone->checksum()};
    for (int i = 0; i < kFrames + kAfter; ++i) {
        alone->step();
        expected.push_back(alone->checksum());
    }
    std::set<std::string> tried;
    for (; saved->frame <= kFrames; saved->step()) {
        const int frame = saved->frame;
        ASSERT_EQ(saved->checksum(), expected[static_cast<size_t>(frame)]);
        const auto moment =
            std::find_if(std::begin(moments), std::end(moments),
                         [&](const auto& m) { return !tried.contains(m.first) && m.second(); });
        if (moment == std::end(moments)) continue;
        tried.insert(moment->first);
        SCOPED_TRACE(testing::Message() << moment->first << ", frame " << frame);
        Status done = saved->save(path("a"));
        ASSERT_TRUE(done) << done.error();
        const auto restored = build_car(1);
        restored->run(3);  // another history
        restored->frame = frame;
        done = restored->load(path("a"));
        ASSERT_TRUE(done) << done.error();
        ASSERT_TRUE(restored->save(path("b")));
        ASSERT_EQ(bytes_of(path("b")), bytes_of(path("a")));
        for (int i = frame; i <= frame + kAfter; ++i) {
            ASSERT_EQ(restored->checksum(), expected[static_cast<size_t>(i)]) << i;
            restored->step();
        }
    }
    for (const auto& moment : moments) EXPECT_TRUE(tried.contains(moment.first)) << moment.first;
}

TEST_F(WorldSnapshot, raycast_vehicle_goes_on_in_the_middle_of_a_soil_step) {
    expect_goes_on([] { return build_car(3); }, 60, 20);
    const auto slow = [] {
        auto w = build_car(1);
        w->substep_s = w->frame_s = kFrameS / 3;
        return w;
    };
    for (const int before : {79, 80, 81}) expect_goes_on(slow, before, 20);
}

TEST_F(WorldSnapshot, soil_and_coupling_alone_go_on_where_the_host_puts_the_bodies) {
    // Kinematic bodies only: their poses are the host's.
    const auto build = [] {
        auto w = std::make_unique<TestWorld>();
        add_soil(*w);
        add_driven_blade(*w);
        return w;
    };
    const auto saved = build(), restored = build();
    saved->run(30);
    ASSERT_TRUE(saved->soil->save(path("a")));
    restored->frame = 29;
    restored->step();  // brings the body there
    const Status loaded = restored->soil->load(path("a"));
    ASSERT_TRUE(loaded) << loaded.error();
    EXPECT_EQ(restored->soil->step_count(), saved->soil->step_count());
    const BodyReport report = saved->soil->body_report(*saved->driven);
    EXPECT_GT(length(report.force_n), 0);
    EXPECT_EQ(restored->soil->body_report(*restored->driven).force_n.x, report.force_n.x);
    EXPECT_EQ(restored->soil->body_report(*restored->driven).peak_force_n, report.peak_force_n);
    for (int i = 0; i < 30; ++i) {
        saved->step();
        restored->step();
        ASSERT_EQ(restored->soil->soil().checksum(), saved->soil->soil().checksum()) << i;
        ASSERT_EQ(restored->soil->body_report(*restored->driven).force_n.x,
                  saved->soil->body_report(*saved->driven).force_n.x);
    }
}

TEST_F(WorldSnapshot, a_soil_that_is_off_stays_off) {
    const auto saved = build_machine(), restored = build_machine();
    saved->run(20);
    saved->soil->set_enabled(false);
    saved->run(2);
    ASSERT_TRUE(saved->save(path("a")));
    restored->frame = saved->frame;
    ASSERT_TRUE(restored->load(path("a")));
    EXPECT_FALSE(restored->soil->is_enabled());
    for (int i = 0; i < 20; ++i) {
        if (i == 5) {
            for (TestWorld* w : {saved.get(), restored.get()}) w->soil->set_enabled(true);
        }
        saved->step();
        restored->step();
        ASSERT_EQ(restored->checksum(), saved->checksum()) << i;
    }
}

/// A body that the soil refuses, and that turns as it comes down onto its ground.
std::unique_ptr<TestWorld> build_refused() {
    auto w = std::make_unique<TestWorld>();
    add_soil(*w);
    w->scene.add_flat_hull({0, 0.55f, 0}).setAngularVelocity(btVector3(1, 0, 0.5f));
    return w;
}

TEST_F(WorldSnapshot, a_refused_body_goes_on_as_in_the_run_that_saved) {
    for (const int before : {8, 14, 20, 30}) expect_goes_on(build_refused, before, 20, true);
}

TEST_F(WorldSnapshot, a_soil_that_is_off_knows_what_it_has_refused) {
    const auto saved = build_refused(), restored = build_refused();
    saved->soil->set_enabled(false);
    saved->run(14);
    ASSERT_FALSE(saved->soil->refused().empty());
    ASSERT_TRUE(saved->save(path("a")));
    restored->frame = saved->frame;
    ASSERT_TRUE(restored->load(path("a")));
    for (int i = 0; i < 40; ++i) {
        saved->step();
        restored->step();
        ASSERT_EQ(restored->checksum(), saved->checksum()) << i;
    }
    EXPECT_GT(restored->scene.bodies[0]->getWorldTransform().getOrigin().y(), 0.3f);
}

TEST_F(WorldSnapshot, a_loaded_body_that_its_host_puts_elsewhere_leaves_its_load_behind) {
    const auto saved = build_machine(), restored = build_machine();
    saved->run(30);
    ASSERT_TRUE(saved->save(path("a")));
    restored->frame = saved->frame;
    ASSERT_TRUE(restored->load(path("a")));
    for (TestWorld* w : {saved.get(), restored.get()}) {
        btRigidBody& scoop = *w->scene.bodies[3];
        ASSERT_GT(w->soil->body_report(scoop).load_kg, 5);
        btTransform pose = scoop.getWorldTransform();
        pose.setOrigin(btVector3(0, 4, 0));
        scoop.setWorldTransform(pose);
        scoop.setLinearVelocity(btVector3(0, 0, 0));
        scoop.applyCentralForce(btVector3(0, 0, 100));
        w->step();
    }
    EXPECT_EQ(restored->checksum(), saved->checksum());
}

// Until the next substep it was that of a driven body.
TEST_F(WorldSnapshot, a_body_that_its_host_puts_elsewhere_before_it_is_saved_flies_free) {
    const auto build = [] {
        auto w = std::make_unique<TestWorld>();
        add_soil(*w);
        w->frame_s = w->substep_s = kFrameS / 4;
        w->scene.add(30, w->scene.shape<btSphereShape>(btScalar(0.2)), {0, 0.6f, 0});
        return w;
    };
    const auto saved = build(), restored = build();
    saved->run(120);
    restored->run(5);
    restored->frame = saved->frame;
    btRigidBody& ball = *saved->scene.bodies.front();
    btTransform pose = ball.getWorldTransform();
    pose.setOrigin(pose.getOrigin() + btVector3(0, 1, 0));
    ball.setWorldTransform(pose);
    ball.activate(true);
    ASSERT_TRUE(saved->save(path("a")));
    ASSERT_TRUE(restored->load(path("a")));
    for (int i = 1; i < 20; ++i) {
        saved->step();
        restored->step();
        ASSERT_EQ(restored->checksum(), saved->checksum()) << i;
        ASSERT_NEAR(ball.getLinearVelocity().y(), btScalar(-9.81) * saved->frame_s * btScalar(i),
                    1e-3);
    }
}

TEST_F(WorldSnapshot, reports_know_what_a_body_feels_of_its_load) {
    const auto saved = build_machine(), restored = build_machine();
    saved->run(30);
    ASSERT_TRUE(saved->save(path("a")));
    ASSERT_TRUE(restored->load(path("a")));
    const Vec3 felt_n = saved->soil->body_report(*saved->scene.bodies[3]).load_n;
    ASSERT_LT(felt_n.y, -5 * 9.8) << "it carries more than 5 kg";
    const Vec3 found_n = restored->soil->body_report(*restored->scene.bodies[3]).load_n;
    EXPECT_EQ(std::tuple(found_n.x, found_n.y, found_n.z),
              std::tuple(felt_n.x, felt_n.y, felt_n.z));
}

/// An arm on a cone twist joint, whose motor is commanded once to turn it aside.
std::unique_ptr<TestWorld> build_arm() {
    auto w = std::make_unique<TestWorld>();
    btRigidBody& post = w->scene.add_box(0, {0.1f, 1, 0.1f}, {0, 1, 0});
    btRigidBody& arm = w->scene.add_box(5, {0.1f, 0.5f, 0.1f}, {0, 3, 0});
    btTransform on_post = btTransform::getIdentity(), on_arm = btTransform::getIdentity();
    on_post.setOrigin(btVector3(0, 1.25f, 0));
    on_arm.setOrigin(btVector3(0, -0.75f, 0));
    auto joint = std::make_unique<btConeTwistConstraint>(post, arm, on_post, on_arm);
    joint->setLimit(1, 1, 1);
    w->world().addConstraint(joint.get(), true);
    w->constraints.push_back(std::move(joint));
    w->command = [](TestWorld& t) {
        if (t.frame != 5) return;
        auto& cone = static_cast<btConeTwistConstraint&>(*t.constraints[0]);
        cone.enableMotor(true);
        cone.setMaxMotorImpulseNormalized(2);
        cone.setMotorTarget(btQuaternion(btVector3(0, 0, 1), 0.5f));
    };
    return w;
}

// It was commanded before, and the restored joint hung loose.
TEST_F(WorldSnapshot, the_motor_of_a_cone_twist_joint_goes_on) {
    expect_goes_on(build_arm, 20, 40);
}

// It held a scoop as heavy as it is with its load, and fitted no world.
TEST_F(WorldSnapshot, a_soil_may_be_saved_after_a_look_for_contacts) {
    const auto w = build_machine();
    w->run(30);
    ASSERT_GT(w->soil->body_report(*w->scene.bodies[3]).load_kg, 5);
    w->world().performDiscreteCollisionDetection();
    ASSERT_TRUE(w->soil->save(path("a")));
    w->step();
    const Status loaded = w->soil->load(path("a"));
    EXPECT_TRUE(loaded) << loaded.error();
    w->world().performDiscreteCollisionDetection();
    EXPECT_TRUE(w->soil->load(path("a")));
}

TEST_F(WorldSnapshot, a_world_that_has_blown_up_can_be_put_back) {
    const auto w = build_heap();
    w->run(20);
    ASSERT_TRUE(w->save(path("a")));
    const uint64_t good = w->checksum();
    const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
    w->scene.bodies[5]->setLinearVelocity(btVector3(nan, 0, 0));
    const Status refused = w->save(path("b"));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().find("finite"), std::string::npos) << refused.error();
    const Status loaded = w->load(path("a"));
    ASSERT_TRUE(loaded) << loaded.error();
    EXPECT_EQ(w->checksum(), good);
}

}  // namespace
}  // namespace bsoil::bullet::world_snapshot_test
