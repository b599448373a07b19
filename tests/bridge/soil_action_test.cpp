// The soil in a Bullet world, end to end.
#include "bsoil/bullet/soil_action.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "bullet_scene.h"
#include "temporary_file.h"

namespace bsoil::bullet::soil_action_test {
namespace {

constexpr double kGravity_m_s2 = 9.81;

SoilDef small_bed() {
    SoilDef def;
    def.size_m = {2, 1, 2};
    def.voxel_m = 0.05;
    def.backend = Backend::cpu;
    return def;
}

/// A bed of dry sand with its surface at y = 0.4 m.
std::unique_ptr<SoilAction> sand_bed(BulletScene& scene, const SoilDef& def = small_bed(),
                                     const SoilActionDef& options = {}) {
    auto soil = SoilAction::create(*scene.world, def, options);
    EXPECT_TRUE(soil) << soil.error();
    if (!soil) return nullptr;
    BoxFill fill;
    fill.box = {{-2, -1, -2}, {2, 0.4, 2}};
    fill.material = def.material.name;
    const Status filled = (*soil)->fill(fill);
    EXPECT_TRUE(filled) << filled.error();
    return std::move(*soil);
}

int64_t units(const SoilAction& soil) {
    int64_t sum = 0;
    for (const int64_t u : soil.soil().totals().units) sum += u;
    return sum;
}

TEST(SoilAction, dropped_box_rests_sleeps_and_weighs_what_it_weighs) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    const int64_t before = units(*soil);
    btRigidBody& box = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.7f, 0));
    scene.run(2);
    EXPECT_LT(box.getLinearVelocity().length(), 0.02f);
    scene.run(4);
    EXPECT_FALSE(box.isActive());
    const BodyReport report = soil->body_report(box);
    EXPECT_NEAR(report.force_n.y, 50 * kGravity_m_s2, 0.05 * 50 * kGravity_m_s2);
    EXPECT_LT(std::hypot(report.force_n.x, report.force_n.z), 0.05 * 50 * kGravity_m_s2);
    EXPECT_GT(report.contact_area_m2, 0.1);
    EXPECT_GE(report.peak_force_n, report.force_n.y);
    EXPECT_GT(box.getWorldTransform().getOrigin().y(), 0.4f);
    EXPECT_LT(box.getWorldTransform().getOrigin().y(), 0.65f);
    EXPECT_EQ(units(*soil), before);
    EXPECT_TRUE(soil->refused().empty());
}

TEST(SoilAction, box_rests_with_z_up_as_well) {
    BulletScene scene;
    scene.world->setGravity(btVector3(0, 0, btScalar(-kGravity_m_s2)));
    SoilDef def = small_bed();
    def.up = UpAxis::z;
    def.size_m = {2, 2, 1};
    auto soil = SoilAction::create(*scene.world, def);
    ASSERT_TRUE(soil) << soil.error();
    BoxFill fill;
    fill.box = {{-2, -2, -1}, {2, 2, 0.4}};
    fill.material = def.material.name;
    ASSERT_TRUE((*soil)->fill(fill));
    btRigidBody& box = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0, 0.7f));
    scene.run(2);
    EXPECT_NEAR((*soil)->body_report(box).force_n.z, 50 * kGravity_m_s2, 50);
    EXPECT_GT(box.getWorldTransform().getOrigin().z(), 0.4f);
}

TEST(SoilAction, steps_at_its_own_rate_whatever_bullets_is) {
    for (const int substeps : {1, 2, 4}) {
        BulletScene scene;
        const auto soil = sand_bed(scene);
        scene.run(1, substeps);
        EXPECT_NEAR(static_cast<double>(soil->step_count()), 60, 1) << substeps;
    }
    BulletScene scene;
    SoilDef def = small_bed();
    def.step_s = 1.0 / 180;
    const auto soil = sand_bed(scene, def);
    scene.run(0.5);
    EXPECT_NEAR(static_cast<double>(soil->step_count()), 90, 1);
}

TEST(SoilAction, nothing_happens_in_time_that_is_not_a_time) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    for (const btScalar dt :
         {std::numeric_limits<btScalar>::quiet_NaN(), std::numeric_limits<btScalar>::infinity(),
          btScalar(0), btScalar(-1)}) {
        soil->updateAction(scene.world.get(), dt);
    }
    EXPECT_EQ(soil->step_count(), 0);
    soil->updateAction(scene.world.get(), 1000);
    EXPECT_LE(soil->step_count(), 256);
}

