/// Places and poses of a scene as Bullet has them, and back.
#pragma once

#include <LinearMath/btTransform.h>

#include "bsoil/geometry.h"

namespace bsoil::scene {

/// A number in the precision that Bullet was built with.
inline btScalar scalar(double value) { return static_cast<btScalar>(value); }

btVector3 to_bullet(Vec3 v);
btTransform to_bullet(const Pose& p);
Vec3 from_bullet(const btVector3& v);
Pose from_bullet(const btTransform& t);

}  // namespace bsoil::scene
