#include "preload_constraint.h"

#include <algorithm>

namespace bsoil::bullet {

PreloadConstraint::PreloadConstraint(btRigidBody& body)
    : btTypedConstraint(MAX_CONSTRAINT_TYPE, body) {}

void PreloadConstraint::getInfo1(btConstraintInfo1* info) {
    info->m_numConstraintRows = size() > SIMD_EPSILON ? 1 : 0;
    info->nub = 0;
}

void PreloadConstraint::getInfo2(btConstraintInfo2* info) {
    // A row of any length will do; one near 1 keeps the solver's single precision.
    const btVector3 linear = force_n / size(), angular = torque_n_m / size();
    std::copy_n(static_cast<const btScalar*>(linear), 3, info->m_J1linearAxis);
    std::copy_n(static_cast<const btScalar*>(angular), 3, info->m_J1angularAxis);
    info->m_constraintError[0] = 0;
    info->m_lowerLimit[0] = info->m_upperLimit[0] = size() / info->fps;
}

}  // namespace bsoil::bullet
