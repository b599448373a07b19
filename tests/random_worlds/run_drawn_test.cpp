// That pictures show the soil that is there: fixed seeds.
#include "run_drawn.h"

#include <gtest/gtest.h>

#include "add_weather.h"
#include "make_plan.h"

namespace bsoil::random_worlds::run_drawn_test {
namespace {

// In the second, beside a side of the grid that a sink has bared, soil was seen in the terrain.
TEST(DrawnWorlds, show_what_is_there_and_stay_as_they_are) {
    if (!can_draw()) {
        GTEST_SKIP() << "no pictures here";
    }
    for (const uint64_t seed : {3u, 5u}) {
        WorldPlan plan = make_plan(seed, PlanKind::any);
        if (seed == 5) add_weather(plan);
        Failures failures(seed);
        run_drawn(plan, failures);
        for (const Failure& failure : failures.list()) ADD_FAILURE() << text_of(failure);
    }
}

}  // namespace
}  // namespace bsoil::random_worlds::run_drawn_test
