#include "world_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bsoil::random_worlds {

namespace {
using Kind = ShapePlan::Kind;
/// Soil falls at least so many times as fast as wind rises, or it is as good as held up. In world
/// 9000054, at 1.15 times, wind presses a heap into a corner below the grid's end, which crumbles
/// from below by a hundredth in 10 s. It was 1.1 until then.
constexpr double kNearlyHeld = 1.25;
}  // namespace

double bound_m(const ShapePlan& shape) {
    const Vec3 h = shape.half_m;
    double bound = 0;
    switch (shape.kind) {
        case Kind::box:
        case Kind::cylinder:
            return shape.kind == Kind::box ? length(h) : std::hypot(h.x, h.z);
        case Kind::cone:
            return std::hypot(h.x, h.z);
        case Kind::sphere:
            return h.x;
        case Kind::capsule:
            return h.x + h.z;
        case Kind::plane:
        case Kind::heightfield:
            return std::numeric_limits<double>::infinity();
        case Kind::scaled:
            return h.x * bound_m(shape.children[0]);
        case Kind::minkowski_sum:
            return bound_m(shape.children[0]) + bound_m(shape.children[1]);
        case Kind::compound:
            for (size_t i = 0; i < shape.children.size(); ++i) {
                bound = std::max(
                    bound, length(shape.child_poses[i].position) + bound_m(shape.children[i]));
            }
            return bound;
        case Kind::multi_sphere:
            for (size_t i = 0; i < shape.points_m.size(); ++i) {
                bound = std::max(bound, length(shape.points_m[i]) + shape.numbers_m[i]);
            }
            return bound;
        default:
            for (const Vec3 p : shape.points_m) bound = std::max(bound, length(p));
            return bound + shape.margin_m;
    }
}

ShapePlan box_plan(Vec3 half_m) {
    ShapePlan shape;
    shape.half_m = half_m;
    return shape;
}

const char* name_of(ShapePlan::Kind kind) {
    constexpr const char* kNames[] = {"box",
                                      "sphere",
                                      "capsule",
                                      "cylinder",
                                      "cone",
                                      "hull",
                                      "point cloud",
                                      "spheres",
                                      "scaled",
                                      "minkowski sum",
                                      "compound",
                                      "triangle mesh",
                                      "scaled triangle mesh",
                                      "open mesh",
                                      "moving mesh",
                                      "triangle",
                                      "heightfield",
                                      "plane",
                                      "none"};
    return kNames[static_cast<int>(kind)];
}

bool is_round(const ShapePlan& shape) {
    switch (shape.kind) {
        case Kind::sphere:
        case Kind::capsule:
        case Kind::cylinder:
        case Kind::cone:
        case Kind::multi_sphere:
            return true;
        default:
            return std::any_of(shape.children.begin(), shape.children.end(), is_round);
    }
}

bool has_motors(const WorldPlan& plan) {
    // What only covers is moved by gravity and joints, and moves soil as a driven body does: in
    // world 11003074 one of 4 g at 5 m/s throws a box of 1.4 kg, with the 3 kg of soil between.
    const auto driven = [](const BodyPlan& b) {
        return !b.dropped && (b.kind == BodyPlan::Kind::driven || b.is_coverage_only);
    };
    return std::any_of(plan.bodies.begin(), plan.bodies.end(), driven) ||
           std::any_of(plan.joints.begin(), plan.joints.end(),
                       [](const JointPlan& j) { return !j.dropped && j.motor_most > 0; }) ||
           std::any_of(plan.cars.begin(), plan.cars.end(),
                       [](const CarPlan& c) { return !c.dropped; }) ||
           std::any_of(plan.chains.begin(), plan.chains.end(),
                       [](const ChainPlan& c) { return !c.dropped && c.motor_most > 0; });
}

double rising_wind_m_s(const SoilDef& def) {
    return std::max(0.0, def.up == UpAxis::y ? def.wind_m_s.y : def.wind_m_s.z) * (1 + def.gust);
}

bool is_held_by_wind(const SoilDef& def, const MaterialDef& material) {
    return material.fall_speed_m_s > 0 &&
           material.fall_speed_m_s < kNearlyHeld * rising_wind_m_s(def);
}

