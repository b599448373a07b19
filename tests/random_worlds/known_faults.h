/// Promises that are not kept yet in some worlds, each with its reason: the one list of exclusions.
#pragma once

#include "check.h"

namespace bsoil::random_worlds {

/// The reason why this failure of this world is known; null: it is news.
const char* known_fault(const WorldPlan& plan, const Failure& failure);

}  // namespace bsoil::random_worlds
