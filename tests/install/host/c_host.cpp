// The C++ side of a host that puts its soil in from C: makes a world, drops a ball, says where it
// ends.
#include <bsoil/c/bulletsoil.h>
#include <bsoil/version.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <cstring>

extern "C" bulletsoil_soil* put_sand_under(void* world, size_t scalar_bytes);

int main() {
    if (std::strcmp(bulletsoil_version(), BSOIL_VERSION) != 0) return 3;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, btScalar(-9.81), 0});
    bulletsoil_soil* soil = put_sand_under(&world, sizeof(btScalar));
    if (soil == nullptr) return 2;

    btSphereShape shape(btScalar(0.3));
    btRigidBody ball(btRigidBody::btRigidBodyConstructionInfo(10, nullptr, &shape, {1, 1, 1}));
    ball.getWorldTransform().setOrigin({0, 1, 0});
    world.addRigidBody(&ball);
    for (int i = 0; i < 60; ++i) world.stepSimulation(btScalar(1.0 / 60));
    const double height_m = double(ball.getWorldTransform().getOrigin().y());
    std::printf("the ball lies at %.3f m\n", height_m);
    bulletsoil_destroy(soil);
    world.removeRigidBody(&ball);
    return height_m > 0.6 && height_m < 0.85 ? 0 : 1;  // on 0.5 m of sand with its radius of 0.3 m
}
