#include "link_patch_constraint.h"

#include <utility>

#include "contact_patches.h"

namespace bsoil::bullet {
namespace {

constexpr int kRowsPerPatch = PatchRow::kCount;

}  // namespace

LinkPatchConstraint::LinkPatchConstraint(btMultiBodyLinkCollider& collider)
    : btMultiBodyConstraint(collider.m_multiBody, nullptr, collider.m_link, -1,
                            kRowsPerPatch * kPatchCapacity, false, MAX_MULTIBODY_CONSTRAINT_TYPE),
      collider_(collider) {
    rows.reserve(kPatchCapacity);
    finalizeMultiDof();
    for (int dof = 0; dof < getNumRows(); ++dof) internalSetAppliedImpulse(dof, 0);
}

btVector3 LinkPatchConstraint::applied_force_n(int i, btScalar substep_s) {
    btVector3 impulse(0, 0, 0);
    for (int k = 0; k < kRowsPerPatch; ++k)
        impulse += getAppliedImpulse(kRowsPerPatch * i + k) * rows[i].direction[k];
    return impulse / substep_s;
}

bool LinkPatchConstraint::take_solved() { return std::exchange(solved_, false); }

void LinkPatchConstraint::finalizeMultiDof() {
    allocateJacobiansMultiDof();
    m_numDofsFinalized = m_jacSizeBoth;
}

void LinkPatchConstraint::createConstraintRows(btMultiBodyConstraintArray& constraint_rows,
                                               btMultiBodyJacobianData& data,
                                               const btContactSolverInfo& info) {
    if (m_numDofsFinalized != m_jacSizeBoth) finalizeMultiDof();
    solved_ = true;
    const btVector3 none(0, 0, 0);
    const btVector3 center = collider_.getWorldTransform().getOrigin();
    for (int i = 0; i < static_cast<int>(rows.size()); ++i) {
        const PatchRow& row = rows[i];
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
            out.m_solverBodyIdB = data.m_fixedBodyId;
            const btVector3 point = center + row.offset_m[k];
            const btScalar substep_s = info.m_timeStep;
            fillMultiBodyConstraint(out, data, nullptr, nullptr, none, row.direction[k], point,
                                    point, 0, info, row.lower_n[k] * substep_s,
                                    row.upper_n[k] * substep_s, false, 1, false,
                                    row.target_velocity(k, substep_s));
        }
    }
}

}  // namespace bsoil::bullet
