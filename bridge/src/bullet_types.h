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

/// A rotation whose columns are these unit vectors at right angles.
inline Quat rotation_of(Vec3 x, Vec3 y, Vec3 z) {
    const btMatrix3x3 basis(
        static_cast<btScalar>(x.x), static_cast<btScalar>(y.x), static_cast<btScalar>(z.x),
        static_cast<btScalar>(x.y), static_cast<btScalar>(y.y), static_cast<btScalar>(z.y),
        static_cast<btScalar>(x.z), static_cast<btScalar>(y.z), static_cast<btScalar>(z.z));
    btQuaternion q;
    basis.getRotation(q);
    return {q.x(), q.y(), q.z(), q.w()};
}

}  // namespace bsoil::bullet
