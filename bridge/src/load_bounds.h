/// LoadBounds: the most that bodies can have to do with the soil of a grid.
#pragma once

#include "bsoil/soil.h"

namespace bsoil::bullet {

/// Of a grid that is full of the densest of its soils, soaked, all of it at the greatest speed that
/// soil gets. No body comes near: what it carries or hits is a part of that.
struct LoadBounds {
    explicit LoadBounds(const Soil& soil);

    double mass_kg = 0;
    double impulse_n_s = 0;  ///< that all of the soil's momentum turns round
    double diagonal_m = 0;   ///< from any of the soil to any other
    double step_s = 0;       ///< the soil's; a body pays in no less
};

}  // namespace bsoil::bullet
