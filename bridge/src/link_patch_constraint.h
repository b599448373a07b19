/// LinkPatchConstraint: all contact patches of one multibody link as rows of Bullet's multibody
/// solver.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <vector>

#include "patch_row.h"

namespace bsoil::bullet {

/// As RigidPatchConstraint, for up to kPatchCapacity patches of a link (or of a multibody's base)
/// against the fixed body.
class LinkPatchConstraint final : public btMultiBodyConstraint {
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();
    explicit LinkPatchConstraint(btMultiBodyLinkCollider& collider);

    std::vector<PatchRow> rows;  ///< at most kPatchCapacity

    /// Force on the link by the last solve of rows[i] [N]; substep_s is that solve's.
    btVector3 applied_force_n(int i, btScalar substep_s);
    /// Whether the solver has asked for the rows since the last call.
    bool take_solved();

    void finalizeMultiDof() override;
    int getIslandIdA() const override { return collider_.getIslandTag(); }
    int getIslandIdB() const override { return -1; }
    void createConstraintRows(btMultiBodyConstraintArray& constraint_rows,
                              btMultiBodyJacobianData& data,
                              const btContactSolverInfo& info) override;
    void debugDraw(btIDebugDraw*) override {}

  private:
    btMultiBodyLinkCollider& collider_;
    bool solved_ = false;
};

}  // namespace bsoil::bullet
