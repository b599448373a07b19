/// RigidPatchConstraint: a contact patch of a btRigidBody as rows of Bullet's solver.
#pragma once

#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>

#include "patch_row.h"

namespace bsoil::bullet {

/// A rigid-plastic contact against the fixed body: three rows that aim at rest, with limited
/// impulses. They take out the motion as far as the limits allow, so they stop a body of any mass
/// and make none rebound by more than its drift.
class RigidPatchConstraint final : public btTypedConstraint {
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();
    explicit RigidPatchConstraint(btRigidBody& body);

    PatchRow row;

    /// Force on the body by the last solve [N].
    btVector3 applied_force_n() const { return feedback_.m_appliedForceBodyA; }
    /// Whether the solver has asked for the rows since the last call.
    bool take_solved();

    void getInfo1(btConstraintInfo1* info) override;
    void getInfo2(btConstraintInfo2* info) override;
    /// It has no parameters of Bullet's.
    void setParam(int, btScalar, int) override {}
    btScalar getParam(int, int) const override { return 0; }

  private:
    btJointFeedback feedback_{};
    bool solved_ = false;
};

}  // namespace bsoil::bullet
