// Ghosts of Bullet's character controllers on soil.
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>

#include "sand_bed.h"

namespace bsoil::bullet::character_test {
namespace {

constexpr btScalar kRadiusM = btScalar(0.2), kShaftM = btScalar(0.6);
constexpr double kHalfM = static_cast<double>(kRadiusM + kShaftM / 2);

/// A character of 1 m that comes down onto what is below it.
struct Character {
    BulletScene& scene;
    btGhostPairCallback pairs;
    btPairCachingGhostObject ghost;
    btCapsuleShape shape{kRadiusM, kShaftM};
    std::unique_ptr<btKinematicCharacterController> controller;

    explicit Character(BulletScene& in) : scene(in) {
        scene.broadphase.getOverlappingPairCache()->setInternalGhostPairCallback(&pairs);
        ghost.setCollisionShape(&shape);
        ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
        place(ghost, btVector3(-0.4f, btScalar(kBedTopM + kHalfM) + 0.1f, 0));
        scene.world->addCollisionObject(
            &ghost, btBroadphaseProxy::CharacterFilter,
            btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
        controller = std::make_unique<btKinematicCharacterController>(&ghost, &shape, btScalar(0.1),
                                                                      btVector3(0, 1, 0));
        controller->setGravity(btVector3(0, btScalar(-kGravity_m_s2), 0));
        scene.world->addAction(controller.get());
    }
    ~Character() {
        scene.world->removeAction(controller.get());
        scene.world->removeCollisionObject(&ghost);
        scene.broadphase.getOverlappingPairCache()->setInternalGhostPairCallback(nullptr);
    }
    double foot_m() const { return height_of(ghost) - kHalfM; }
    double x_m() const { return static_cast<double>(ghost.getWorldTransform().getOrigin().x()); }
};

/// How high its foot is at last, where it has walked on ground whose top is that of the bed.
double walked_height_m(BulletScene& scene) {
    Character character(scene);
    scene.run(1);
    EXPECT_TRUE(character.controller->onGround());
    character.controller->setWalkDirection(btVector3(btScalar(0.3) / 60, 0, 0));
    scene.run(1);
    EXPECT_NEAR(character.x_m(), -0.1, 0.05);
    return character.foot_m();
}

TEST(Character, stands_and_walks_on_the_soil_as_on_rigid_ground_and_leaves_it_as_it_is) {
    BulletScene rigid;
    const btScalar half_m = btScalar(kBedTopM / 2);
    rigid.add_box(0, btVector3(1, half_m, 1), btVector3(0, half_m, 0));
    const double rigid_m = walked_height_m(rigid);
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    scene.run(0.5);
    const uint64_t before = soil->soil().checksum();
    EXPECT_NEAR(walked_height_m(scene), rigid_m, 0.01);
    EXPECT_EQ(soil->soil().checksum(), before);
}

TEST(Character, a_ghost_pushes_soil_if_its_host_says_so) {
    BulletScene scene;
    const auto soil = sand_bed(*scene.world);
    Character character(scene);
    ASSERT_TRUE(soil->set_options(character.ghost, {.coverage_only = true}));
    scene.run(1);
    EXPECT_GE(soil->body_id(character.ghost), 0);
    EXPECT_GT(soil->body_report(character.ghost).contact_area_m2, 0);
}

}  // namespace
}  // namespace bsoil::bullet::character_test
