#include "rigid_patch_constraint.h"

#include <algorithm>
#include <utility>

namespace bsoil::bullet {
namespace {

void copy(const btVector3& v, btScalar* out) {
    std::copy_n(static_cast<const btScalar*>(v), 3, out);
}

}  // namespace

// Any value serves as a type; the largest of Bullet's own names none of its constraints.
RigidPatchConstraint::RigidPatchConstraint(btRigidBody& body)
    : btTypedConstraint(MAX_CONSTRAINT_TYPE, body) {
    feedback_.m_appliedForceBodyA.setZero();
    feedback_.m_appliedTorqueBodyA.setZero();
    feedback_.m_appliedForceBodyB.setZero();
    feedback_.m_appliedTorqueBodyB.setZero();
    setJointFeedback(&feedback_);
}

bool RigidPatchConstraint::take_solved() { return std::exchange(solved_, false); }

void RigidPatchConstraint::getInfo1(btConstraintInfo1* info) {
    info->m_numConstraintRows = PatchRow::kCount;
    info->nub = 0;
}

void RigidPatchConstraint::getInfo2(btConstraintInfo2* info) {
    solved_ = true;
    const btScalar substep_s = 1 / info->fps;
    for (int i = 0; i < PatchRow::kCount; ++i) {
        const int at = i * info->rowskip;
        copy(row.direction[i], info->m_J1linearAxis + at);
        copy(row.offset_m[i].cross(row.direction[i]), info->m_J1angularAxis + at);
        info->m_constraintError[at] = row.target_velocity(i, substep_s);
        info->m_lowerLimit[at] = row.lower_n[i] * substep_s;
        info->m_upperLimit[at] = row.upper_n[i] * substep_s;
    }
}

}  // namespace bsoil::bullet
