// Distances to shapes, by Bullet and by what a shape was converted into.
#pragma once

#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <vector>

#include "bsoil/body.h"

namespace bsoil::bullet {

/// Of a point in the body's frame, negative inside, from formulas of their own. Outside of a hull
/// no more than the distance.
double signed_distance(const std::vector<ConvexShape>& shapes, Vec3 body_point);

/// Bullet's distance of a world point; infinity where its solver gives up. As
/// btGjkEpaSolver2::SignedDistance, but from three starting directions: from a single one the
/// solver stops early, centimetres too far out, at one point in a thousand. What it finds is never
/// too near.
double bullet_distance(const btConvexShape& shape, const btTransform& pose, Vec3 point);

}  // namespace bsoil::bullet
