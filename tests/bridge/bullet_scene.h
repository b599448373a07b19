// A small Bullet world for tests.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

namespace bsoil::bullet {

/// Owns a world and the bodies put into it; y is up.
struct BulletScene {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btMultiBodyConstraintSolver solver;
    std::unique_ptr<btMultiBodyDynamicsWorld> world = std::make_unique<btMultiBodyDynamicsWorld>(
        &dispatcher, &broadphase, &solver, &configuration);
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;

    BulletScene() { world->setGravity(btVector3(0, btScalar(-9.81), 0)); }
    ~BulletScene() {
        if (!world) return;
        for (const auto& body : bodies) world->removeRigidBody(body.get());
    }

    template <typename Shape, typename... Arguments>
    btCollisionShape& shape(Arguments&&... arguments) {
        shapes.push_back(std::make_unique<Shape>(std::forward<Arguments>(arguments)...));
        return *shapes.back();
    }
    /// Mass 0: static.
    btRigidBody& add(btScalar mass_kg, btCollisionShape& body_shape, const btVector3& position) {
        btVector3 inertia(0, 0, 0);
        if (mass_kg > 0) body_shape.calculateLocalInertia(mass_kg, inertia);
        bodies.push_back(std::make_unique<btRigidBody>(mass_kg, nullptr, &body_shape, inertia));
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(position);
        bodies.back()->setWorldTransform(pose);
        bodies.back()->setInterpolationWorldTransform(pose);
        world->addRigidBody(bodies.back().get());
        return *bodies.back();
    }
    btRigidBody& add_box(btScalar mass_kg, const btVector3& half_extents,
                         const btVector3& position) {
        return add(mass_kg, shape<btBoxShape>(half_extents), position);
    }
    /// A hull without volume: nothing for the soil to give way to, so that it is refused.
    btRigidBody& add_flat_hull(const btVector3& position) {
        auto& flat = static_cast<btConvexHullShape&>(shape<btConvexHullShape>());
        for (const btScalar x : {-0.2f, 0.2f}) {
            for (const btScalar z : {-0.2f, 0.2f}) flat.addPoint({x, 0, z});
        }
        return add(2, flat, position);
    }
    void remove(btRigidBody& body) {
        world->removeRigidBody(&body);
        std::erase_if(bodies, [&body](const auto& owned) { return owned.get() == &body; });
    }
    /// Frames of 1/60 s, each in equal substeps.
    void run(double seconds, int substeps = 1) {
        const int frames = static_cast<int>(seconds * 60 + 0.5);
        for (int i = 0; i < frames; ++i) {
            world->stepSimulation(btScalar(1) / 60, substeps,
                                  btScalar(1) / btScalar(60 * substeps));
        }
    }
};

}  // namespace bsoil::bullet
