/// JointResistance: dry friction and damping of a hinge or slider between rigid bodies.
#pragma once

#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>

namespace bsoil::scene {

/// One row that works against the joint's velocity with at most friction + damping * speed. It can
/// stop the joint and not turn it round, however stiff the damping is for the time step.
class JointResistance final : public btTypedConstraint {
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();
    /// Frames in the bodies: the joint's axis is column `axis` of the parent's, its place the
    /// child's origin.
    JointResistance(btRigidBody& parent, btRigidBody& child, const btTransform& parent_frame,
                    const btTransform& child_frame, int axis, bool slides);

    btScalar friction = 0;  ///< [N m], of a slider [N]
    btScalar damping = 0;   ///< [N m s/rad], of a slider [N s/m]

    void getInfo1(btConstraintInfo1* info) override;
    void getInfo2(btConstraintInfo2* info) override;
    /// It has no parameters of Bullet's.
    void setParam(int, btScalar, int) override {}
    btScalar getParam(int, int) const override { return 0; }

  private:
    btTransform parent_frame_, child_frame_;
    int axis_;
    bool slides_;
};

}  // namespace bsoil::scene
