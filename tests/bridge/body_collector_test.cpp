// The ids that bodies have for the soil.
#include "body_collector.h"

#include <gtest/gtest.h>

#include "bsoil/limits.h"
#include "bullet_scene.h"

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

}  // namespace
}  // namespace bsoil::bullet::body_collector_test
