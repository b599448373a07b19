// Worlds that nobody designed: fixed seeds. tests/random_worlds/run.sh runs them by the thousand.
#include <gtest/gtest.h>

#include <numbers>

#include "expect_holds.h"
#include "lie_of_body.h"
#include "make_plan.h"
#include "minimize.h"
#include "run_plan.h"

namespace bsoil::random_worlds::random_worlds_test {
namespace {

TEST(RandomWorlds, keep_every_promise_until_they_rest) {
    expect_all_holds(2, 3, Run::watched, PlanKind::any);
}

TEST(RandomWorlds, lose_energy_where_nothing_does_work) {
    expect_all_holds(102, 103, Run::watched, PlanKind::calm);
}

TEST(RandomWorlds, repeat_to_the_bit_with_one_thread_and_two) {
    expect_all_holds(201, 202, Run::repeated, PlanKind::any);
}

TEST(RandomWorlds, go_on_to_the_bit_from_a_snapshot) {
    expect_all_holds(301, 302, Run::restored, PlanKind::any);
}

TEST(RandomWorlds, go_on_where_falls_are_the_last_thing_saved) {
    expect_all_holds(2082, 2082, Run::restored, PlanKind::calm);
}

// Until a restored world looked a push stayed that soil took along into a gap below, spans as they
// were before a gap was closed, and the momentum of a crumb that had slid under a roof.
TEST(RandomWorlds, go_on_where_slides_closed_gaps_in_pushed_soil) {
    expect_all_holds(40054, 40054, Run::restored, PlanKind::any, Sky::weather);
    expect_all_holds(1060003, 1060003, Run::restored, PlanKind::any, Sky::weather);
    expect_all_holds(1040115, 1040115, Run::restored, PlanKind::any, Sky::weather);
}

// Of a plane that had nothing left to break a restored world noted that it fails, and a running one
// did not look at it again.
TEST(RandomWorlds, go_on_where_a_bank_has_no_bonds_left_to_break) {
    expect_all_holds(1060032, 1060032, Run::restored, PlanKind::any, Sky::weather);
}

// Planes were passed over as too strong because all that they passed was whole, but for loose soil
// where they came out. A restored world had counted one voxel more as whole, since it was again.
TEST(RandomWorlds, go_on_where_a_bank_is_whole_but_for_its_top) {
    expect_all_holds(3005186, 3005186, Run::restored, PlanKind::any, Sky::weather);
}

// Each had soil that stayed awake for good: dust and thin layers that slide, soil that goes to and
// fro between a body and a slope, pushes without soil or into crowded soil, dust on a steep face,
// rough soil that slides, and soil aslant on a body that has hardly any friction.
TEST(SlowRandomWorlds, sleep_where_thin_soil_lies_about) {
    using enum PlanKind;
    expect_all_holds(91002, 91002, Run::watched, calm, Sky::weather);
    expect_all_holds(91013, 91013, Run::watched, small, Sky::weather);
    expect_all_holds(91016, 91016, Run::watched, any);
    expect_all_holds(91029, 91029, Run::watched, calm, Sky::weather);
    expect_all_holds(96003, 96003, Run::watched, calm);
    expect_all_holds(840172, 840172, Run::watched, calm, Sky::weather);
    expect_all_holds(850107, 850107, Run::watched, any);
    expect_all_holds(900610, 900610, Run::watched, any);
    expect_all_holds(900415, 900415, Run::watched, any, Sky::weather);
    expect_all_holds(1000074, 1000074, Run::watched, any, Sky::weather);
    expect_all_holds(1020089, 1020089, Run::watched, calm, Sky::weather);
    expect_all_holds(1100224, 1100224, Run::watched, calm, Sky::weather);
    expect_all_holds(1100224, 1100224, Run::watched, small, Sky::weather);
    expect_all_holds(2013041, 2013041, Run::watched, small, Sky::weather);
    expect_all_holds(3004156, 3004156, Run::watched, calm, Sky::weather);
}

TEST(RandomWorlds, are_the_same_on_gl) {
    const WorldPlan plan = make_plan(401, PlanKind::small);
    SoilDef def = plan.soils[0].def;
    def.backend = Backend::gl;
    if (const auto soil = Soil::create(def); !soil) {
        GTEST_SKIP() << soil.error();
    }
    expect_all_holds(401, 401, Run::on_gl, PlanKind::small);
    expect_all_holds(402, 402, Run::on_gl, PlanKind::small, Sky::weather);
}

TEST(RandomWorlds, keep_every_promise_in_any_weather) {
    expect_all_holds(2, 2, Run::watched, PlanKind::any, Sky::weather);
}

TEST(SlowRandomWorlds, keep_every_promise_in_any_weather) {
    expect_all_holds(3, 3, Run::watched, PlanKind::any, Sky::weather);
    expect_all_holds(2073005, 2073005, Run::watched, PlanKind::small, Sky::weather);
}

TEST(RandomWorlds, repeat_to_the_bit_in_any_weather) {
    expect_all_holds(201, 202, Run::repeated, PlanKind::any, Sky::weather);
}

TEST(RandomWorlds, go_on_to_the_bit_in_any_weather) {
    expect_all_holds(301, 302, Run::restored, PlanKind::any, Sky::weather);
}

// --- the tests themselves: what finds nothing is not looking

/// A bed with one box on it.
WorldPlan box_on_bed() {
    WorldPlan plan;
    SoilPlan soil;
    soil.def.size_m = {1, 1, 1};
    soil.def.backend = Backend::cpu;
    soil.def.materials = {materials::dry_sand()};
    soil.fills.push_back({.low_m = {}, .high_m = {1, 1, 0.3}});
    plan.soils.push_back(soil);
    BodyPlan box;
    box.shape = box_plan({0.15, 0.15, 0.15});
    box.mass_kg = 40;
    box.pose.position = {0.5, 0.5, 0.47};
    plan.bodies.push_back(box);
    plan.action_steps = 30;
    return plan;
}

/// What a check makes of a world that is tampered with once, half a second in.
std::vector<Failure> failures_of(std::unique_ptr<Check> (*make)(const BuiltWorld&),
                                 void (*tamper)(BuiltWorld&),
                                 const WorldPlan& plan = box_on_bed()) {
    BuiltWorld world(plan);
    EXPECT_EQ(world.error(), "");
    const std::unique_ptr<Check> check = make(world);
    world.on_substep = [&] { check->after_substep(world); };
    Failures failures(0);
    for (int i = 0; i < 300; ++i) {
        world.step();
        if (i == 30) tamper(world);
        check->after_step(world, failures);
    }
    check->at_end(world, true, failures);
    return failures.list();
}

TEST(Checks, find_nothing_in_a_sound_world) {
    for (const auto make : {make_units_check, make_energy_check, make_status_check, make_mesh_check,
                            make_rest_check}) {
        for (const Failure& failure : failures_of(make, [](BuiltWorld&) {})) {
            ADD_FAILURE() << text_of(failure);
        }
    }
}

TEST(Checks, find_soil_that_comes_from_nowhere) {
    const auto failures = failures_of(make_units_check, [](BuiltWorld& world) {
        EXPECT_TRUE(world.soil(0).fill(BoxFill{{{-0.1, 0.5, -0.1}, {0.1, 0.6, 0.1}}, "dry_sand"}));
    });
    ASSERT_EQ(failures.size(), 1u);
    EXPECT_EQ(failures[0].invariant, "units");
}

TEST(Checks, find_water_that_comes_from_nowhere) {
    WorldPlan plan = box_on_bed();
    plan.soils[0].def.materials[0].pore_water_fraction = 0.2;
    plan.soils[0].def.materials[0].placed_saturation = 0.5;
    plan.soils[0].def.rain_m_s = 1e-4;
    const auto fill = [](BuiltWorld& world) {
        EXPECT_TRUE(world.soil(0).fill(BoxFill{{{-0.1, 0.5, -0.1}, {0.1, 0.6, 0.1}}, "dry_sand"}));
    };
    EXPECT_TRUE(failures_of(
                    make_units_check, [](BuiltWorld&) {}, plan)
                    .empty());
    const auto failures = failures_of(make_units_check, fill, plan);
    ASSERT_EQ(failures.size(), 2u);
    EXPECT_EQ(failures[1].invariant, "water");
}

TEST(Checks, find_energy_that_comes_from_nowhere) {
    const auto failures = failures_of(make_energy_check, [](BuiltWorld& world) {
        world.body(0)->setLinearVelocity({0, 1, 0});
    });
    ASSERT_EQ(failures.size(), 1u);
    EXPECT_EQ(failures[0].invariant, "energy");
}

TEST(Checks, find_a_body_asleep_in_the_air) {
    const auto failures = failures_of(make_rest_check, [](BuiltWorld& world) {
        world.world().setGravity({0, 0, 0});
        world.body(0)->setGravity({0, 0, 0});
        btTransform pose = world.body(0)->getWorldTransform();
        pose.getOrigin().setY(pose.getOrigin().y() + btScalar(0.3));
        world.body(0)->setWorldTransform(pose);
        world.body(0)->setLinearVelocity({0, 0, 0});
    });
    std::string found;
    for (const Failure& failure : failures) found += failure.invariant + ' ';
    EXPECT_EQ(found, "weight held ");
}

TEST(Checks, find_a_body_that_lies_too_deep) {
    const auto failures = failures_of(make_rest_check, [](BuiltWorld& world) {
        btTransform pose = world.body(0)->getWorldTransform();
        pose.getOrigin().setY(pose.getOrigin().y() - btScalar(0.25));
        world.body(0)->setWorldTransform(pose);
    });
    std::string found;
    for (const Failure& failure : failures) found += failure.invariant + ' ';
    EXPECT_NE(found.find("sinkage"), std::string::npos) << found;
}

// The sink's pit does not reach the surface beside the box.
TEST(Checks, find_a_body_that_lies_too_deep_beside_a_pit) {
    WorldPlan plan = box_on_bed();
    plan.soils[0].def.size_m = {2.5, 1, 1};
    plan.soils[0].fills[0].high_m.x = 2.5;
    FlowPlan flow;
    flow.sink.region.kind = ConvexShape::Kind::box;
    flow.sink.region.half_extents_m = {0.1, 0.1, 0.1};
    flow.sink.end_s = 0.5;
    const auto sinks = [](BuiltWorld& world) {
        btTransform pose = world.body(0)->getWorldTransform();
        pose.getOrigin().setY(pose.getOrigin().y() - btScalar(0.25));
        world.body(0)->setWorldTransform(pose);
    };
    for (const double x_m : {0.5, 2.2}) {
        flow.sink.pose.position = {x_m, 0.5, 0.2};
        plan.soils[0].flows.assign(1, flow);
        std::string found;
        for (const Failure& failure : failures_of(make_rest_check, sinks, plan)) {
            found += failure.invariant + ' ';
        }
        EXPECT_EQ(found.find("sinkage") != std::string::npos, x_m > 2) << x_m << ' ' << found;
    }
}

// Bullet wakes the box in each step, which keeps it from nothing but from falling asleep.
TEST(Checks, find_a_body_beside_a_driven_one_that_does_not_rest) {
    WorldPlan plan = box_on_bed();
    BodyPlan driven = plan.bodies[0];
    driven.kind = BodyPlan::Kind::driven;
    driven.pose.position = {0.82, 0.5, 0.6};
    plan.bodies.push_back(driven);
    for (const Failure& failure : failures_of(
             make_rest_check, [](BuiltWorld&) {}, plan)) {
        ADD_FAILURE() << text_of(failure);
    }
    const auto failures = failures_of(
        make_rest_check,
        [](BuiltWorld& world) {
            world.body(0)->setGravity({0, 0, 0});
            world.body(0)->setDamping(0, 0);
            world.body(0)->setAngularVelocity({0, 0, 2});
            world.body(0)->translate({0, btScalar(0.3), 0});
        },
        plan);
    ASSERT_EQ(failures.size(), 1u);
    EXPECT_EQ(failures[0].invariant, "bodies sleep");
}

// On a slope the surface beside a body is as high as the middle of the circle about it.
TEST(Checks, find_the_surface_beside_a_body_on_a_slope) {
    const WorldPlan plan = box_on_bed();
    BuiltWorld world(plan);
    ASSERT_EQ(world.error(), "");
    const auto flat = surface_beside_m(world, world.soil(0), {}, 0.3);
    ASSERT_TRUE(flat);
    EXPECT_NEAR(*flat, 0.3, 1e-6);
    ASSERT_TRUE(world.soil(0).fill(FunctionFill{[](Vec3 p) { return 0.5 + 0.3 * p.x - p.y; }, {}}));
    const auto sloping = surface_beside_m(world, world.soil(0), {}, 0.3);
    ASSERT_TRUE(sloping);
    EXPECT_NEAR(*sloping, 0.5, 0.02) << "a column's height is known to parts of a voxel";
    EXPECT_FALSE(surface_beside_m(world, world.soil(0), {5, 0, 5}, 0.3)) << "beside the soil";
}

// Its top is not what a body has sunk from.
TEST(Checks, find_the_surface_beside_a_body_at_a_bank) {
    WorldPlan plan = box_on_bed();
    plan.soils[0].fills.push_back({.low_m = {0, 0, 0}, .high_m = {1, 0.35, 0.8}});
    BuiltWorld world(plan);
    ASSERT_EQ(world.error(), "");
    const auto level = surface_beside_m(world, world.soil(0), {}, 0.3);
    ASSERT_TRUE(level);
    EXPECT_NEAR(*level, 0.3, 1e-6);
}

TEST(Checks, know_how_deep_a_plate_falls) {
    const WorldPlan plan = box_on_bed();
    BuiltWorld world(plan);
    ASSERT_EQ(world.error(), "");
    const Soil& soil = world.soil(0).soil();
    const double rest_m = sinkage_after_fall_m(soil, disc(0.1), 100, 0);
    EXPECT_GT(rest_m, 0);
    EXPECT_LT(rest_m, 0.01) << "3 kPa on dry sand";
    EXPECT_GT(sinkage_after_fall_m(soil, disc(0.1), 100, 1), 2 * rest_m);
    EXPECT_GT(sinkage_after_fall_m(soil, disc(0.1), 1000, 1),
              sinkage_after_fall_m(soil, disc(0.1), 100, 1));
}

// By Bekker's law with n = 1 soil is a spring: what is let go on it sinks to twice its sinkage.
TEST(Checks, know_how_deep_a_plate_falls_by_another_law) {
    WorldPlan plan = box_on_bed();
    BekkerSoil bekker;
    bekker.kphi_pa_m_n = 2e5;
    bekker.kc_pa_m_n1 = 0;
    bekker.n = 1;
    SoilDef& def = plan.soils[0].def;
    def.contact_law.kind = ContactLawDef::Kind::bekker;
    def.contact_law.bekker.assign(def.material_list().size(), bekker);
    BuiltWorld world(plan);
    ASSERT_EQ(world.error(), "");
    const double expected_m = 2 * 100 / (2e5 * std::numbers::pi * 0.01);
    EXPECT_NEAR(sinkage_after_fall_m(world.soil(0).soil(), disc(0.1), 100, 0), expected_m,
                0.1 * expected_m);
}

// Links of 1.3 cm rock as long as Bullet's solver has ten iterations. A chain that falls for good
// does so with any.
TEST(Checks, let_no_chain_roll_on_but_one_that_more_iterations_stop) {
    Failure awake;
    awake.invariant = "bodies sleep";
    WorldPlan plan = make_plan(971006, PlanKind::any);
    add_weather(plan);
    EXPECT_TRUE(known_fault(plan, awake));
    plan.chains[0].dropped = true;
    EXPECT_FALSE(known_fault(plan, awake));
    plan = box_on_bed();
    plan.chains.emplace_back().pose.position = {0.5, 0.5, 1e4};
    EXPECT_FALSE(known_fault(plan, awake));
}

TEST(Checks, find_a_status_without_a_cause) {
    const auto failures = failures_of(make_status_check, [](BuiltWorld& world) {
        btTransform pose = world.body(0)->getWorldTransform();
        pose.getOrigin().setX(std::numeric_limits<btScalar>::quiet_NaN());
        world.body(0)->setWorldTransform(pose);
        world.step();
    });
    ASSERT_FALSE(failures.empty());
    EXPECT_EQ(failures[0].invariant, "status");
}

TEST(Minimizer, leaves_what_the_failure_needs) {
    WorldPlan plan = box_on_bed();  // either body wakes the one tile too many
    plan.bodies.push_back(plan.bodies[0]);
    plan.bodies[1].pose.position = {0.2, 0.2, 0.47};
    plan.soils[0].def.tile_capacity = 1;
    const WorldPlan least = minimize(plan, Run::watched, "status");
    EXPECT_NE(least.bodies[0].dropped, least.bodies[1].dropped);
}

}  // namespace
}  // namespace bsoil::random_worlds::random_worlds_test
