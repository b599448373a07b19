// Soil's rows in each of Bullet's solvers.
#include <BulletCollision/CollisionDispatch/btSimulationIslandManager.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <BulletDynamics/MLCPSolvers/btSolveProjectedGaussSeidel.h>

#include "sand_bed.h"

namespace bsoil::bullet::solvers_test {
namespace {

constexpr double kBoxKg = 20;

/// How a box comes to rest on sand.
struct Rest {
    double height_m = 0;
    double force_n = 0;
    bool is_asleep = false;
};

Rest rest_of_a_box(btConstraintSolver& solver, bool splits_islands = true) {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity(btVector3(0, btScalar(-kGravity_m_s2), 0));
    world.getSimulationIslandManager()->setSplitIslands(splits_islands);
    const auto soil = sand_bed(world);
    btBoxShape shape(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)));
    btVector3 inertia;
    shape.calculateLocalInertia(btScalar(kBoxKg), inertia);
    btRigidBody box(btScalar(kBoxKg), nullptr, &shape, inertia);
    place(box, btVector3(0, btScalar(kBedTopM + 0.25), 0));
    world.addRigidBody(&box);
    for (int i = 0; i < 240; ++i) world.stepSimulation(btScalar(1) / 60, 0);
    const Rest rest{height_of(box), soil->body_report(box).force_n.y, !box.isActive()};
    world.removeRigidBody(&box);
    return rest;
}

TEST(Solvers, let_a_box_rest_at_one_height) {
    btSequentialImpulseConstraintSolver sequential;
    const Rest expected = rest_of_a_box(sequential);
    EXPECT_TRUE(expected.is_asleep);
    btDantzigSolver dantzig;
    btMLCPSolver direct(&dantzig);
    btSolveProjectedGaussSeidel gauss_seidel;
    btMLCPSolver iterative(&gauss_seidel);
    for (btMLCPSolver* solver : {&direct, &iterative}) {
        const Rest rest = rest_of_a_box(*solver);
        EXPECT_TRUE(rest.is_asleep);
        // The solvers differ in how far they get in the first touch.
        EXPECT_NEAR(rest.height_m, expected.height_m, 1e-3);
    }
    EXPECT_EQ(iterative.getNumFallbacks(), 0);
}

// Bullet then solves for the box that sleeps, but without its weight.
TEST(Solvers, tell_the_weight_of_what_sleeps_where_islands_are_not_split) {
    btSequentialImpulseConstraintSolver solver;
    const Rest rest = rest_of_a_box(solver, false);
    EXPECT_TRUE(rest.is_asleep);
    EXPECT_NEAR(rest.force_n, kBoxKg * kGravity_m_s2, 0.02 * kBoxKg * kGravity_m_s2);
}

}  // namespace
}  // namespace bsoil::bullet::solvers_test
