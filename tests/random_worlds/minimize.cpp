#include "minimize.h"

#include <algorithm>

namespace bsoil::random_worlds {
namespace {

bool fails(const WorldPlan& plan, Run run, const std::string& invariant) {
    const std::vector<Failure> failures = run_plan(plan, run);
    return std::any_of(failures.begin(), failures.end(),
                       [&](const Failure& f) { return f.invariant == invariant; });
}

/// Joints and events of a body that is dropped go with it.
void drop_orphans(WorldPlan& plan) {
    const auto is_gone = [&plan](int body) {
        return body >= 0 && body < static_cast<int>(plan.bodies.size()) &&
               plan.bodies[static_cast<size_t>(body)].dropped;
    };
    for (JointPlan& joint : plan.joints) joint.dropped |= is_gone(joint.a) || is_gone(joint.b);
    for (EventPlan& event : plan.events) {
        if (event.kind != EventPlan::Kind::fill && event.kind != EventPlan::Kind::disable &&
            event.kind != EventPlan::Kind::enable) {
            event.dropped |= is_gone(event.body);
        }
    }
}

}  // namespace

WorldPlan minimize(WorldPlan plan, Run run, const std::string& invariant) {
    const auto attempt = [&](const auto& change) {
        WorldPlan smaller = plan;
        change(smaller);
        drop_orphans(smaller);
        if (fails(smaller, run, invariant)) plan = std::move(smaller);
    };
    const auto drop_all_of = [&](auto member) {
        for (size_t i = 0; i < (plan.*member).size(); ++i) {
            if (!(plan.*member)[i].dropped) {
                attempt([&](WorldPlan& p) { (p.*member)[i].dropped = true; });
            }
        }
    };
    const auto drop_weather = [&](size_t s) {
        if (!plan.has_weather) return;
        attempt([&](WorldPlan& p) { p.soils[s].def.rain_m_s = 0; });
        attempt([&](WorldPlan& p) { p.soils[s].def.drying_m_s = 0; });
        attempt([&](WorldPlan& p) { p.soils[s].def.floor_drainage_m_s = 0; });
        attempt([&](WorldPlan& p) { p.soils[s].def.water_table_m = 0; });
        attempt([&](WorldPlan& p) { p.soils[s].def.wind_m_s = {}; });
        attempt([&](WorldPlan& p) { p.soils[s].def.gust = 0; });
        attempt([&](WorldPlan& p) { p.soils[s].def.open_sides = 0; });
        attempt([&](WorldPlan& p) { p.soils[s].def.slides = SlideMotion::settle; });
        attempt([&](WorldPlan& p) { p.soils[s].def.contact_law = {}; });
        for (size_t m = 0; m < plan.soils[s].def.materials.size(); ++m) {
            attempt([&](WorldPlan& p) { p.soils[s].def.materials[m].pore_water_fraction = 0; });
            attempt([&](WorldPlan& p) { p.soils[s].def.materials[m].moist_cohesion_pa = 0; });
            attempt([&](WorldPlan& p) { p.soils[s].def.materials[m].conductivity_m_s = 0; });
            attempt([&](WorldPlan& p) { p.soils[s].def.materials[m].fall_speed_m_s = 0; });
            attempt([&](WorldPlan& p) { p.soils[s].def.materials[m].roughness = 0; });
            attempt([&](WorldPlan& p) { p.soils[s].def.materials[m].viscosity = 0; });
        }
    };
    drop_all_of(&WorldPlan::cars);
    drop_all_of(&WorldPlan::chains);
    drop_all_of(&WorldPlan::events);
    drop_all_of(&WorldPlan::joints);
    drop_all_of(&WorldPlan::bodies);
    for (size_t s = 0; s < plan.soils.size(); ++s) {
        for (size_t i = 0; i < plan.soils[s].flows.size(); ++i) {
            attempt([&](WorldPlan& p) { p.soils[s].flows[i].dropped = true; });
            attempt([&](WorldPlan& p) { p.soils[s].flows[i].moves_step = -1; });
            attempt([&](WorldPlan& p) { p.soils[s].flows[i].ends_step = -1; });
        }
        for (size_t i = 1; i < plan.soils[s].fills.size(); ++i) {
            attempt([&](WorldPlan& p) { p.soils[s].fills[i].dropped = true; });
        }
    }
    attempt([](WorldPlan& p) { p.is_variable = false; });
    attempt([](WorldPlan& p) { p.substep_count = 1; });
    attempt([](WorldPlan& p) { p.frame_s = 1.0 / 60; });
    for (size_t s = 0; s < plan.soils.size(); ++s) {
        attempt([&](WorldPlan& p) { p.soils[s].terrain_m = 0; });
        attempt([&](WorldPlan& p) { p.soils[s].def.yaw_rad = 0; });
        drop_weather(s);
        attempt([&](WorldPlan& p) { p.soils[s].def.floor_center_m = {}; });
        attempt([&](WorldPlan& p) { p.soils[s].def.up = UpAxis::z; });
        attempt([&](WorldPlan& p) { p.soils[s].def.gravity_m_s2 = 9.81; });
        attempt([&](WorldPlan& p) { p.soils[s].def.step_s = 1.0 / 60; });
        attempt([&](WorldPlan& p) { p.soils[s].def.overflow = OverflowHeuristic::up; });
        attempt([&](WorldPlan& p) {
            auto& kinds = p.soils[s].fills[0].kind;
            kinds = FillPlan::Kind::box;
        });
    }
    for (size_t i = 0; i < plan.bodies.size(); ++i) {
        if (plan.bodies[i].dropped) continue;
        attempt([&](WorldPlan& p) { p.bodies[i].spin_rad_s = {}; });
        attempt([&](WorldPlan& p) { p.bodies[i].velocity_m_s = {}; });
        attempt([&](WorldPlan& p) { p.bodies[i].pose.rotation = {}; });
        attempt([&](WorldPlan& p) { p.bodies[i].surface_friction = -1; });
        attempt([&](WorldPlan& p) { p.bodies[i].enters_step = 0; });
        attempt([&](WorldPlan& p) { p.bodies[i].leaves_step = -1; });
        while (plan.bodies[i].shape.kind == ShapePlan::Kind::compound &&
               plan.bodies[i].shape.children.size() > 1) {
            const size_t count = plan.bodies[i].shape.children.size();
            attempt([&](WorldPlan& p) {
                p.bodies[i].shape.children.pop_back();
                p.bodies[i].shape.child_poses.pop_back();
            });
            if (plan.bodies[i].shape.children.size() == count) break;
        }
    }
    return plan;
}

}  // namespace bsoil::random_worlds
