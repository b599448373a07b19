#include "rigid_patch_constraint.h"

#include <algorithm>

namespace bsoil::bullet {
namespace {

void copy(const btVector3& v, btScalar* out) {
    std::copy_n(static_cast<const btScalar*>(v), 3, out);
}

}  // namespace

// Any value serves as a type; the largest of Bullet's own names none of its constraints.
RigidPatchConstraint::RigidPatchConstraint(btRigidBody& body, btRigidBody* carrier)
    : btTypedConstraint(MAX_CONSTRAINT_TYPE, body, carrier ? *carrier : getFixedBody()),
      carrier_(carrier) {
    feedback_.m_appliedForceBodyA.setZero();
    feedback_.m_appliedTorqueBodyA.setZero();
    feedback_.m_appliedForceBodyB.setZero();
    feedback_.m_appliedTorqueBodyB.setZero();
    setJointFeedback(&feedback_);
}

btVector3 RigidPatchConstraint::applied_force_n() const {
    const btVector3 &on_body = feedback_.m_appliedForceBodyA,
                    &on_other = feedback_.m_appliedForceBodyB;
    const btVector3 &body = m_rbA.getLinearFactor(), &other = m_rbB.getLinearFactor();
    btVector3 out(0, 0, 0);
    for (int i = 0; i < 3; ++i) {
        if (body[i] != 0) {
            out[i] = on_body[i] / body[i];
        } else if (other[i] != 0) {
            out[i] = -on_other[i] / other[i];
        }
    }
    return out;
}

void RigidPatchConstraint::set(const PatchRow& row) {
    row_ = row;
    solved_ = false;
}

void RigidPatchConstraint::getInfo1(btConstraintInfo1* info) {
    info->m_numConstraintRows = PatchRow::kCount;
    info->nub = 0;
}

void RigidPatchConstraint::getInfo2(btConstraintInfo2* info) {
    // A world that does not split its islands solves for bodies that sleep, too: without gravity.
    solved_ = m_rbA.isActive();
    const btScalar substep_s = 1 / info->fps;
    for (int i = 0; i < PatchRow::kCount; ++i) {
        const int at = i * info->rowskip;
        copy(row_.direction[i], info->m_J1linearAxis + at);
        copy(row_.offset_m[i].cross(row_.direction[i]), info->m_J1angularAxis + at);
        copy(-row_.direction[i], info->m_J2linearAxis + at);
        if (carrier_) {
            copy(row_.direction[i].cross(row_.carrier_offset_m[i]), info->m_J2angularAxis + at);
        }
        info->m_constraintError[at] = row_.target_velocity(i, substep_s);
        info->m_lowerLimit[at] = row_.lower_n[i] * substep_s;
        info->m_upperLimit[at] = row_.upper_n[i] * substep_s;
    }
}

}  // namespace bsoil::bullet
