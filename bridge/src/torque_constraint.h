/// TorqueConstraint: a torque that a body gets at the start of the solve.
#pragma once

#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>

namespace bsoil::bullet {

/// One row whose impulse is fixed: the solver gives it in its first iteration, and all rows from
/// then on see the turning it makes. Bullet's own applied torque is left out by its friction rows:
/// what rests on a light body would be dragged along by a turning that does not take place.
class TorqueConstraint final : public btTypedConstraint {
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();
    explicit TorqueConstraint(btRigidBody& body);

    btVector3 torque_n_m{0, 0, 0};  ///< world axes

    void getInfo1(btConstraintInfo1* info) override;
    void getInfo2(btConstraintInfo2* info) override;
    /// It has no parameters of Bullet's.
    void setParam(int, btScalar, int) override {}
    btScalar getParam(int, int) const override { return 0; }
};

}  // namespace bsoil::bullet
