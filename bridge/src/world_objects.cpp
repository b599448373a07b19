#include "world_objects.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <cmath>

#include "shape_conversion.h"

namespace bsoil::bullet {
namespace {

constexpr int kFlags = btCollisionObject::CF_STATIC_OBJECT |
                       btCollisionObject::CF_KINEMATIC_OBJECT |
                       btCollisionObject::CF_NO_CONTACT_RESPONSE;

ObjectKind kind_of(const btCollisionObject& object) {
    ObjectKind kind;
    kind.internal_type = object.getInternalType();
    kind.flags = object.getCollisionFlags() & kFlags;
    kind.user_index = object.getUserIndex();
    const btCollisionShape* shape = object.getCollisionShape();
    kind.shape_type = shape ? shape->getShapeType() : -1;
    if (shape) kind.shape = shape_fingerprint(*shape, {});
    const btRigidBody* body = btRigidBody::upcast(&object);
    if (body && body->getInvMass() > 0) kind.mass_kg = 1 / static_cast<double>(body->getInvMass());
    return kind;
}

/// How two kinds differ; empty: not at all.
std::string difference(const ObjectKind& saved, const ObjectKind& here) {
    const auto differ = [](const char* what, auto a, auto b) {
        return std::string(what) + " " + std::to_string(b) + ", in the snapshot " +
               std::to_string(a);
    };
    if (saved.internal_type != here.internal_type) {
        return differ("internal type", saved.internal_type, here.internal_type);
    }
    if (saved.shape_type != here.shape_type) {
        return differ("shape type", saved.shape_type, here.shape_type);
    }
    if (saved.shape != here.shape) return "a shape of other dimensions than in the snapshot";
    if (std::abs(saved.mass_kg - here.mass_kg) > kSameMass * here.mass_kg) {
        return differ("mass_kg", saved.mass_kg, here.mass_kg);
    }
    if (saved.user_index != here.user_index) {
        return differ("user index", saved.user_index, here.user_index);
    }
    if (saved.flags != here.flags) return differ("collision flags", saved.flags, here.flags);
    return {};
}

}  // namespace

void ObjectKind::list(StateStream& stream) {
    stream(internal_type, shape_type, shape, flags, user_index, mass_kg);
}

std::vector<ObjectKind> object_kinds(const btCollisionWorld& world) {
    std::vector<ObjectKind> kinds;
    for (int i = 0; i < world.getNumCollisionObjects(); ++i) {
        kinds.push_back(kind_of(*world.getCollisionObjectArray()[i]));
    }
    return kinds;
}

Status check_same_objects(const std::vector<ObjectKind>& saved, const btCollisionWorld& world) {
    const std::vector<ObjectKind> here = object_kinds(world);
    for (size_t i = 0; i < std::min(saved.size(), here.size()); ++i) {
        const std::string differs = difference(saved[i], here[i]);
        if (!differs.empty()) {
            return Error{"is of another world: object " + std::to_string(i) + " has here " +
                         differs + "; build the world as it was"};
        }
    }
    if (saved.size() != here.size()) {
        return Error{"is of another world: " + std::to_string(saved.size()) +
                     " collision objects in the snapshot, " + std::to_string(here.size()) +
                     " here; build the world as it was"};
    }
    return Done{};
}

}  // namespace bsoil::bullet
