/// How far down a collision shape reaches.
#pragma once

#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <optional>

#include "bsoil/geometry.h"

namespace bsoil::bullet {

/// The point farthest along a unit vector of the solid that convert_shape() makes, in the shape's
/// own axes. Bullet rounds the rims of a cylinder by its margin; that solid has them sharp.
btVector3 farthest_point(const btConvexShape& shape, const btVector3& direction);

/// Height, along `up` (unit), of the lowest point of a convex shape or a compound of such, as the
/// soil meets it (convert_shape); empty where it has another part: those are found by their
/// contacts only.
std::optional<double> lowest_height_m(const btCollisionShape& shape, const btTransform& pose,
                                      Vec3 up);

}  // namespace bsoil::bullet
