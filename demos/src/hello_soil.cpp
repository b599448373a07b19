/// The smallest host: Bullet's hello world with soil under it. The soil takes the five lines marked
/// below.
#include <bsoil/bullet/soil_action.h>  // 1
#include <btBulletDynamicsCommon.h>

#include <cstdio>

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, btScalar(-9.81), 0});

    const bsoil::SoilDef def;  // 2: 12 x 2 x 12 m of dry sand at most, in voxels of 5 cm
    auto soil = bsoil::bullet::SoilAction::create(world, def);                             // 3
    if (!soil) return std::printf("%s\n", soil.error().c_str()), 2;                        // 4
    if (!(*soil)->fill(bsoil::BoxFill{{{-2, 0, -2}, {2, 0.5, 2}}, "dry_sand"})) return 2;  // 5

    btSphereShape shape(btScalar(0.3));
    const btScalar mass_kg = 200;
    btVector3 inertia;
    shape.calculateLocalInertia(mass_kg, inertia);
    btDefaultMotionState start(
        btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(1.5), 0)));
    btRigidBody ball(btRigidBody::btRigidBodyConstructionInfo(mass_kg, &start, &shape, inertia));
    world.addRigidBody(&ball);

    for (int frame = 0; frame < 180; ++frame) world.stepSimulation(btScalar(1.0 / 60));
    const double sinkage_m = (*soil)->body_report(ball).sinkage_m;
    const double height_m = ball.getWorldTransform().getOrigin().y();
    std::printf("the ball rests at %.3f m, %.3f m deep in the sand\n", height_m, sinkage_m);
    world.removeRigidBody(&ball);
    return height_m > 0.3 && height_m < 0.8 ? 0
                                            : 1;  // on the sand, neither through it nor above it
}
