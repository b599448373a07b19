/// RigidPatchConstraint: a contact patch of a btRigidBody as rows of Bullet's solver.
#pragma once

#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>

#include "patch_row.h"

namespace bsoil::bullet {

/// A rigid-plastic contact against the fixed body, or against the body that carries the soil: three
/// rows that aim at rest, with limited
/// impulses. They take out the motion as far as the limits allow, so they stop a body of any mass
/// and make none rebound by more than its drift.
class RigidPatchConstraint final : public btTypedConstraint {
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();
    /// carrier: null for the fixed body.
    RigidPatchConstraint(btRigidBody& body, btRigidBody* carrier);
    bool acts_on(const btRigidBody* carrier) const { return carrier_ == carrier; }
    /// What the body, or the carrier, has been given before the solve [N].
    btVector3 preload_n(const btRigidBody& of) const {
        return &of == carrier_ ? -row_.preload_n : row_.preload_n;
    }

    /// Force on the body by the last solve [N]. Bullet tells what has moved a body: nothing along
    /// an axis that its host has locked (setLinearFactor). There the force is the other body's,
    /// turned round; unknown where both are locked.
    btVector3 applied_force_n() const;
    /// For the next solve.
    void set(const PatchRow& row);
    /// Whether the solver has asked for the row since it was set, of a body that does not sleep.
    bool is_solved() const { return solved_; }

    void getInfo1(btConstraintInfo1* info) override;
    void getInfo2(btConstraintInfo2* info) override;
    /// It has no parameters of Bullet's.
    void setParam(int, btScalar, int) override {}
    btScalar getParam(int, int) const override { return 0; }

  private:
    const btRigidBody* carrier_;
    PatchRow row_;
    btJointFeedback feedback_{};
    bool solved_ = false;
};

}  // namespace bsoil::bullet