TEST(SoilAction, report_has_nothing_of_a_soil_that_another_has_replaced) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    const TemporaryFile file("report_of_replaced_soil.snapshot");
    ASSERT_TRUE(soil->soil().save(file.path()));
    btRigidBody& box = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.6f, 0));
    ASSERT_TRUE(soil->fill(BoxFill{{{-0.1, 0.85, -0.1}, {0.1, 0.95, 0.1}}, {}}));
    scene.run(0.3);
    ASSERT_FALSE(soil->last_report().contacts.empty());
    ASSERT_FALSE(soil->last_report().loads.empty());
    ASSERT_TRUE(soil->soil().load(file.path()));
    EXPECT_TRUE(soil->last_report().contacts.empty());
    EXPECT_TRUE(soil->last_report().loads.empty());
    EXPECT_EQ(soil->last_report().substep_count, 0);
    EXPECT_EQ(soil->body_report(box).load_kg, 0);
    scene.run(0.3);
    EXPECT_FALSE(soil->last_report().contacts.empty());
    EXPECT_GT(soil->body_report(box).patch_count, 0);
}

TEST(SoilAction, creation_errors_name_the_field) {
    BulletScene scene;
    SoilDef def = small_bed();
    def.voxel_m = -1;
    const auto bad_soil = SoilAction::create(*scene.world, def);
    ASSERT_FALSE(bad_soil);
    EXPECT_NE(bad_soil.error().find("voxel_m"), std::string::npos) << bad_soil.error();
    SoilActionDef options;
    options.wake_limit_fraction = -1;
    const auto bad_options = SoilAction::create(*scene.world, small_bed(), options);
    ASSERT_FALSE(bad_options);
    EXPECT_NE(bad_options.error().find("wake_limit_fraction"), std::string::npos);
    EXPECT_EQ(scene.world->getNumCollisionObjects(), 0);
}

TEST(SoilAction, nan_pose_is_reported_and_harms_nothing) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    btRigidBody& box = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.7f, 0));
    // A static body: Bullet itself does not move it, and its broadphase never sees the NaN.
    btRigidBody& bad = scene.add_box(0, btVector3(0.2f, 0.2f, 0.2f), btVector3(5, 0.5f, 0));
    scene.world->setForceUpdateAllAabbs(false);
    btTransform nan = bad.getWorldTransform();
    nan.setOrigin(btVector3(std::numeric_limits<btScalar>::quiet_NaN(), 0, 0));
    bad.setWorldTransform(nan);
    scene.run(2);
    EXPECT_NE(soil->soil().status_bits() & static_cast<uint32_t>(StatusBit::pose_not_finite), 0u);
    ASSERT_EQ(soil->refused().size(), 1u);
    EXPECT_EQ(soil->refused()[0].object, &bad);
    const std::vector<ObjectCondition> conditions = soil->conditions();
    ASSERT_EQ(conditions.size(), 1u);
    EXPECT_EQ(conditions[0].object, &bad);
    EXPECT_EQ(conditions[0].condition.bit, StatusBit::pose_not_finite);
    EXPECT_EQ(conditions[0].condition.first_step, 1);
    EXPECT_NE(soil->refused()[0].reason.find("not finite"), std::string::npos);
    EXPECT_NEAR(soil->body_report(box).force_n.y, 50 * kGravity_m_s2, 50);
}

TEST(SoilAction, body_far_outside_is_left_alone) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    btRigidBody& box = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(1000, 0.5f, 0));
    scene.run(0.5);
    EXPECT_EQ(soil->body_id(box), -1);
    EXPECT_EQ(soil->body_report(box).patch_count, 0);
    EXPECT_NEAR(box.getLinearVelocity().y(), -0.5f * 9.81f, 0.02f);
}

TEST(SoilAction, body_thrown_out_of_the_grid_is_let_go) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    btRigidBody& box = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.55f, 0));
    scene.run(0.5);
    EXPECT_GT(soil->body_report(box).patch_count, 0);
    btTransform pose = box.getWorldTransform();
    pose.setOrigin(btVector3(1000, 1000, 0));
    box.setWorldTransform(pose);
    scene.run(0.1);
    EXPECT_EQ(soil->body_report(box).patch_count, 0);
    EXPECT_EQ(length(soil->body_report(box).force_n), 0);
}

