#include "bullet_vectors.h"

namespace bsoil::scene {
btVector3 to_bullet(Vec3 v) { return {scalar(v.x), scalar(v.y), scalar(v.z)}; }
btTransform to_bullet(const Pose& p) {
    const Quat q = p.rotation;
    return btTransform(btQuaternion(scalar(q.x), scalar(q.y), scalar(q.z), scalar(q.w)),
                       to_bullet(p.position));
}
Vec3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
Pose from_bullet(const btTransform& t) {
    const btQuaternion q = t.getRotation();
    return {from_bullet(t.getOrigin()), {q.x(), q.y(), q.z(), q.w()}};
}

}  // namespace bsoil::scene
