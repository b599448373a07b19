/// Makes a failing world smaller.
#pragma once

#include <string>

#include "run_plan.h"

namespace bsoil::random_worlds {

/// Drops bodies, fills, joints, machines and events, one after the other, as long as the run still
/// fails that invariant.
WorldPlan minimize(WorldPlan plan, Run run, const std::string& invariant);

}  // namespace bsoil::random_worlds