TEST(SoilAction, unusable_shapes_are_refused_by_name) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    btRigidBody& flat =
        scene.add(0, scene.shape<btBoxShape>(btVector3(0.2f, 0, 0.2f)), btVector3(0, 0.3f, 0));
    flat.setUserIndex(42);
    btTriangleMesh mesh;
    mesh.addTriangle({-1, 0.2f, 0}, {0, 0.2f, 0}, {1, 0.2f, 0});  // in a line
    btRigidBody& ground =
        scene.add(0, scene.shape<btBvhTriangleMeshShape>(&mesh, true), btVector3(0, 0, 0));
    scene.run(0.1);
    ASSERT_EQ(soil->refused().size(), 2u);
    EXPECT_EQ(soil->refused()[0].object, &flat);
    EXPECT_NE(soil->refused()[0].reason.find("half extent y"), std::string::npos);
    EXPECT_NE(soil->refused()[0].reason.find("user index 42"), std::string::npos);
    EXPECT_EQ(soil->refused()[1].object, &ground);
    EXPECT_NE(soil->refused()[1].reason.find("BVHTRIANGLEMESH"), std::string::npos);
    EXPECT_NE(soil->refused()[1].reason.find("no area"), std::string::npos);
}

TEST(SoilAction, ignored_objects_and_sensors_do_not_touch_the_soil) {
    BulletScene scene;
    btRigidBody& ignored = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0.5f, 0.5f, 0));
    btRigidBody& sensor = scene.add_box(0, btVector3(0.2f, 0.2f, 0.2f), btVector3(-0.5f, 0.5f, 0));
    sensor.setCollisionFlags(sensor.getCollisionFlags() |
                             btCollisionObject::CF_NO_CONTACT_RESPONSE);
    SoilActionDef options;
    options.ignored = {&ignored};
    options.ground = false;  // or it would carry the ignored body
    const auto soil = sand_bed(scene, small_bed(), options);
    scene.run(0.2);
    EXPECT_EQ(soil->body_id(ignored), -1);
    EXPECT_EQ(soil->body_id(sensor), -1);
    EXPECT_TRUE(soil->last_report().contacts.empty());
    EXPECT_NEAR(ignored.getLinearVelocity().y(), -0.2f * 9.81f, 0.02f);
}

TEST(SoilAction, kinematic_blade_moves_soil_and_reports_a_draft) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    btRigidBody& blade = scene.add_box(0, btVector3(0.05f, 0.2f, 0.3f), btVector3(-0.5f, 0.5f, 0));
    blade.setCollisionFlags(blade.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    blade.setActivationState(DISABLE_DEACTIVATION);
    scene.run(0.2);
    for (int frame = 1; frame <= 60; ++frame) {
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(btVector3(-0.5f + 0.5f * btScalar(frame) / 60, 0.5f, 0));
        blade.setWorldTransform(pose);
        scene.run(1.0 / 60);
    }
    EXPECT_LT(soil->body_report(blade).force_n.x, -50);
    EXPECT_GT(soil->body_report(blade).sinkage_m, 0.05);
    EXPECT_NEAR(blade.getWorldTransform().getOrigin().x(), 0, 1e-5);
}

TEST(SoilAction, shape_scaled_while_in_the_soil_is_converted_again) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    btRigidBody& box = scene.add_box(0, btVector3(0.1f, 0.1f, 0.1f), btVector3(0, 0.45f, 0));
    box.setCollisionFlags(box.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    box.setActivationState(DISABLE_DEACTIVATION);
    scene.run(0.3);
    const double small_m2 = soil->body_report(box).contact_area_m2;
    box.getCollisionShape()->setLocalScaling(btVector3(3, 1, 3));
    scene.run(0.3);
    EXPECT_GT(soil->body_report(box).contact_area_m2, 3 * small_m2);
}

TEST(SoilAction, soil_destroyed_first_leaves_the_world_as_it_was) {
    BulletScene scene;
    btRigidBody& box = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.55f, 0));
    {
        const auto soil = sand_bed(scene);
        scene.run(0.2);
        EXPECT_EQ(scene.world->getNumCollisionObjects(), 3);
    }
    EXPECT_EQ(scene.world->getNumCollisionObjects(), 1);
    EXPECT_EQ(scene.world->getNumConstraints(), 0);
    box.setLinearVelocity(btVector3(0, 0, 0));
    scene.run(0.5);
    EXPECT_NEAR(box.getLinearVelocity().y(), -0.5f * 9.81f, 0.02f);
}

