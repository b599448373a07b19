#include "torque_constraint.h"

#include <algorithm>

namespace bsoil::bullet {

TorqueConstraint::TorqueConstraint(btRigidBody& body)
    : btTypedConstraint(MAX_CONSTRAINT_TYPE, body) {}

void TorqueConstraint::getInfo1(btConstraintInfo1* info) {
    info->m_numConstraintRows = torque_n_m.length() > 0 ? 1 : 0;
    info->nub = 0;
}

void TorqueConstraint::getInfo2(btConstraintInfo2* info) {
    const btScalar size_n_m = torque_n_m.length();
    const btVector3 axis = torque_n_m / size_n_m;
    std::copy_n(static_cast<const btScalar*>(axis), 3, info->m_J1angularAxis);
    info->m_constraintError[0] = 0;
    info->m_lowerLimit[0] = info->m_upperLimit[0] = size_n_m / info->fps;
}

}  // namespace bsoil::bullet
