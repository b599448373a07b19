/// Pictures of a world: that they show the soil that is there, and change none of it.
#pragma once

#include "check.h"
#include "world_plan.h"

namespace bsoil::random_worlds {

/// Whether this build and this machine draw pictures.
bool can_draw();

/// Runs the world twice, once with pictures now and then.
void run_drawn(const WorldPlan& plan, Failures& failures);

}  // namespace bsoil::random_worlds