namespace {

std::string text(Vec3 v) { return fmt::format("({:.6g} {:.6g} {:.6g})", v.x, v.y, v.z); }
std::string text(Quat q) {
    return fmt::format("[{:.6g} {:.6g} {:.6g} {:.6g}]", q.x, q.y, q.z, q.w);
}
std::string text(const ShapePlan& s) {
    std::string out = fmt::format("{} axis {} half {} margin {:.4g}", name_of(s.kind), s.axis,
                                  text(s.half_m), s.margin_m);
    for (const Vec3 p : s.points_m) out += ' ' + text(p);
    for (const double n : s.numbers_m) out += fmt::format(" {:.4g}", n);
    for (size_t i = 0; i < s.children.size(); ++i) {
        out += fmt::format("\n        child at {} {}: {}", text(s.child_poses[i].position),
                           text(s.child_poses[i].rotation), text(s.children[i]));
    }
    return out;
}

std::string text(const MaterialDef& m) {
    return fmt::format(
        "    {}: {:.4g} ({:.4g}..{:.4g}) kg/m3, phi {:.3g}, cohesion {:.4g} x {:.2g}, rough "
        "{:.3g}, "
        "viscous {:.3g}, pores {:.3g} at {:.3g}, moist {:.4g} Pa, {:.3g} m/s, residual {:.2g}, "
        "falls {:.3g} m/s\n",
        m.name, m.density_kg_m3, m.loose_density_kg_m3, m.compacted_density_kg_m3,
        m.friction_angle_rad, m.cohesion_pa, m.loose_cohesion_fraction, m.roughness, m.viscosity,
        m.pore_water_fraction, m.placed_saturation, m.moist_cohesion_pa, m.conductivity_m_s,
        m.residual_saturation, m.fall_speed_m_s);
}
std::string text(const FlowPlan& f) {
    const SourceDef& from = f.source;
    const SinkDef& to = f.sink;
    const std::string what =
        f.is_source
            ? fmt::format(
                  "source of {} at {} along {}, {} of {:.4g} {:.4g} {:.4g} m, {:.4g} m/s "
                  "spread {:.3g}, {:.4g} kg/s or {:.4g} m3/s, {:.4g}..{:.4g} s",
                  from.material, text(from.center_m), text(from.direction),
                  from.shape == SourceDef::Shape::disc ? "disc" : "rectangle", from.radius_m,
                  from.length_m, from.width_m, from.speed_m_s, from.spread_rad, from.rate_kg_s,
                  from.rate_m3_s, from.start_s, from.end_s)
            : fmt::format(
                  "sink {} of {} {:.4g} {:.4g} m at {} {}, {:.4g} kg/s, water {:.4g} kg/s, "
                  "{:.4g}..{:.4g} s",
                  static_cast<int>(to.region.kind), text(to.region.half_extents_m),
                  to.region.radius_m, to.region.half_height_m, text(to.pose.position),
                  text(to.pose.rotation), to.rate_kg_s, to.water_kg_s, to.start_s, to.end_s);
    return fmt::format("    {}, to {} at step {}, gone at step {}\n", what, text(f.moved_to_m),
                       f.moves_step, f.ends_step);
}
std::string text_of_weather(const SoilPlan& s) {
    const SoilDef& d = s.def;
    std::string out = fmt::format(
        "    law {}{}{}, open sides {}, slides {}, rain {:.3g}, drying {:.3g}, drainage {:.3g} "
        "m/s, groundwater {:.3g} m, wind {} m/s, gusts {:.2g} of {:.3g} m, shelter {:.3g} m\n",
        static_cast<int>(d.contact_law.kind), d.contact_law.passive_wedge ? ", wedge" : "",
        d.contact_law.trapped_soil ? ", trapped soil" : "", d.open_sides,
        static_cast<int>(d.slides), d.rain_m_s, d.drying_m_s, d.floor_drainage_m_s, d.water_table_m,
        text(d.wind_m_s), d.gust, d.gust_size_m, d.shelter_m);
    for (const MaterialDef& m : d.materials) out += text(m);
    for (const FlowPlan& f : s.flows) {
        if (!f.dropped) out += text(f);
    }
    return out;
}

}  // namespace

