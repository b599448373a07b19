#include "link_patch_constraint.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include "bsoil/contact/contact_patches.h"

namespace bsoil::bullet {
namespace {

constexpr int kRowsPerPatch = PatchRow::kCount;

btMultiBody* multibody_of(const btCollisionObject* object) {
    const auto* link = object ? btMultiBodyLinkCollider::upcast(object) : nullptr;
    return link ? link->m_multiBody : nullptr;
}

int link_of(const btCollisionObject* object) {
    const auto* link = object ? btMultiBodyLinkCollider::upcast(object) : nullptr;
    return link ? link->m_link : -1;
}

/// Velocity of a row's rigid body that Bullet's forces of this substep will have made: its
/// multibodies have theirs already, and a row with both does not ask a rigid body for it.
btScalar velocity_to_come(const btSolverBody& body, const btVector3& direction,
                          const btVector3& arm_m) {
    return body.m_externalForceImpulse.dot(direction) +
           body.m_externalTorqueImpulse.dot(arm_m.cross(direction));
}

/// A row along which nothing can move, as across the plane of an arm that is fixed to the ground.
/// Bullet gives it no impulse, but divides by its mass of 0: one such row makes it take what all
/// before it lack for nothing, and stop after its first iteration.
void disable_if_stiff(btMultiBodySolverConstraint& row) {
    if (row.m_jacDiagABInv > 0) return;
    row.m_jacDiagABInv = 1;
    row.m_rhs = row.m_rhsPenetration = 0;
    row.m_lowerLimit = row.m_upperLimit = 0;
}

}  // namespace

LinkPatchConstraint::LinkPatchConstraint(btCollisionObject& body, btCollisionObject* carrier)
    : LinkPatchConstraint(body, carrier,
                          *btMultiBodyLinkCollider::upcast(
                              btMultiBodyLinkCollider::upcast(&body) ? &body : carrier),
                          btMultiBodyLinkCollider::upcast(&body) ? carrier : &body) {}

LinkPatchConstraint::LinkPatchConstraint(btCollisionObject& body, btCollisionObject* carrier,
                                         btMultiBodyLinkCollider& first, btCollisionObject* second)
    : btMultiBodyConstraint(first.m_multiBody, multibody_of(second), first.m_link, link_of(second),
                            kRowsPerPatch * kPatchCapacity, false, MAX_MULTIBODY_CONSTRAINT_TYPE),
      body_(body),
      carrier_(carrier),
      second_(second),
      sign_(second == &body ? btScalar(-1) : btScalar(1)) {
    rows_.reserve(kPatchCapacity);
    finalizeMultiDof();
    for (int dof = 0; dof < getNumRows(); ++dof) internalSetAppliedImpulse(dof, 0);
}

btVector3 LinkPatchConstraint::applied_force_n(int i, btScalar substep_s) {
    btVector3 impulse(0, 0, 0);
    for (int k = 0; k < kRowsPerPatch; ++k) {
        impulse += getAppliedImpulse(kRowsPerPatch * i + k) * rows_[i].direction[k];
    }
    return impulse / substep_s;
}

void LinkPatchConstraint::clear() {
    rows_.clear();
    solved_ = false;
}

void LinkPatchConstraint::add(const PatchRow& row) { rows_.push_back(row); }

void LinkPatchConstraint::finalizeMultiDof() {
    allocateJacobiansMultiDof();
    m_numDofsFinalized = m_jacSizeBoth;
}

void LinkPatchConstraint::createConstraintRows(btMultiBodyConstraintArray& constraint_rows,
                                               btMultiBodyJacobianData& data,
                                               const btContactSolverInfo& info) {
    if (m_numDofsFinalized != m_jacSizeBoth) finalizeMultiDof();
    solved_ = body_.isActive();  // as of RigidPatchConstraint
    const btVector3 none(0, 0, 0);
    const btVector3 center = body_.getWorldTransform().getOrigin();
    const btRigidBody* rigid = second_ ? btRigidBody::upcast(second_) : nullptr;
    // Asleep, and so not among the solver's: it stands.
    const bool is_solved = rigid && rigid->getCompanionId() >= 0 && rigid->isActive();
    const int second_id = is_solved ? rigid->getCompanionId() : data.m_fixedBodyId;
    const btScalar substep_s = info.m_timeStep;
    for (int i = 0; i < static_cast<int>(rows_.size()); ++i) {
        const PatchRow& row = rows_[i];
        for (int k = 0; k < kRowsPerPatch; ++k) {
            btMultiBodySolverConstraint& out = constraint_rows.expandNonInitializing();
            out.m_orgConstraint = this;
            out.m_orgDofIndex = kRowsPerPatch * i + k;
            out.m_relpos1CrossNormal = none;
            out.m_contactNormal1 = none;
            out.m_relpos2CrossNormal = none;
            out.m_contactNormal2 = none;
            out.m_angularComponentA = none;
            out.m_angularComponentB = none;
            out.m_solverBodyIdA = data.m_fixedBodyId;
            out.m_solverBodyIdB = second_id;
            const btVector3 point = center + row.offset_m[k];
            const btVector3 direction = sign_ * row.direction[k];
            btScalar target = row.target_velocity(k, substep_s);
            if (is_solved) {
                const btSolverBody& solved = data.m_solverBodyPool->at(second_id);
                target += velocity_to_come(solved, direction,
                                           point - solved.getWorldTransform().getOrigin());
            }
            fillMultiBodyConstraint(out, data, nullptr, nullptr, none, direction, point, point, 0,
                                    info, row.lower_n[k] * substep_s, row.upper_n[k] * substep_s,
                                    false, 1, false, target);
            disable_if_stiff(out);
        }
    }
}

}  // namespace bsoil::bullet
