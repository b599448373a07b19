/// The ranges of SurfaceFriction.
#pragma once

#include <cmath>
#include <string>

#include "bsoil/body.h"
#include "bsoil/result.h"

namespace bsoil::bullet {

/// Names the field, its value and its range when something is wrong.
inline Status check_surface(const SurfaceFriction& surface) {
    const auto check = [](const char* field, double value, double most) -> Status {
        if (std::isfinite(value) && value <= most) return Done{};
        return Error{std::string("SurfaceFriction::") + field + " is " + std::to_string(value) +
                     ", must be at most " + std::to_string(most) +
                     ", or negative for the material's"};
    };
    if (Status s = check("friction", surface.friction, 2); !s) return s;
    return check("adhesion_pa", surface.adhesion_pa, 200e3);
}

}  // namespace bsoil::bullet
