/// Conversions between Bullet's vectors and the library's own.
#pragma once

#include <LinearMath/btTransform.h>

#include "bsoil/geometry.h"

namespace bsoil::bullet {

inline Vec3 from_bullet(const btVector3& v) {
    return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}
inline Pose from_bullet(const btTransform& t) {
    const btQuaternion q = t.getRotation();
    return {from_bullet(t.getOrigin()), {q.x(), q.y(), q.z(), q.w()}};
}
inline btVector3 to_bullet(Vec3 v) {
    return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}
inline btTransform transform_to_bullet(const Pose& p) {
    const Quat& q = p.rotation;
    return btTransform(btQuaternion(static_cast<btScalar>(q.x), static_cast<btScalar>(q.y),
                                    static_cast<btScalar>(q.z), static_cast<btScalar>(q.w)),
                       to_bullet(p.position));
}

}  // namespace bsoil::bullet
