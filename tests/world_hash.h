/// A number that tells worlds of Bullet apart: FNV-1a over what moves in them.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstddef>
#include <cstdint>

namespace bsoil {

inline uint64_t add(uint64_t hash, const void* data, size_t size) {
    for (size_t i = 0; i < size; ++i) {
        hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 0x100000001b3ull;
    }
    return hash;
}
inline uint64_t add(uint64_t hash, const btVector3& v) {
    return add(hash, &v[0], 3 * sizeof(btScalar));
}

/// Poses, activation and velocities of a world's objects, in its order.
inline uint64_t add_objects(uint64_t hash, const btCollisionWorld& world) {
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        const btTransform& pose = objects[i]->getWorldTransform();
        hash = add(hash, pose.getOrigin());
        for (int row = 0; row < 3; ++row) hash = add(hash, pose.getBasis()[row]);
        const int state = objects[i]->getActivationState();
        hash = add(hash, &state, sizeof(state));
        if (const btRigidBody* body = btRigidBody::upcast(objects[i])) {
            hash = add(add(hash, body->getLinearVelocity()), body->getAngularVelocity());
        }
    }
    return hash;
}

}  // namespace bsoil
