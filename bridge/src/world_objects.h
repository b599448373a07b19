/// The objects of a world as a snapshot names them: by their place in the world's list, each with
/// enough of its kind to tell another world.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include <string>
#include <vector>

#include "bsoil/snapshot_file.h"

namespace bsoil::bullet {

/// A body's mass is part of how the world was built, but for roundings of this share: it passes
/// through a reciprocal whenever the body carries soil, in single precision.
inline constexpr double kSameMass = 1e-5;

/// What an object is, whatever it does.
struct ObjectKind {
    int32_t internal_type = 0;  ///< Bullet's
    int32_t shape_type = 0;     ///< Bullet's; -1: no shape
    uint64_t shape = 0;         ///< shape_fingerprint
    int32_t flags = 0;          ///< static, kinematic, no contact response
    int32_t user_index = 0;
    double mass_kg = 0;  ///< of a rigid body; 0: static or none

    void list(StateStream& stream);
};

std::vector<ObjectKind> object_kinds(const btCollisionWorld& world);

/// Error: the first object that is not what it was, or that there are more or fewer.
Status check_same_objects(const std::vector<ObjectKind>& saved, const btCollisionWorld& world);

}  // namespace bsoil::bullet
