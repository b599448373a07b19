/// PreloadConstraint: a force and a torque that a body gets at the start of the solve.
#pragma once

#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>

namespace bsoil::bullet {

/// One row whose impulse is fixed: the solver gives it in its first iteration, and all later rows
/// see the velocities it makes. Bullet's own accumulators would do for the force, but its friction
/// rows leave out an applied torque's part of the velocity: what rests on a light body would be
/// dragged along by a turning that does not take place.
class PreloadConstraint final : public btTypedConstraint {
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();
    explicit PreloadConstraint(btRigidBody& body);

    /// World axes, about the centre of mass.
    btVector3 force_n{0, 0, 0}, torque_n_m{0, 0, 0};

    void getInfo1(btConstraintInfo1* info) override;
    void getInfo2(btConstraintInfo2* info) override;
    /// It has no parameters of Bullet's.
    void setParam(int, btScalar, int) override {}
    btScalar getParam(int, int) const override { return 0; }

  private:
    btScalar size() const { return force_n.length() + torque_n_m.length(); }
};

}  // namespace bsoil::bullet
