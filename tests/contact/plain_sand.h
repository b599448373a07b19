/// The sand that the plain law is tested with, and the rules that it may take.
#pragma once

#include <numbers>

#include "bsoil/material.h"

namespace bsoil {

constexpr double kPhi = 33 * std::numbers::pi / 180;

inline MaterialDef sand() {
    MaterialDef material;
    material.name = "sand";
    material.density_kg_m3 = 1600;
    material.loose_density_kg_m3 = material.compacted_density_kg_m3 = 0;
    material.friction_angle_rad = kPhi;
    material.cohesion_pa = 0;
    material.tool_friction = 0.5;
    return material;
}

/// Rules on top of resistive force theory.
struct Rules {
    bool wedge = false, trapped = false;
};

}  // namespace bsoil
