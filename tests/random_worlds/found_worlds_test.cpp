// Worlds in which something was found once.
#include "expect_holds.h"

namespace bsoil::random_worlds::found_worlds_test {
namespace {

// A joint's work, and an overlap with soil whose surface is made anew, count as Bullet's. A light
// body that a heavy one pulls along by a joint is excused.
TEST(SlowRandomWorlds, gain_no_energy_but_by_joints_and_overlaps) {
    expect_all_holds(2360, 2360, Run::watched, PlanKind::any);
    expect_all_holds(5027, 5027, Run::watched, PlanKind::any);
    expect_all_holds(900160, 900160, Run::watched, PlanKind::any);
    expect_all_holds(971272, 971272, Run::watched, PlanKind::any, Sky::weather);
}

// A body throws soil faster than its own way in that step, one of 19 t shuts soil in, one presses
// soil against the grid's top, one whips round between two steps, and one whose ground its host
// takes away must not hang in the air.
TEST(SlowRandomWorlds, set_no_status_and_bear_nothing_without_a_cause) {
    expect_all_holds(2070032, 2070032, Run::watched, PlanKind::any);
    expect_all_holds(3002017, 3002017, Run::watched, PlanKind::any);
    expect_all_holds(3006057, 3006057, Run::watched, PlanKind::any, Sky::weather);
    expect_all_holds(10001147, 10001147, Run::watched, PlanKind::small);
    expect_all_holds(10009001, 10009001, Run::watched, PlanKind::any);
}

// What fell through the floor, what rocks on a driven body, and what lies where 3.4 t went through.
TEST(SlowRandomWorlds, ask_nothing_of_what_others_hold_or_have_dug) {
    expect_all_holds(3001145, 3001145, Run::watched, PlanKind::small);
    expect_all_holds(4003151, 4003151, Run::watched, PlanKind::calm);
    expect_all_holds(5001006, 5001006, Run::watched, PlanKind::any);
    expect_all_holds(6100001, 6100001, Run::watched, PlanKind::any);
}

// A bank at an open side that stands by suction, until groundwater has filled its pores once more.
TEST(SlowRandomWorlds, rest_once_groundwater_has_wetted_them) {
    expect_all_holds(8010103, 8010103, Run::watched, PlanKind::small, Sky::weather);
}

// Wind presses a heap into a corner below the grid's end.
TEST(SlowRandomWorlds, rest_but_for_what_rising_wind_holds_up) {
    expect_all_holds(9000054, 9000054, Run::watched, PlanKind::any, Sky::weather);
}

// A chain in the air that folds on its own base.
TEST(RandomWorlds, gain_no_energy_of_a_chain_that_hits_itself) {
    expect_all_holds(10000044, 10000044, Run::watched, PlanKind::any);
}

// A body that only covers throws soil, and what lies on it.
TEST(SlowRandomWorlds, gain_what_a_body_gives_that_feels_no_soil) {
    expect_all_holds(11003074, 11003074, Run::watched, PlanKind::any, Sky::weather);
}

// A body meets soil of which more is undisturbed than there is, by a rounding: 1.00003 of it.
TEST(RandomWorlds, are_saved_over_soil_that_is_whole_by_a_rounding) {
    expect_all_holds(11005188, 11005188, Run::restored, PlanKind::any);
}

// A box of 6 g in loam that falls was thrown at 1,446 m/s.
TEST(SlowRandomWorlds, throw_no_light_body_by_soil_that_passes_it) {
    expect_all_holds(10010156, 10010156, Run::watched, PlanKind::calm, Sky::weather);
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

// A capsule of 2 g under a stream of gravel, which flew off at 148 m/s.
TEST(SlowRandomWorlds, gain_no_energy_of_loads_that_stop_a_step_later) {
    expect_all_holds(8005063, 8005063, Run::watched, PlanKind::any, Sky::weather);
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

}  // namespace
}  // namespace bsoil::random_worlds::found_worlds_test
