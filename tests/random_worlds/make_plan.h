/// From a seed to a world.
#pragma once

#include "world_plan.h"

namespace bsoil::random_worlds {

/// How large and how varied.
enum class PlanKind {
    any,    ///< everything there is
    calm,   ///< nothing does work: no motors, driven bodies, teleports or options that change
    small,  ///< a tenth of the voxels: for the software GL
};

WorldPlan make_plan(uint64_t seed, PlanKind kind);

}  // namespace bsoil::random_worlds
