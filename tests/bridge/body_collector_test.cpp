// The ids that bodies have for the soil.
#include "body_collector.h"

#include <gtest/gtest.h>

#include <set>

#include "bsoil/limits.h"
#include "bullet_scene.h"
#include "mesh_crossings.h"

namespace bsoil::bullet::body_collector_test {
namespace {

// Wheels of raycast vehicles, which are attached for longer.
TEST(BodyCollector, that_lets_go_gives_back_the_ids_of_objects_alone) {
    BulletScene scene;
    btRigidBody& box = scene.add_box(1, btVector3(0.1f, 0.1f, 0.1f), btVector3(0, 0, 0));
    BodyCollector collector({{-1, -1, -1}, {1, 1, 1}});
    const int wheel = collector.take_id();
    collector.collect(*scene.world, 0.1);
    ASSERT_GE(collector.body_id(box), 0);
    collector.let_go();
    EXPECT_EQ(collector.body_id(box), -1);
    for (int i = 0; i < limits::kBodyIdMost; ++i) {
        const int id = collector.take_id();
        ASSERT_GE(id, 0) << i;
        ASSERT_NE(id, wheel) << i;
    }
    EXPECT_EQ(collector.take_id(), -1) << "there are no more";
    collector.give_back_id(wheel);
    EXPECT_EQ(collector.take_id(), wheel);
}

// Of a long body that stands askew, the box reaches into the grid and the body does not. It was
// refused as it went by.
TEST(BodyCollector, that_meets_nothing_of_a_body_refuses_none) {
    BulletScene scene;
    const btVector3 centers[] = {{-3, 0, 0}, {3, 0, 0}};
    const btScalar radii[] = {0.5f, 0.6f};
    btRigidBody& beam = scene.add(5, scene.shape<btMultiSphereShape>(centers, radii, 2), {0, 0, 0});
    BodyCollector collector({{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}}, 0.1);
    const auto put = [&](const btVector3& at) {
        btTransform pose(btQuaternion(btVector3(0, 0, 1), SIMD_PI / 4));
        pose.setOrigin(at);
        beam.setWorldTransform(pose);
        collector.collect(*scene.world, 0.1);
        EXPECT_TRUE(collector.refused().empty()) << collector.refused().front().reason;
        EXPECT_TRUE(collector.is_coupled(beam));
        return collector.bodies().size();
    };
    EXPECT_EQ(put({2, 2, 0}), 1u);
    EXPECT_EQ(put({2.5f, -2.5f, 0}), 0u);
    EXPECT_EQ(put({2, 2, 0}), 1u);
    EXPECT_EQ(put({0, 30, 0}), 0u) << "it has left at once";
}

// What is larger than the grid is cut to it. A world with a stone of that kind took a quarter of an
// hour, since it was cut anew in each step.
TEST(BodyCollector, cuts_a_large_body_that_moves_a_little_once) {
    BulletScene scene;
    btTriangleMesh mesh;  // a bottom of 8 m and a point 4 m above it
    const btVector3 corners[] = {{-4, 0, -4}, {4, 0, -4}, {4, 0, 4}, {-4, 0, 4}, {0, 4, 0}};
    const int faces[][3] = {{0, 1, 2}, {0, 2, 3}, {1, 0, 4}, {2, 1, 4}, {3, 2, 4}, {0, 3, 4}};
    for (const auto& face : faces) {
        mesh.addTriangle(corners[face[0]], corners[face[1]], corners[face[2]]);
    }
    btBvhTriangleMeshShape shape(&mesh, true);
    btRigidBody roof(0, nullptr, &shape);
    roof.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    scene.world->addRigidBody(&roof);
    const Aabb grid{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
    BodyCollector collector(grid, 0.1);
    std::set<const ConvexShape*> cut;
    for (int step = 0; step <= 100; ++step) {
        btTransform pose(btQuaternion(btVector3(0, 1, 0), 0.002f * btScalar(step)));
        pose.setOrigin(btVector3(0.01f * btScalar(step), -0.2f, 0));
        roof.setWorldTransform(pose);
        collector.collect(*scene.world, 0.01);
        ASSERT_EQ(collector.bodies().size(), 1u) << step;
        const std::span<const ConvexShape> shapes = collector.shapes_of(collector.bodies()[0]);
        cut.insert(shapes.data());
        // All of the grid above its bottom is within it, wherever it was cut.
        ASSERT_EQ(shapes.size(), 1u) << step;
        for (const double x : {grid.min.x, grid.max.x}) {
            for (const double z : {grid.min.z, grid.max.z}) {
                for (const double y : {-0.4, 0.0, 0.5}) {
                    const Vec3 at =
                        transform(inverse(collector.bodies()[0].motion.pose), {x, y, z});
                    const double inside = y < -0.2 ? 1 : -1;
                    EXPECT_GT(inside * distance_to({shapes[0]}, at), 0) << step << " " << y;
                }
            }
        }
    }
    EXPECT_LE(cut.size(), 6u) << "a metre, in steps of half the grid's radius along two axes";
    scene.world->removeRigidBody(&roof);
}

// Its velocity was that from where it had left the grid, in one step.
TEST(BodyCollector, that_meets_a_driven_body_again_knows_how_fast_it_comes) {
    BulletScene scene;
    btBoxShape box(btVector3(0.1f, 0.1f, 0.1f));
    btCollisionObject object;  // of no velocity that Bullet knows
    object.setCollisionShape(&box);
    object.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    scene.world->addCollisionObject(&object);
    BodyCollector collector({{-1, -1, -1}, {1, 1, 1}});
    for (const btScalar x : {0.f, 5.f, 3.f, 2.f, 1.f}) {
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(btVector3(x, 0, 0));
        object.setWorldTransform(pose);
        collector.collect(*scene.world, 0.1);
    }
    ASSERT_EQ(collector.bodies().size(), 1u);
    EXPECT_NEAR(collector.bodies()[0].motion.linear_velocity_m_s.x, -10, 1e-4);
    scene.world->removeCollisionObject(&object);
}

}  // namespace
}  // namespace bsoil::bullet::body_collector_test
