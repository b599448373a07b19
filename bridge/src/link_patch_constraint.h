/// LinkPatchConstraint: contact patches with a multibody link as rows of Bullet's multibody solver.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <vector>

#include "patch_row.h"

namespace bsoil::bullet {

/// As RigidPatchConstraint, for up to kPatchCapacity patches of a body with the soil that one
/// carrier carries, where the body, the carrier or both are a link (or a multibody's base).
class LinkPatchConstraint final : public btMultiBodyConstraint {
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();
    /// carrier: null for the fixed body, else a rigid body or a link.
    LinkPatchConstraint(btCollisionObject& body, btCollisionObject* carrier);
    bool acts_on(const btCollisionObject* carrier) const { return carrier_ == carrier; }

    /// Force on the body by the last solve of row i [N]; substep_s is that solve's.
    btVector3 applied_force_n(int i, btScalar substep_s);
    /// For the next solve.
    void clear();
    void add(const PatchRow& row);  ///< at most kPatchCapacity
    /// Whether the solver has asked for the rows since they were cleared, of a body that does not
    /// sleep.
    bool is_solved() const { return solved_; }

    void finalizeMultiDof() override;
    int getIslandIdA() const override { return body_.getIslandTag(); }
    int getIslandIdB() const override { return carrier_ ? carrier_->getIslandTag() : -1; }
    void createConstraintRows(btMultiBodyConstraintArray& constraint_rows,
                              btMultiBodyJacobianData& data,
                              const btContactSolverInfo& info) override;
    void debugDraw(btIDebugDraw*) override {}

  private:
    LinkPatchConstraint(btCollisionObject& body, btCollisionObject* carrier,
                        btMultiBodyLinkCollider& first, btCollisionObject* second);

    btCollisionObject& body_;
    btCollisionObject* carrier_;
    /// Bullet's first body is a link: the body, or the carrier of a rigid body. Null, a rigid body
    /// or a link.
    btCollisionObject* second_;
    btScalar sign_;  ///< -1 where the first one is the carrier
    std::vector<PatchRow> rows_;
    bool solved_ = false;
};

}  // namespace bsoil::bullet
