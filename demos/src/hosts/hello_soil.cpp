/// The smallest host: Bullet's hello world with soil under it. The soil takes the five statements
/// marked below. A ball falls into dry sand and comes to rest in the hollow it has made.
#include <bsoil/bullet/soil_action.h>  // 1
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, btScalar(-9.81), 0});

    const bsoil::SoilDef def;  // 2: 12 x 2 x 12 m of dry sand at most, in voxels of 5 cm
    auto soil = bsoil::bullet::SoilAction::create(world, def);  // 3
    if (!soil) {                                                // 4
        std::printf("%s\n", soil.error().c_str());
        return 2;
    }
    if (!(*soil)->fill(bsoil::BoxFill{{{-2, 0, -2}, {2, 0.5, 2}}, "dry_sand"})) return 2;  // 5

    const double radius_m = 0.3, mass_kg = 200, sand_m = 0.5;
    btSphereShape shape{btScalar(radius_m)};
    btVector3 inertia;
    shape.calculateLocalInertia(btScalar(mass_kg), inertia);
    btDefaultMotionState start(
        btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(1.5), 0)));
    btRigidBody ball(
        btRigidBody::btRigidBodyConstructionInfo(btScalar(mass_kg), &start, &shape, inertia));
    world.addRigidBody(&ball);

    const auto units_before = (*soil)->soil().totals().units;
    std::printf("a ball of %g kg and %g m radius above %g m of sand\n", mass_kg, radius_m, sand_m);
    std::printf("  time  height  soil pushes  sinkage\n");
    for (int frame = 1; frame <= 180; ++frame) {
        world.stepSimulation(btScalar(1.0 / 60));
        if (frame % 20 != 0) continue;
        const auto report = (*soil)->body_report(ball);
        std::printf("%5.2f s %5.3f m %9.0f N %6.3f m\n", frame / 60.0,
                    double(ball.getWorldTransform().getOrigin().y()), report.force_n.y,
                    report.sinkage_m);
    }

    const auto report = (*soil)->body_report(ball);
    const double lowest_m = double(ball.getWorldTransform().getOrigin().y()) - radius_m;
    const double speed_m_s = double(ball.getLinearVelocity().length());
    const double weight_n = mass_kg * 9.81;
    const bool conserved = units_before == (*soil)->soil().totals().units;
    std::printf("it rests %.3f m deep: the sand pushes with %.0f N, it weighs %.0f N, and %s\n",
                sand_m - lowest_m, report.force_n.y, weight_n,
                conserved ? "not a grain is lost" : "SOIL IS LOST");
    world.removeRigidBody(&ball);

    // It has sunk in, not to the floor, stands still, and the sand bears its weight.
    const bool right = conserved && lowest_m > 0.05 && lowest_m < sand_m && speed_m_s < 0.05 &&
                       std::abs(report.force_n.y - weight_n) < 0.02 * weight_n;
    std::printf("%s\n", right ? "as it should be" : "WRONG");
    return right ? 0 : 1;
}
