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

/// A chain's links that turn faster than Bullet lets a multibody sleep, by what its ten iterations
/// leave undone, and what it has in their island. Known by its cure: with enough iterations all
/// sleep. World 40222: links of 1 cm turn at up to 0.3 rad/s, 971006: 1.3 cm and 0.5 rad/s; all of
/// them sleep with 20.
constexpr int kEnoughIterations = 50;

bool is_left_undone(const WorldPlan& plan, const Failure&) {
    const bool has_chain = std::any_of(plan.chains.begin(), plan.chains.end(),
                                       [](const ChainPlan& chain) { return !chain.dropped; });
    if (!has_chain || plan.solver_iterations >= kEnoughIterations) return false;
    WorldPlan cured = plan;
    cured.solver_iterations = kEnoughIterations;
    const std::vector<Failure> failures = run_plan(cured, Run::watched);
    return std::none_of(failures.begin(), failures.end(),
                        [](const Failure& f) { return f.invariant == "bodies sleep"; });
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

/// What friction with a body changes a speed by in a step is rounded to 1/1024 voxel a step. World
/// 96001.
bool slides_on_bodies(const WorldPlan& plan, const Failure&) {
    return std::any_of(plan.soils.begin(), plan.soils.end(), [&plan](const SoilPlan& soil) {
        const SoilDef& def = soil.def;
        const double gravity = 1024 * def.gravity_m_s2 * def.step_s * def.step_s / def.voxel_m;
        const auto is_none = [gravity](double friction) {
            return friction > 0 && friction * gravity < 0.5;
        };
        return std::any_of(def.materials.begin(), def.materials.end(),
                           [&](const MaterialDef& m) { return is_none(m.tool_friction); }) ||
               std::any_of(plan.bodies.begin(), plan.bodies.end(), [&](const BodyPlan& body) {
                   return body.surface_friction >= 0 && is_none(body.surface_friction);
               });
    });
}

/// Entries go when the fault does.
constexpr KnownFault kKnownFaults[] = {
    {"sinkage", is_of_small_body, "bodies of a few voxels sink deeper than plates of their size"},
    {"soil sleeps", is_kept_in_the_air, "wind rises faster than the soil falls"},
    {"soil sleeps", slides_on_bodies, "friction with bodies is rounded to none in small steps"},
    {"soil sleeps", is_viscous, "soil of a viscosity above 3/4 takes more than the time given"},
    {"bodies sleep", has_small_body,
     "bodies of a few voxels rock and keep what lies beside them awake"},
    {"bodies sleep", is_left_undone,
     "what Bullet's ten iterations leave undone turns a chain's links faster than it lets them "
     "sleep"},
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
