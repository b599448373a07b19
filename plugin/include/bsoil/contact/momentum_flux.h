/// Inertial drag: what soil that is set in motion takes from a body.
#pragma once

#include "bsoil/cxx20.h"

namespace bsoil {

/// Momentum flux rho v^2: the stress [Pa] on a face that goes into soil of a density [kg/m3] at a
/// speed along its normal [m/s, not negative]. With mass per length [kg/m], a density times an
/// area, it is a force [N].
constexpr double momentum_flux(double density, double normal_speed) {
    return density * normal_speed * normal_speed;
}

}  // namespace bsoil
