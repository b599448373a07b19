// Worlds that nobody designed: fixed seeds. tests/random_worlds/run.sh runs them by the thousand.
#include <gtest/gtest.h>

#include <numbers>

#include "add_weather.h"
#include "known_faults.h"
#include "lie_of_body.h"
#include "make_plan.h"
#include "minimize.h"
#include "run_plan.h"

namespace bsoil::random_worlds::random_worlds_test {
namespace {

enum class Sky { dry, weather };

/// A state takes as long as some steps: the tool compares them all.
constexpr int kStatesEvery = 5;

void expect_all_holds(uint64_t first, uint64_t last, Run run, PlanKind kind, Sky sky = Sky::dry) {
    for (uint64_t seed = first; seed <= last; ++seed) {
        WorldPlan plan = make_plan(seed, kind);
        if (sky == Sky::weather) add_weather(plan);
        for (const Failure& failure : run_plan(plan, run, kStatesEvery)) {
            if (!known_fault(plan, failure)) ADD_FAILURE() << text_of(failure);
        }
    }
}

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

// --- what was found

// A joint's work, and an overlap with soil whose surface is made anew, count as Bullet's. A light
// body that a heavy one pulls along by a joint is excused.
TEST(SlowRandomWorlds, gain_no_energy_but_by_joints_and_overlaps) {
    expect_all_holds(2360, 2360, Run::watched, PlanKind::any);
    expect_all_holds(5027, 5027, Run::watched, PlanKind::any);
    expect_all_holds(900160, 900160, Run::watched, PlanKind::any);
    expect_all_holds(971272, 971272, Run::watched, PlanKind::any, Sky::weather);
}

// A body throws soil faster than its own way in that step, one of 19 t shuts soil in, and one whose
// ground its host takes away must not hang in the air.
TEST(SlowRandomWorlds, set_no_status_and_bear_nothing_without_a_cause) {
    expect_all_holds(2070032, 2070032, Run::watched, PlanKind::any);
    expect_all_holds(3002017, 3002017, Run::watched, PlanKind::any);
    expect_all_holds(3006057, 3006057, Run::watched, PlanKind::any, Sky::weather);
}

// What fell through the floor, what rocks on a driven body, and what lies where 3.4 t went through.
TEST(SlowRandomWorlds, ask_nothing_of_what_others_hold_or_have_dug) {
    expect_all_holds(3001145, 3001145, Run::watched, PlanKind::small);
    expect_all_holds(4003151, 4003151, Run::watched, PlanKind::calm);
    expect_all_holds(5001006, 5001006, Run::watched, PlanKind::any);
    expect_all_holds(6100001, 6100001, Run::watched, PlanKind::any);
}

// Soil that was filled into the air falls along with a capsule, and a little faster: 22 J.
TEST(RandomWorlds, gain_energy_from_soil_that_falls_with_them) {
    expect_all_holds(2020070, 2020070, Run::watched, PlanKind::any);
}

// A body that has left the soil and falls on the floor below. A chain whose swing Bullet's steps
// are too long for.
TEST(SlowRandomWorlds, have_no_energy_of_what_left_or_swings_coarsely) {
    expect_all_holds(185, 185, Run::watched, PlanKind::any, Sky::weather);
    expect_all_holds(88, 88, Run::watched, PlanKind::any, Sky::weather);
}

// Room without soil fell past a slope; a hull woke between two substeps, which gives no weight.
TEST(SlowRandomWorlds, go_on_without_soil_and_without_weight) {
    expect_all_holds(840051, 840051, Run::watched, PlanKind::calm, Sky::weather);
    expect_all_holds(810057, 810057, Run::watched, PlanKind::any, Sky::weather);
}

// A pendulum that nothing stops kept a cylinder of its island awake.
TEST(RandomWorlds, sleep_beside_a_chain_that_hangs_in_the_air) {
    expect_all_holds(2292, 2292, Run::watched, PlanKind::calm);
}

// A car of 25 g: it stands on its weight. One of 86 g sinks on until it sleeps. One of 270 g leans
// with a strut at its end on what lies before it. One of 17 g lies on soil that its wheels carry.
TEST(SlowRandomWorlds, have_cars_of_any_size_that_stand) {
    expect_all_holds(2040045, 2040045, Run::watched, PlanKind::any);
    expect_all_holds(5063, 5063, Run::watched, PlanKind::any);
    expect_all_holds(900271, 900271, Run::watched, PlanKind::any);
    expect_all_holds(6000073, 6000073, Run::watched, PlanKind::any, Sky::weather);
}

// A ball on soil of 105 kPa, a body of 1.4 g with 1 kg of soil on it, one with bodies on its load,
// and one that falls asleep under a jet.
TEST(SlowRandomWorlds, weigh_what_they_weigh_on_stiff_soil_and_under_a_load) {
    expect_all_holds(15, 15, Run::watched, PlanKind::calm, Sky::weather);
    expect_all_holds(72, 72, Run::watched, PlanKind::calm, Sky::weather);
    expect_all_holds(5002168, 5002168, Run::watched, PlanKind::calm);
    expect_all_holds(8005076, 8005076, Run::watched, PlanKind::any, Sky::weather);
}

// A pebble of 91 t that Bullet lifts out of a heightfield again and again, a chain that whips round
// in the air, a ball that a source hits at 39 m/s, and two that the soil does not see: a box on a
// surface that rises, and a cylinder that creeps up one.
TEST(SlowRandomWorlds, gain_no_energy_but_by_what_bullet_and_sources_do) {
    expect_all_holds(20034, 20034, Run::watched, PlanKind::calm, Sky::weather);
    expect_all_holds(20101, 20101, Run::watched, PlanKind::any, Sky::weather);
    expect_all_holds(20317, 20317, Run::watched, PlanKind::any, Sky::weather);
    expect_all_holds(970192, 970192, Run::watched, PlanKind::any, Sky::weather);
    expect_all_holds(8000081, 8000081, Run::watched, PlanKind::any, Sky::weather);
}

// A body on a joint that is put elsewhere and leaves 15 kg of soil behind.
TEST(SlowRandomWorlds, gain_no_energy_of_loads_left_behind) {
    expect_all_holds(91022, 91022, Run::watched, PlanKind::any, Sky::weather);
}

// A car whose chassis carries soil; boxes that fell asleep as a source hit them, or rocking.
TEST(SlowRandomWorlds, weigh_what_they_weigh_under_loads_and_pushes) {
    expect_all_holds(20168, 20168, Run::watched, PlanKind::any, Sky::weather);
    expect_all_holds(20090, 20090, Run::watched, PlanKind::any, Sky::weather);
}

// A mesh of 2.8 g that the law's gap bears.
TEST(RandomWorlds, are_held_over_the_gap_that_soil_bears_across) {
    expect_all_holds(40122, 40122, Run::watched, PlanKind::calm);
}

// A box that came to lie between a bank of loam and a step in gravel.
TEST(RandomWorlds, lie_no_deeper_beside_a_bank_than_on_a_plain) {
    expect_all_holds(20040, 20040, Run::watched, PlanKind::calm, Sky::weather);
}

// --- the tests themselves: what finds nothing is not looking

// The soil had wheels of a sleeping car a step back and here again; see
// RaycastVehicle.asleep_its_wheels_stand_and_so_does_the_soil.
TEST(RandomWorlds, sleep_under_a_sleeping_car) {
    expect_all_holds(81086, 81086, Run::watched, PlanKind::any);
}

// A body beside a driven one, which Bullet wakes in every step.
TEST(RandomWorlds, sleep_but_for_what_bullet_wakes) {
    expect_all_holds(81157, 81157, Run::watched, PlanKind::any);
}

// A body that fell asleep rocking, before soil was put elsewhere.
TEST(SlowRandomWorlds, weigh_what_they_weighed_awake) {
    expect_all_holds(81305, 81305, Run::watched, PlanKind::any);
}

// Bodies in pits that sinks have dug.
TEST(SlowRandomWorlds, have_not_sunk_into_pits) {
    expect_all_holds(80080, 80080, Run::watched, PlanKind::any, Sky::weather);
    expect_all_holds(80141, 80141, Run::watched, PlanKind::any, Sky::weather);
}

// A box with a slab of soil below it in the air, a body that goes through a thin bed on rock, and a
// cone that comes down on its tip.
TEST(SlowRandomWorlds, lie_no_deeper_than_there_is_soil_to_bear) {
    expect_all_holds(90114, 90114, Run::watched, PlanKind::calm);
    expect_all_holds(90127, 90127, Run::watched, PlanKind::any);
    expect_all_holds(970204, 970204, Run::watched, PlanKind::any);
}

// A capsule that one of Bullet's substeps turns by 45 deg while soil bears its other end.
TEST(RandomWorlds, lie_no_deeper_than_a_substep_turns_them) {
    expect_all_holds(1020065, 1020065, Run::watched, PlanKind::calm);
}

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
