/// How far down a collision shape reaches.
#pragma once

#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <optional>

#include "bsoil/geometry.h"

namespace bsoil::bullet {

/// Height, along `up` (unit), of the lowest point of a convex shape or a compound of such; empty
/// where it has another part: those are found by their contacts only.
std::optional<double> lowest_height_m(const btCollisionShape& shape, const btTransform& pose,
                                      Vec3 up);

}  // namespace bsoil::bullet
