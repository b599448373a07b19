// Hosts that clear forces while the soil has some of its own on bodies.
#include "host_action.h"
#include "sand_bed.h"

namespace bsoil::bullet::cleared_forces_test {
namespace {

constexpr btScalar kSubstepS = btScalar(1) / 240;
constexpr double kWeightN = 981, kPushN = 200;

/// What an action ahead of the soil's does to the body in each substep.
using Act = void (*)(btRigidBody&);

void clear(btRigidBody& body) {
    body.clearForces();
    body.applyGravity();
}

void push(btRigidBody& body) { body.applyCentralForce(btVector3(0, btScalar(-kPushN), 0)); }

void clear_and_push(btRigidBody& body) {
    clear(body);
    push(body);
}

TEST(ClearedForces, a_body_is_as_heavy_as_it_is) {
    // Bullet keeps what an action has pushed with for the next substep, and so it adds up.
    const std::pair<Act, double> cases[] = {
        {clear, kWeightN}, {clear_and_push, kWeightN + kPushN}, {push, kWeightN + 3 * kPushN}};
    for (const auto& [act, expected_n] : cases) {
        BulletScene scene;
        btRigidBody* body = nullptr;
        HostAction action([&body, act = act] {
            if (body) act(*body);
        });
        scene.world->addAction(&action);
        const auto soil = sand_bed(*scene.world);
        btRigidBody& box = scene.add_box(100, btVector3(0.3f, 0.2f, 0.3f),
                                         btVector3(0, btScalar(kBedTopM) + 0.2f, 0));
        box.setActivationState(DISABLE_DEACTIVATION);
        body = &box;
        scene.run(2, 4);
        double sum_n = 0;
        for (int i = 0; i < 60; ++i) {
            scene.world->stepSimulation(4 * kSubstepS, 4, kSubstepS);
            sum_n += soil->body_report(box).force_n.y;
        }
        EXPECT_NEAR(sum_n / 60, expected_n, 0.03 * expected_n);
        scene.world->removeAction(&action);
    }
}

/// How high a tub of 20 kg full of sand lies at last.
double tub_height_m(Act act) {
    BulletScene scene;
    btRigidBody* body = nullptr;
    HostAction action([&body, act] {
        if (act && body) act(*body);
    });
    scene.world->addAction(&action);
    const auto soil = sand_bed(*scene.world);
    auto& shape = static_cast<btCompoundShape&>(scene.shape<btCompoundShape>());
    btTransform at = btTransform::getIdentity();
    const auto wall = [&](const btVector3& half, const btVector3& place_m) {
        at.setOrigin(place_m);
        shape.addChildShape(at, &scene.shape<btBoxShape>(half));
    };
    wall({0.35f, 0.05f, 0.35f}, {0, 0, 0});
    for (const float side : {-1.0f, 1.0f}) {
        wall({0.05f, 0.15f, 0.35f}, {0.3f * side, 0.2f, 0});
        wall({0.25f, 0.15f, 0.05f}, {0, 0.2f, 0.3f * side});
    }
    btRigidBody& tub = scene.add(20, shape, btVector3(0, btScalar(kBedTopM) + 0.05f, 0));
    tub.setActivationState(DISABLE_DEACTIVATION);
    const double floor_m = kBedTopM + 0.1;
    EXPECT_TRUE(
        soil->fill(BoxFill{{{-0.25, floor_m, -0.25}, {0.25, floor_m + 0.2, 0.25}}, "dry_sand"}));
    body = &tub;
    scene.run(2, 4);
    EXPECT_GT(soil->body_report(tub).load_kg, 30);
    const BodyReport report = soil->body_report(tub);
    EXPECT_NEAR(report.force_n.y + report.load_n.y, 20 * kGravity_m_s2, 60);
    scene.world->removeAction(&action);
    return height_of(tub);
}

TEST(ClearedForces, a_load_weighs_what_it_weighs) {
    EXPECT_NEAR(tub_height_m(clear), tub_height_m(nullptr), 0.003);
}

}  // namespace
}  // namespace bsoil::bullet::cleared_forces_test
