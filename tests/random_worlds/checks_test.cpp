// What the checks of random worlds take for a cause, and what they do not.
#include <gtest/gtest.h>

#include <cmath>

#include "built_world.h"
#include "check.h"
#include "known_faults.h"
#include "mechanics.h"

namespace bsoil::random_worlds::checks_test {
namespace {

constexpr double kAcross = 0.466;  // tan 25 deg

/// A metre each way, filled to this height.
WorldPlan bed(double height_m) {
    WorldPlan plan;
    SoilPlan soil;
    soil.def.size_m = {1, 1, 1};
    soil.def.voxel_m = 0.05;
    soil.def.up = UpAxis::z;
    soil.def.backend = Backend::cpu;
    soil.def.materials = {materials::dry_sand()};
    if (height_m > 0) soil.fills.push_back({.low_m = {}, .high_m = {1, 1, height_m}});
    plan.soils.push_back(soil);
    plan.action_steps = 1000;
    return plan;
}

BodyPlan box_at(Vec3 at_m, Vec3 half_m, BodyPlan::Kind kind) {
    BodyPlan box;
    box.kind = kind;
    box.shape = box_plan(half_m);
    box.mass_kg = 40;
    box.pose.position = at_m;
    return box;
}

using MakeCheck = std::unique_ptr<Check> (*)(const BuiltWorld&);

std::string failures_of(MakeCheck make, const WorldPlan& plan, int steps,
                        const std::function<void(BuiltWorld&)>& before_step = {}) {
    BuiltWorld world(plan);
    EXPECT_EQ(world.error(), "");
    const std::unique_ptr<Check> check = make(world);
    world.on_substep = [&] { check->after_substep(world); };
    Failures failures(0);
    for (int i = 0; i < steps; ++i) {
        if (before_step) before_step(world);
        world.step();
        check->after_step(world, failures);
    }
    check->at_end(world, true, failures);
    std::string out;
    for (const Failure& failure : failures.list()) out += failure.invariant + ' ';
    return out;
}

// Small bodies sink deeper than plates of their size, which is known: it says nothing of others.
TEST(Failures, are_told_of_each_body) {
    WorldPlan plan = bed(0.3);
    plan.bodies.push_back(box_at({0.3, 0.5, 0.5}, {0.05, 0.05, 0.05}, BodyPlan::Kind::moving));
    plan.bodies.push_back(box_at({0.7, 0.5, 0.5}, {0.2, 0.2, 0.2}, BodyPlan::Kind::moving));
    Failures failures(0);
    for (const char* body : {"body 0 (box)", "body 1 (box)", "body 1 (box)"}) {
        failures.add("sinkage", body, 1, "less", "more");
    }
    ASSERT_EQ(failures.list().size(), 2u);
    EXPECT_NE(known_fault(plan, failures.list()[0]), nullptr);
    EXPECT_EQ(known_fault(plan, failures.list()[1]), nullptr);
}

// Sand that stands upright beside a box slides in about it, 0.2 m high: it has not sunk from there.
TEST(RestCheck, goes_by_the_surface_that_a_body_has_met) {
    WorldPlan plan = bed(0.2);
    plan.soils[0].def.size_m = {1.2, 1.2, 1};
    plan.soils[0].fills[0].high_m = {1.2, 1.2, 0.2};
    plan.soils[0].fills.push_back({.low_m = {0, 0.65, 0.2}, .high_m = {1.2, 1.2, 1}});
    plan.bodies.push_back(box_at({0.6, 0.6, 0.32}, {0.1, 0.1, 0.1}, BodyPlan::Kind::moving));
    bool sleeps = false;
    const auto look = [&sleeps](BuiltWorld& world) { sleeps = world.is_all_asleep(); };
    EXPECT_EQ(failures_of(make_rest_check, plan, 400, look), "");
    EXPECT_TRUE(sleeps) << "else nothing is asked of it";
}

// What has left the soil may roll on for good, also where it still reaches into it.
TEST(SleepCheck, takes_what_reaches_in_from_beside_for_a_cause) {
    for (const double x_m : {1.1, 1.5}) {
        WorldPlan plan = bed(0.3);
        plan.bodies.push_back(box_at({0.3, 0.5, 0.5}, {0.1, 0.1, 0.1}, BodyPlan::Kind::driven));
        plan.bodies[0].velocity_m_s = {0.02, 0, -0.02};  // it keeps the soil awake
        plan.bodies.push_back(box_at({x_m, 0.5, 0.5}, {0.2, 0.05, 0.05}, BodyPlan::Kind::moving));
        const std::string found = failures_of(make_rest_check, plan, 60, [](BuiltWorld& world) {
            btRigidBody& body = *world.body(1);
            body.setGravity({0, 0, 0});
            body.setLinearVelocity({0, 0, 0});
            body.setAngularVelocity({0, 2, 0});
            body.setDamping(0, 0);
        });
        EXPECT_EQ(found, x_m < 1.3 ? "" : "soil sleeps ") << x_m;
    }
}

// As wide as the grid: what is below it has no way out.
TEST(StatusCheck, takes_soil_that_a_driven_body_shuts_in_for_a_cause) {
    WorldPlan plan = bed(0.3);
    plan.bodies.push_back(box_at({0.5, 0.5, 0.55}, {0.6, 0.6, 0.2}, BodyPlan::Kind::driven));
    plan.bodies[0].velocity_m_s = {0, 0, -0.5};
    uint32_t met = 0;
    const auto note = [&met](BuiltWorld& world) { met |= world.soil(0).soil().status_bits(); };
    EXPECT_EQ(failures_of(make_status_check, plan, 60, note), "");
    EXPECT_NE(met & static_cast<uint32_t>(StatusBit::amount_headroom), 0u);
}

TEST(StatusCheck, finds_no_cause_in_a_driven_body_elsewhere) {
    WorldPlan plan = bed(0.3);
    plan.bodies.push_back(box_at({0.5, 0.5, 0.8}, {0.1, 0.1, 0.1}, BodyPlan::Kind::driven));
    EXPECT_EQ(failures_of(make_status_check, plan, 3), "");
    const auto tamper = [](BuiltWorld& world) {
        world.soil(0).soil().set_status(StatusBit::amount_headroom);
    };
    EXPECT_EQ(failures_of(make_status_check, plan, 3, tamper), "status ");
}

/// Pours on what is at this place from 30 cm above it.
void pour_on(WorldPlan& plan, Vec3 at_m) {
    FlowPlan flow;
    flow.is_source = true;
    flow.source.center_m = at_m + Vec3{0, 0, 0.3};
    flow.source.radius_m = 0.06;
    flow.source.speed_m_s = 15;
    flow.source.rate_kg_s = 50;
    plan.soils[0].flows.push_back(flow);
}

/// All that the bodies gain in so many steps is work of what is poured on them or blown.
void expect_poured_work_counted(const WorldPlan& plan, int steps = 8) {
    EXPECT_EQ(failures_of(make_energy_check, plan, steps), "");
    BuiltWorld world(plan);
    const double before_j = energy_j(world, moving_parts(world));
    for (int i = 0; i < steps; ++i) world.step();
    const double gained_j = energy_j(world, moving_parts(world)) - before_j;
    EXPECT_GT(gained_j, 1);
    EXPECT_NEAR(world.poured_work_j() / gained_j, 1, 0.2);
}

TEST(EnergyCheck, counts_what_poured_soil_turns_a_body_by) {
    WorldPlan plan = bed(0.1);
    plan.bodies.push_back(box_at({0.5, 0.5, 0.6}, {0.3, 0.06, 0.04}, BodyPlan::Kind::moving));
    pour_on(plan, {0.75, 0.5, 0.64});
    expect_poured_work_counted(plan);
}

TEST(EnergyCheck, counts_what_poured_soil_does_on_a_chain) {
    WorldPlan plan = bed(0.1);
    ChainPlan chain;
    chain.pose.position = {0.3, 0.5, 0.6};
    chain.link_mass_kg = 10;
    plan.chains.push_back(chain);
    pour_on(plan, {0.3, 0.5, 0.7});
    expect_poured_work_counted(plan);
}

// Random world 940057. Wind blows what hangs under a box up against it, and the box along.
TEST(EnergyCheck, counts_what_wind_does_by_blown_soil) {
    WorldPlan plan = bed(0);
    SoilPlan& soil = plan.soils[0];
    soil.def.materials[0].fall_speed_m_s = 0.2;
    soil.def.wind_m_s = {0, 0, 11};
    soil.fills.push_back({.low_m = {0.3, 0.3, 0.2}, .high_m = {0.7, 0.7, 0.4}});
    plan.bodies.push_back(box_at({0.5, 0.5, 0.6}, {0.1, 0.1, 0.05}, BodyPlan::Kind::moving));
    plan.bodies[0].velocity_m_s = {0, 0, 1};
    expect_poured_work_counted(plan, 12);
}

// A joint between 40 g and 700 kg on the floor below: what it does is nothing to the soil.
TEST(EnergyCheck, leaves_out_joints_of_bodies_that_have_left) {
    for (const double x_m : {0.5, 3.0}) {
        WorldPlan plan = bed(0.3);
        plan.bodies.push_back(box_at({x_m, 0.5, 0.5}, {0.1, 0.1, 0.1}, BodyPlan::Kind::moving));
        plan.bodies.push_back(box_at({3.5, 0.5, 0.5}, {0.1, 0.1, 0.1}, BodyPlan::Kind::moving));
        plan.bodies.push_back(box_at({4.5, 0.5, 0.5}, {0.1, 0.1, 0.1}, BodyPlan::Kind::moving));
        for (const int a : {0, 1}) plan.joints.push_back({.a = a, .b = a + 1});
        BuiltWorld world(plan);
        EXPECT_EQ(parts_at_soil(world).size(), x_m < 1 ? 3u : 0u) << x_m;
        world.body(2)->setAngularVelocity({0, 0, 5});
        for (int i = 0; i < 10; ++i) world.step();
        EXPECT_EQ(world.joint_work_j() != 0, x_m < 1) << x_m;
    }
}

// Across a slope of 25 deg its struts bear nine tenths of its weight, what its wheels grip the
// rest.
TEST(RestCheck, counts_what_the_wheels_of_a_leaning_car_grip) {
    WorldPlan plan = bed(0);
    plan.soils[0].def.size_m = {8, 8, 4};
    plan.soils[0].def.voxel_m = 0.2;
    plan.soils[0].def.materials[0].friction_angle_rad = 0.75;
    plan.soils[0].def.materials[0].tool_friction = 0.8;
    plan.action_steps = 1;  // then it brakes
    CarPlan car;
    car.pose.position = {4, 4, 2.7};
    const double half_rad = std::atan(kAcross) / 2;
    car.pose.rotation = {std::sin(half_rad), 0, 0, std::cos(half_rad)};
    plan.cars.push_back(car);
    BuiltWorld world(plan);
    ASSERT_EQ(world.error(), "");
    const GridFrame& frame = world.soil(0).soil().frame();
    ASSERT_TRUE(world.soil(0).fill(FunctionFill{[&](Vec3 world_m) {
                                                    const Vec3 at_m =
                                                        frame.to_grid(world_m) * frame.voxel_m;
                                                    return 1.5 + kAcross * (at_m.y - 4) - at_m.z;
                                                },
                                                {}}));
    double sum_n = 0;
    for (int i = 0; i < 240; ++i) {
        world.step();
        if (i >= 180) sum_n += dot(soil_force_n(world, *world.cars()[0].chassis), world.up());
    }
    const btVector3 car_up = world.cars()[0].chassis->getWorldTransform().getBasis().getColumn(2);
    EXPECT_LT(car_up.z(), btScalar(0.95));
    EXPECT_NEAR(sum_n / 60 / (car.mass_kg * 9.81), 1, 0.02);
}

/// Two balls on a joint, of very different mass; the heavy one falls.
WorldPlan light_and_heavy() {
    WorldPlan plan = bed(0.5);
    plan.action_steps = 60;
    for (const double mass_kg : {0.004, 2000.0}) {
        BodyPlan body = box_at({0.5, 0.5, mass_kg < 1 ? 0.55 : 2.0}, {0.05, 0.05, 0.05},
                               BodyPlan::Kind::moving);
        body.mass_kg = mass_kg;
        plan.bodies.push_back(body);
    }
    JointPlan joint;
    joint.b = 1;
    plan.joints.push_back(joint);
    return plan;
}

// The cure is asked for where there is a joint, and it is no cure where there were as many before.
TEST(Checks, let_no_energy_in_but_what_more_iterations_keep_out_of_joints) {
    Failure energy;
    energy.invariant = "energy";
    WorldPlan plan = light_and_heavy();
    EXPECT_TRUE(known_fault(plan, energy));
    plan.solver_iterations = 50;
    EXPECT_FALSE(known_fault(plan, energy));
    plan.solver_iterations = 10;
    plan.joints[0].dropped = true;
    EXPECT_FALSE(known_fault(plan, energy));
}

}  // namespace
}  // namespace bsoil::random_worlds::checks_test
