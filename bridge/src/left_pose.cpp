#include "left_pose.h"

#include "bullet_stream.h"
#include "bullet_types.h"

namespace bsoil::bullet {

void LeftPose::close(const btCollisionObject& object, const btTransform& opened, btScalar substep_s,
                     double slack_m) {
    const btTransform& now = object.getWorldTransform();
    // The speed that Bullet has moved it with, where an action has set another since.
    const btScalar speed_m_s = object.getInterpolationLinearVelocity().length();
    const btScalar moved_m = (now.getOrigin() - opened.getOrigin()).length();
    const bool is_put = moved_m > speed_m_s * substep_s + static_cast<btScalar>(slack_m);
    pose_ = is_put ? opened : now;
}

bool LeftPose::is_at(const btCollisionObject& object) const {
    return !pose_ || *pose_ == object.getWorldTransform();
}

double LeftPose::moved_m(const btCollisionObject& object, Vec3 offset_m) const {
    const btTransform& now = object.getWorldTransform();
    if (!pose_) return 0;
    const btVector3 arm = to_bullet(offset_m);
    const btVector3 own_arm = pose_->getBasis().transpose() * arm;
    const btVector3 shift = now.getOrigin() - pose_->getOrigin();
    return static_cast<double>((shift + now.getBasis() * own_arm - arm).length());
}

void LeftPose::list(StateStream& stream) {
    bool is_known = pose_.has_value();
    stream(is_known);
    if (!is_known) return;
    if (stream.reads()) pose_ = btTransform::getIdentity();
    bullet::list(stream, *pose_);
}

}  // namespace bsoil::bullet
