#include "test_world.h"

#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletDynamics/Dynamics/btSimpleDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <map>
#include <memory>
#include <vector>

#include "../cure.h"

namespace {

/// A world with all it needs. Members are destroyed from the last to the first.
struct TestWorld {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btCollisionObject>> bodies;
    std::unique_ptr<btDynamicsWorld> world;
};

/// By what C holds: the world's address.
std::map<void*, std::unique_ptr<TestWorld>>& worlds() {
    static std::map<void*, std::unique_ptr<TestWorld>> all;
    return all;
}

template <typename World>
void* create() {
    auto made = std::make_unique<TestWorld>();
    auto* world =
        new World(&made->dispatcher, &made->broadphase, &made->solver, &made->configuration);
    made->world.reset(world);
    world->setGravity({0, btScalar(-9.81), 0});
    worlds()[world] = std::move(made);
    return world;
}

}  // namespace

void* test_world_create(void) { return create<btDiscreteDynamicsWorld>(); }
void* test_world_create_simple(void) { return create<btSimpleDynamicsWorld>(); }
void test_world_destroy(void* world) { worlds().erase(world); }

void test_world_step(void* world, int count) {
    for (int i = 0; i < count; ++i) {
        worlds().at(world)->world->stepSimulation(btScalar(1.0 / 60), 1, btScalar(1.0 / 60));
    }
}

void* test_world_add_ball(void* world, double mass_kg, double height_m) {
    TestWorld& test = *worlds().at(world);
    test.shapes.push_back(std::make_unique<btSphereShape>(btScalar(0.3)));
    btVector3 inertia;
    test.shapes.back()->calculateLocalInertia(btScalar(mass_kg), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass_kg), nullptr,
                                                  test.shapes.back().get(), inertia);
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin({0, btScalar(height_m), 0});
    auto body = std::make_unique<btRigidBody>(info);
    test.world->addRigidBody(body.get());
    btCollisionObject* object = body.get();
    test.bodies.push_back(std::move(body));
    return object;
}

double test_world_ball_y(const void* ball) {
    const auto* object = static_cast<const btCollisionObject*>(ball);
    return static_cast<double>(object->getWorldTransform().getOrigin().y());
}

void test_world_move_ball(void* ball, double x, double z) {
    auto* body = static_cast<btRigidBody*>(static_cast<btCollisionObject*>(ball));
    btTransform pose = body->getWorldTransform();
    pose.setOrigin({btScalar(x), pose.getOrigin().y(), btScalar(z)});
    body->setWorldTransform(pose);
    body->setInterpolationWorldTransform(pose);
    body->setLinearVelocity({0, 0, 0});
}

void* test_world_add_empty(void* world) {
    TestWorld& test = *worlds().at(world);
    test.shapes.push_back(std::make_unique<btEmptyShape>());
    auto object = std::make_unique<btCollisionObject>();
    object->setCollisionShape(test.shapes.back().get());
    test.world->addCollisionObject(object.get());
    btCollisionObject* out = object.get();
    test.bodies.push_back(std::move(object));
    return out;
}

size_t test_world_scalar_bytes(void) { return sizeof(btScalar); }

int test_says_what_to_do(const char* text) { return bsoil::says_what_to_do(text); }
