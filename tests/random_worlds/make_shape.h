/// Random shapes.
#pragma once

#include "random.h"
#include "world_plan.h"

namespace bsoil::random_worlds {

/// A shape of a body that moves; no point farther than bound_m from its origin. Its origin lies
/// within it.
ShapePlan make_moving_shape(Random& random, double bound_m);
/// Any shape of Bullet, for a fixed body. Heightfields are `extent_m` wide.
ShapePlan make_fixed_shape(Random& random, double bound_m, double extent_m);

}  // namespace bsoil::random_worlds
