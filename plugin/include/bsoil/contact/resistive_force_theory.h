/// Resistive force theory: stress on a surface element that moves through granular soil.
#pragma once

#include "bsoil/geometry.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Stress on an element per (xi times depth): a vector that resists the motion. Three-dimensional
/// resistive force theory of Agarwal, Goldman and Kamrin, "Mechanistic framework for reduced-order
/// models in soft materials: Application to three-dimensional granular intrusion", PNAS 120 (2023)
/// e2214017120. normal: unit, out of the body. direction: unit, of the element's motion. up: unit.
/// The part along the surface is cut to surface_friction times the part along the normal. Elements
/// that do not move into the soil (normal . direction <= 0) feel nothing.
Vec3 resistive_stress(Vec3 normal, Vec3 direction, Vec3 up, double surface_friction);

/// xi [Pa/m] = rho g (894 mu^3 - 386 mu^2 + 89 mu), mu = tan phi, of the same paper; fitted for mu
/// of 0.1 to 0.9.
double resistive_stiffness_pa_m(double density_kg_m3, double gravity_m_s2, double tan_phi);

}  // namespace bsoil
#pragma GCC visibility pop