std::string describe(const WorldPlan& plan) {
    std::string out = fmt::format("seed {}: {} action steps of {:.6g} s{} in {} substeps\n",
                                  plan.seed, plan.action_steps, plan.frame_s,
                                  plan.is_variable ? " and shorter" : "", plan.substep_count);
    for (size_t i = 0; i < plan.soils.size(); ++i) {
        const SoilPlan& s = plan.soils[i];
        const SoilDef& d = s.def;
        out += fmt::format(
            "  soil {}: size {} m, voxel {:.6g} m = {:.0f} x {:.0f} x {:.0f}, up {}, yaw {:.4g}, "
            "floor {}, gravity {}, step 1/{:.0f} s, overflow {}, terrain {:.4g} m slope {:.4g}\n",
            i, text(d.size_m), d.voxel_m, d.size_m.x / d.voxel_m, d.size_m.y / d.voxel_m,
            d.size_m.z / d.voxel_m, d.up == UpAxis::y ? 'y' : 'z', d.yaw_rad,
            text(d.floor_center_m), d.gravity_m_s2, 1 / d.step_s, static_cast<int>(d.overflow),
            s.terrain_m, s.terrain_slope);
        if (plan.has_weather) out += text_of_weather(s);
        for (const FillPlan& f : s.fills) {
            if (!f.dropped) {
                out += fmt::format("    fill {} of {} from {} to {}{}\n", static_cast<int>(f.kind),
                                   d.materials[static_cast<size_t>(f.material)].name, text(f.low_m),
                                   text(f.high_m), f.is_hanging ? ", hanging" : "");
            }
        }
    }
    for (size_t i = 0; i < plan.bodies.size(); ++i) {
        const BodyPlan& b = plan.bodies[i];
        if (b.dropped) continue;
        out += fmt::format(
            "  body {}: {}, soil {}, {:.6g} kg, at {} {}, velocity {}, spin {}, friction {:.3g}{}{}"
            ", surface {:.3g}, steps {}..{}\n      {}\n",
            i,
            b.kind == BodyPlan::Kind::moving  ? "moving"
            : b.kind == BodyPlan::Kind::fixed ? "fixed"
                                              : "driven",
            b.soil, b.mass_kg, text(b.pose.position), text(b.pose.rotation), text(b.velocity_m_s),
            text(b.spin_rad_s), b.friction, b.is_ignored ? ", ignored" : "",
            b.is_coverage_only ? ", coverage only" : "", b.surface_friction, b.enters_step,
            b.leaves_step, text(b.shape));
    }
    for (const JointPlan& j : plan.joints) {
        if (!j.dropped) {
            out += fmt::format("  joint {}: bodies {} and {}, axis {}, motor {:.4g} up to {:.4g}\n",
                               static_cast<int>(j.kind), j.a, j.b, text(j.axis), j.motor_speed,
                               j.motor_most);
        }
    }
    for (const CarPlan& c : plan.cars) {
        if (!c.dropped) {
            out += fmt::format(
                "  car: soil {}, {:.6g} kg, wheels of {:.4g} m, {:.4g} m wide, at {} {}, engine "
                "{:.4g} N, steering {:.3g}\n",
                c.soil, c.mass_kg, c.radius_m, c.width_m, text(c.pose.position),
                text(c.pose.rotation), c.engine_n, c.steering_rad);
        }
    }
    for (const ChainPlan& c : plan.chains) {
        if (!c.dropped) {
            out += fmt::format(
                "  chain: soil {}, {} links of {:.4g} m and {:.4g} kg{}, at {}, motor {:.4g} up to "
                "{:.4g}\n",
                c.soil, c.link_count, c.half_m, c.link_mass_kg,
                c.has_fixed_base ? ", fixed base" : "", text(c.pose.position), c.motor_speed,
                c.motor_most);
        }
    }
    for (const EventPlan& e : plan.events) {
        if (!e.dropped) {
            out += fmt::format("  event {} at step {}: {} {}\n", static_cast<int>(e.kind), e.step,
                               e.body, text(e.vector));
        }
    }
    return out;
}

}  // namespace bsoil::random_worlds
