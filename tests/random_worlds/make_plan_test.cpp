// Plans of random worlds: the same for the same seed, with everything in them.
#include "make_plan.h"

#include <gtest/gtest.h>

#include "add_weather.h"

namespace bsoil::random_worlds::make_plan_test {
namespace {

TEST(RandomWorlds, are_the_same_for_the_same_seed_alone) {
    EXPECT_EQ(describe(make_plan(7, PlanKind::any)), describe(make_plan(7, PlanKind::any)));
    EXPECT_NE(describe(make_plan(7, PlanKind::any)), describe(make_plan(8, PlanKind::any)));
}

TEST(RandomWorlds, have_everything_in_them) {
    int fixed = 0, driven = 0, joints = 0, cars = 0, chains = 0, events = 0, soils = 0;
    std::vector<int> shapes(19, 0);
    for (uint64_t seed = 1; seed <= 400; ++seed) {
        const WorldPlan plan = make_plan(seed, PlanKind::any);
        for (const BodyPlan& body : plan.bodies) {
            ++shapes[static_cast<size_t>(body.shape.kind)];
            fixed += body.kind == BodyPlan::Kind::fixed;
            driven += body.kind == BodyPlan::Kind::driven;
        }
        joints += static_cast<int>(plan.joints.size());
        cars += static_cast<int>(plan.cars.size());
        chains += static_cast<int>(plan.chains.size());
        events += static_cast<int>(plan.events.size());
        soils += static_cast<int>(plan.soils.size());
    }
    for (const int count : {fixed, driven, joints, cars, chains, events}) EXPECT_GT(count, 10);
    EXPECT_GT(soils, 420);
    for (size_t kind = 0; kind < static_cast<size_t>(ShapePlan::Kind::none); ++kind) {
        EXPECT_GT(shapes[kind], 5) << name_of(static_cast<ShapePlan::Kind>(kind));
    }
}

TEST(RandomWorlds, have_every_weather_and_no_other_plan_by_it) {
    int wet = 0, windy = 0, open = 0, sources = 0, sinks = 0, laws = 0, viscous = 0, run_out = 0,
        flooded = 0, wells = 0;
    for (uint64_t seed = 1; seed <= 200; ++seed) {
        const WorldPlan plan = make_plan(seed, PlanKind::any);
        WorldPlan changed = plan;
        add_weather(changed);
        for (const SoilPlan& soil : changed.soils) {
            wet += soil.def.rain_m_s > 0;
            windy += length(soil.def.wind_m_s) > 0;
            open += soil.def.open_sides != 0;
            flooded += soil.def.water_table_m > 0;
            for (const FlowPlan& flow : soil.flows) wells += flow.sink.water_kg_s != 0;
            run_out += soil.def.slides == SlideMotion::run_out;
            laws += soil.def.contact_law.kind != ContactLawDef::Kind::granular;
            for (const MaterialDef& m : soil.def.materials) viscous += m.viscosity > 0;
            for (const FlowPlan& flow : soil.flows) ++(flow.is_source ? sources : sinks);
            EXPECT_TRUE(soil.def.validate()) << seed << ": " << soil.def.validate().error();
        }
        changed.soils = plan.soils;
        changed.has_weather = false;
        EXPECT_EQ(describe(changed), describe(plan));
    }
    for (const int count :
         {wet, windy, open, sources, sinks, laws, viscous, run_out, flooded, wells}) {
        EXPECT_GT(count, 10);
    }
}

}  // namespace
}  // namespace bsoil::random_worlds::make_plan_test