TEST(SoilAction, world_destroyed_first_is_noticed) {
    BulletScene scene;
    scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.55f, 0));
    const auto soil = sand_bed(scene);
    scene.run(0.2);
    const TemporaryFile file("world_destroyed.snapshot");
    ASSERT_TRUE(soil->save(file.path()));
    scene.world.reset();
    EXPECT_GT(soil->step_count(), 0);
    // The bodies that a snapshot of the coupling names are gone.
    for (const Status& status : {soil->save(file.path()), soil->load(file.path())}) {
        ASSERT_FALSE(status);
        EXPECT_NE(status.error().find("destroyed"), std::string::npos) << status.error();
    }
    EXPECT_TRUE(soil->soil().load(file.path()));
}

TEST(SoilAction, host_may_delete_every_object_of_its_world) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    btBoxShape shape(btVector3(0.2f, 0.2f, 0.2f));
    btTransform pose = btTransform::getIdentity();
    pose.setOrigin(btVector3(0, 0.55f, 0));
    auto* body = new btRigidBody(50, nullptr, &shape, btVector3(1, 1, 1));
    body->setWorldTransform(pose);
    scene.world->addRigidBody(body);
    scene.run(0.2);
    for (int i = scene.world->getNumCollisionObjects() - 1; i >= 0; --i) {
        btCollisionObject* object = scene.world->getCollisionObjectArray()[i];
        scene.world->removeCollisionObject(object);
        delete object;
    }
    scene.run(0.2);
    scene.world.reset();
}

TEST(SoilAction, anchor_taken_out_by_the_host_comes_back) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    btRigidBody& box = scene.add_box(50, btVector3(0.2f, 0.2f, 0.2f), btVector3(0, 0.61f, 0));
    scene.world->removeCollisionObject(scene.world->getCollisionObjectArray()[0]);
    scene.run(2);
    EXPECT_EQ(scene.world->getNumCollisionObjects(), 3);
    EXPECT_NEAR(soil->body_report(box).force_n.y, 50 * kGravity_m_s2, 50);
}

TEST(SoilAction, bodies_come_and_go_between_steps) {
    BulletScene scene;
    const auto soil = sand_bed(scene);
    for (int round = 0; round < 10; ++round) {
        btRigidBody& a = scene.add_box(20, btVector3(0.1f, 0.1f, 0.1f), btVector3(0.3f, 0.5f, 0));
        scene.add_box(20, btVector3(0.1f, 0.1f, 0.1f), btVector3(-0.3f, 0.5f, 0));
        scene.run(0.1);
        scene.remove(a);
        scene.run(1.0 / 60);
        scene.remove(*scene.bodies.back());
    }
    scene.run(0.1);
    EXPECT_TRUE(soil->last_report().contacts.empty());
}

TEST(SoilAction, works_in_a_world_without_multibodies) {
    BulletScene scene;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&scene.dispatcher, &scene.broadphase, &solver,
                                  &scene.configuration);
    world.setGravity(btVector3(0, btScalar(-kGravity_m_s2), 0));
    btBoxShape shape(btVector3(0.2f, 0.2f, 0.2f));
    btVector3 inertia;
    shape.calculateLocalInertia(50, inertia);
    btRigidBody body(50, nullptr, &shape, inertia);
    btTransform pose = btTransform::getIdentity();
    pose.setOrigin(btVector3(0, 0.61f, 0));
    body.setWorldTransform(pose);
    world.addRigidBody(&body);
    auto soil = SoilAction::create(world, small_bed());
    ASSERT_TRUE(soil);
    BoxFill fill;
    fill.box = {{-2, -1, -2}, {2, 0.4, 2}};
    fill.material = small_bed().material.name;
    ASSERT_TRUE((*soil)->fill(fill));
    for (int frame = 0; frame < 120; ++frame) world.stepSimulation(btScalar(1) / 60);
    EXPECT_NEAR((*soil)->body_report(body).force_n.y, 50 * kGravity_m_s2, 50);
    world.removeRigidBody(&body);
}

}  // namespace
}  // namespace bsoil::bullet::soil_action_test
