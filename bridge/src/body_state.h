/// BodyState: a collision object of the world that takes part in a soil step.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include "bsoil/contact/contact_patches.h"

namespace bsoil::bullet {

/// What carries a body's reaction.
enum class BodyRole {
    rigid,   ///< dynamic btRigidBody: RigidPatchConstraint
    link,    ///< link or free base of a btMultiBody: LinkPatchConstraint
    driven,  ///< kinematic, or a link with only such above it: its motion is what it is
    fixed,   ///< static: does not move
    wheel,   ///< of a btRaycastVehicle, no object of the world: VehicleWheels
};

struct BodyState {
    btCollisionObject* object = nullptr;  ///< null for a wheel
    int proxy_id = 0;  ///< of the broadphase: tells a new object at an old one's address
    int internal_type =
        0;  ///< Bullet's: a broadphase that recycles its ids must not pass off another
    int world_index = 0;  ///< in the world's list, where it was last seen
    int id = 0;           ///< SoilBody::id
    BodyRole role = BodyRole::fixed;
    BodyMotion motion;
    bool is_asleep = false;
    double weight_n = 0;  ///< of a rigid body or a link
    SurfaceFriction surface;
};

/// Whether its motion is not solved for.
inline bool is_given(const BodyState& body) {
    return body.role == BodyRole::driven || body.role == BodyRole::fixed;
}

/// Of its object now, which is in the world: what is_in_world compares.
inline void remember_identity(BodyState& body) {
    body.proxy_id = body.object->getBroadphaseHandle()->getUid();
    body.internal_type = body.object->getInternalType();
    body.world_index = body.object->getWorldArrayIndex();
}

/// Whether both are of the same object, or of none.
inline bool is_same_object(const BodyState& a, const BodyState& b) {
    return a.object == b.object && a.proxy_id == b.proxy_id && a.internal_type == b.internal_type;
}

/// Whether the world still holds that very object: no pointer to a body is followed before.
inline bool is_in_world(const btCollisionWorld& world, const BodyState& body) {
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    int index = body.world_index;
    if (index >= objects.size() || objects[index] != body.object) {
        index = objects.findLinearSearch(body.object);
    }
    if (index == objects.size()) return false;
    const btBroadphaseProxy* proxy = body.object->getBroadphaseHandle();
    return proxy && proxy->getUid() == body.proxy_id &&
           body.object->getInternalType() == body.internal_type;
}

/// Nothing where it has left the world.
void wake_object(const btCollisionWorld& world, const BodyState& body);

}  // namespace bsoil::bullet
