/// Worlds of fixed seeds in which all that must hold does.
#pragma once

#include <gtest/gtest.h>

#include "add_weather.h"
#include "known_faults.h"
#include "make_plan.h"
#include "run_plan.h"

namespace bsoil::random_worlds {

enum class Sky { dry, weather };

/// A state takes as long as some steps: the tool compares them all.
constexpr int kStatesEvery = 5;

inline void expect_all_holds(uint64_t first, uint64_t last, Run run, PlanKind kind,
                             Sky sky = Sky::dry) {
    for (uint64_t seed = first; seed <= last; ++seed) {
        WorldPlan plan = make_plan(seed, kind);
        if (sky == Sky::weather) add_weather(plan);
        for (const Failure& failure : run_plan(plan, run, kStatesEvery)) {
            if (!known_fault(plan, failure)) ADD_FAILURE() << text_of(failure);
        }
    }
}

}  // namespace bsoil::random_worlds
