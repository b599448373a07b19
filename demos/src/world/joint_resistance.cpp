#include "joint_resistance.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <cmath>

namespace bsoil::scene {

JointResistance::JointResistance(btRigidBody& parent, btRigidBody& child,
                                 const btTransform& parent_frame, const btTransform& child_frame,
                                 int axis, bool slides)
    : btTypedConstraint(MAX_CONSTRAINT_TYPE, parent, child),
      parent_frame_(parent_frame),
      child_frame_(child_frame),
      axis_(axis),
      slides_(slides) {}

void JointResistance::getInfo1(btConstraintInfo1* info) {
    info->m_numConstraintRows = 1;
    info->nub = 0;
}

void JointResistance::getInfo2(btConstraintInfo2* info) {
    const btTransform parent = m_rbA.getCenterOfMassTransform() * parent_frame_;
    const btVector3 axis = parent.getBasis().getColumn(axis_);
    btVector3 about_parent = axis, about_child = axis;
    btScalar speed = axis.dot(m_rbA.getAngularVelocity() - m_rbB.getAngularVelocity());
    if (slides_) {
        const btVector3 at = m_rbB.getCenterOfMassTransform() * child_frame_.getOrigin();
        about_parent = (at - m_rbA.getCenterOfMassPosition()).cross(axis);
        about_child = (at - m_rbB.getCenterOfMassPosition()).cross(axis);
        speed = axis.dot(m_rbA.getLinearVelocity() - m_rbB.getLinearVelocity()) +
                about_parent.dot(m_rbA.getAngularVelocity()) -
                about_child.dot(m_rbB.getAngularVelocity());
        std::copy_n(static_cast<const btScalar*>(axis), 3, info->m_J1linearAxis);
        std::copy_n(static_cast<const btScalar*>(-axis), 3, info->m_J2linearAxis);
    }
    std::copy_n(static_cast<const btScalar*>(about_parent), 3, info->m_J1angularAxis);
    std::copy_n(static_cast<const btScalar*>(-about_child), 3, info->m_J2angularAxis);
    info->m_constraintError[0] = 0;
    const btScalar most = (friction + damping * std::abs(speed)) / info->fps;
    info->m_lowerLimit[0] = -most;
    info->m_upperLimit[0] = most;
}

}  // namespace bsoil::scene
