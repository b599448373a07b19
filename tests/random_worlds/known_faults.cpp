#include "known_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "run_plan.h"

namespace bsoil::random_worlds {
namespace {

struct KnownFault {
    std::string_view invariant;
    bool (*applies)(const WorldPlan& plan, const Failure& failure);
    const char* reason;
};

/// Bodies whose bound is of fewer voxels touch soil in a few, which carry them at points.
constexpr double kFewVoxels = 4;
/// Of soil of this viscosity a slide takes four times as long as of any other. Others have come to
/// rest after a quarter of the time that worlds are given.
constexpr double kViscous = 0.75;

bool is_small(const WorldPlan& plan, const BodyPlan& body) {
    return bound_m(body.shape) <
           kFewVoxels * plan.soils[static_cast<size_t>(body.soil)].def.voxel_m;
}

bool is_of_small_body(const WorldPlan& plan, const Failure& failure) {
    for (size_t i = 0; i < plan.bodies.size(); ++i) {
        const bool is_it =
            failure.body == fmt::format("body {} ({})", i, name_of(plan.bodies[i].shape.kind));
        if (is_it) return is_small(plan, plan.bodies[i]);
    }
    return false;
}

bool has_small_body(const WorldPlan& plan, const Failure&) {
    return std::any_of(plan.bodies.begin(), plan.bodies.end(), [&plan](const BodyPlan& body) {
        return !body.dropped && body.kind == BodyPlan::Kind::moving && is_small(plan, body);
    });
}

/// What is known by its cure: that it fails no more.
bool holds(const WorldPlan& cured, const Failure& failure) {
    const std::vector<Failure> failures = run_plan(cured, Run::watched);
    return std::none_of(failures.begin(), failures.end(),
                        [&failure](const Failure& f) { return f.invariant == failure.invariant; });
}

/// What Bullet's ten iterations leave undone: with enough of them it holds.
constexpr int kEnoughIterations = 50;

bool holds_with_more_iterations(const WorldPlan& plan, const Failure& failure) {
    if (plan.solver_iterations >= kEnoughIterations) return false;
    WorldPlan cured = plan;
    cured.solver_iterations = kEnoughIterations;
    return holds(cured, failure);
}

/// A chain's links that turn faster than Bullet lets a multibody sleep, and what it has in their
/// island. World 40222: links of 1 cm turn at up to 0.3 rad/s, 971006: 1.3 cm and 0.5 rad/s; all of
/// them sleep with 20.
bool is_rocking_chain(const WorldPlan& plan, const Failure& failure) {
    return std::any_of(plan.chains.begin(), plan.chains.end(),
                       [](const ChainPlan& chain) { return !chain.dropped; }) &&
           holds_with_more_iterations(plan, failure);
}

/// Soil bore 2.3 % more than the chain of world 3001034 weighs, and with 20 iterations what it
/// does.
bool is_badly_weighed_chain(const WorldPlan& plan, const Failure& failure) {
    return failure.body.starts_with("chain") && holds_with_more_iterations(plan, failure);
}

/// A joint and a contact that pull a light body apart. World 971272: 4 g on the ground, and 7 m
/// away 1.7 t that fall. Joint and soil throw the light one to and fro at up to 10 km/s, by
/// impulses whose works, 100 kJ each, nearly cancel; the check has the joint's alone.
bool is_torn_at(const WorldPlan& plan, const Failure& failure) {
    return std::any_of(plan.joints.begin(), plan.joints.end(),
                       [](const JointPlan& joint) { return !joint.dropped; }) &&
           holds_with_more_iterations(plan, failure);
}

/// A body that comes down on a corner meets soil where it lay at the soil's last step, which is a
/// small part of what has come into it by the next one. World 3001165: a wedge at 1.5 m/s went 5
/// voxels in a step of 1/30 s, and lay 40 mm deep. In 1/60 s it lies 23 mm deep, in less 14.
constexpr int kShorterSteps = 4;

bool holds_in_shorter_steps(const WorldPlan& plan, const Failure& failure) {
    const bool is_long = std::any_of(plan.soils.begin(), plan.soils.end(), [](const SoilPlan& s) {
        return s.def.step_s > SoilDef{}.step_s;
    });
    if (!is_long) return false;
    WorldPlan cured = plan;
    cured.substep_count *= kShorterSteps;
    for (SoilPlan& soil : cured.soils) soil.def.step_s /= kShorterSteps;
    return holds(cured, failure);
}

/// Wind that rises faster than soil falls carries it up to the grid's end, where it stays.
bool is_kept_in_the_air(const WorldPlan& plan, const Failure&) {
    return std::any_of(plan.soils.begin(), plan.soils.end(), [](const SoilPlan& soil) {
        return std::any_of(soil.def.materials.begin(), soil.def.materials.end(),
                           [&soil](const MaterialDef& m) { return is_held_by_wind(soil.def, m); });
    });
}

bool is_viscous(const WorldPlan& plan, const Failure&) {
    return std::any_of(plan.soils.begin(), plan.soils.end(), [](const SoilPlan& soil) {
        return std::any_of(soil.def.materials.begin(), soil.def.materials.end(),
                           [](const MaterialDef& m) { return m.viscosity > kViscous; });
    });
}

/// Entries go when the fault does.
constexpr KnownFault kKnownFaults[] = {
    {"sinkage", is_of_small_body, "bodies of a few voxels sink deeper than plates of their size"},
    {"sinkage", holds_in_shorter_steps,
     "a body that comes down on a corner is met late in steps of the soil longer than 1/60 s"},
    {"soil sleeps", is_kept_in_the_air, "wind rises faster than the soil falls"},
    {"soil sleeps", is_viscous, "soil of a viscosity above 3/4 takes more than the time given"},
    {"bodies sleep", has_small_body,
     "bodies of a few voxels rock and keep what lies beside them awake"},
    {"energy", is_torn_at,
     "what Bullet's ten iterations leave undone throws a light body between a joint and a contact"},
    {"bodies sleep", is_rocking_chain,
     "what Bullet's ten iterations leave undone turns a chain's links faster than it lets them "
     "sleep"},
    {"weight", is_badly_weighed_chain, "what Bullet's ten iterations leave undone bears a chain"},
};

}  // namespace

const char* known_fault(const WorldPlan& plan, const Failure& failure) {
    for (const KnownFault& fault : kKnownFaults) {
        if (fault.invariant == failure.invariant && fault.applies(plan, failure)) {
            return fault.reason;
        }
    }
    return nullptr;
}

}  // namespace bsoil::random_worlds
