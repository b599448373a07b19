/// What came into soils after the random worlds did: water, wind, what pours in and is taken out,
/// open sides, snow and mud. Known seeds keep their worlds without it.
#pragma once

#include "world_plan.h"

namespace bsoil::random_worlds {

/// Adds weather to a plan, drawn from a stream of its own: the plan's seed decides it, and nothing
/// else in the plan changes but what its soils are made of.
void add_weather(WorldPlan& plan);

}  // namespace bsoil::random_worlds
