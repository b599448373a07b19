/// Runs the world of a plan and checks everything about it.
#pragma once

#include <vector>

#include "check.h"
#include "world_plan.h"

namespace bsoil::random_worlds {

enum class Run {
    watched,   ///< until it rests, with every check of check.h
    repeated,  ///< twice with one thread, once with two: equal bit for bit
    restored,  ///< from a snapshot of the world: goes on bit for bit
    on_gl,     ///< software GL against the CPU, some steps
    drawn,     ///< with pictures and without
};
const char* name_of(Run run);

/// Time within which soil sleeps once it is left alone [s]: the longer the slower air lets it fall,
/// the farther a bank has to an open side, and the more viscous it is.
double rest_s(const WorldPlan& plan);

/// states_every: Run::restored compares whole states in every so many frames, bits in each.
std::vector<Failure> run_plan(const WorldPlan& plan, Run run, int states_every = 1);

}  // namespace bsoil::random_worlds
