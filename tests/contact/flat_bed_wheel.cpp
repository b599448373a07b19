#include "flat_bed_wheel.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace bsoil::flat_bed {
namespace {

double friction_of(const Law& law, const Wheel& wheel, bool as_cylinder, bool today_smooth) {
    const double phi = radians(wheel.soil.friction_angle_deg);
    // Between lugs the soil shears on itself.
    if (wheel.lug_count > 0 && (law.is_granular || as_cylinder)) return std::tan(phi);
    const bool smooth = law.is_granular ? today_smooth : law.rules.smooth_metal;
    return std::tan(smooth ? 2 * phi / 3 : phi);
}

/// Rim and lugs; one place of the lugs out of three. Made once.
const std::vector<oracle::Facet>& surface_of(const Wheel& wheel, bool as_cylinder, int phase,
                                             double edge_m) {
    static std::map<std::vector<double>, std::vector<oracle::Facet>> made;
    const bool has_lugs = wheel.lug_count > 0 && !as_cylinder;
    const double tip_m = wheel.lug_count > 0 ? wheel.lug_height_m : 0;
    const double r = wheel.radius_m + (as_cylinder ? tip_m : 0);
    std::vector<oracle::Facet>& out = made[{r, wheel.width_m, has_lugs ? wheel.lug_count + 0.0 : 0,
                                            tip_m, wheel.lug_thickness_m, phase + 0.0}];
    if (!out.empty()) return out;
    std::vector<ConvexShape> solids{cylinder(r, wheel.width_m, true)};
    for (int i = 0; i < (has_lugs ? wheel.lug_count : 0); ++i) {
        const double a = 2 * kPi * (i + (phase + 0.5) / 3) / wheel.lug_count;
        const double root = 0.9 * wheel.radius_m, top = wheel.radius_m + tip_m;
        ConvexShape& lug = solids.emplace_back();
        lug.half_extents_m = {wheel.lug_thickness_m / 2, wheel.width_m / 2, (top - root) / 2};
        lug.local.rotation = {0, std::sin(a / 2), 0, std::cos(a / 2)};
        lug.local.position = rotate(lug.local.rotation, {0, 0, (root + top) / 2});
    }
    return out = oracle::surface_of(solids, edge_m);
}

/// Rim and lugs as above, then the surface over the tips; and the row that each facet is of.
struct ToothedSurface {
    std::vector<oracle::Facet> facets;
    std::vector<ToothRow> teeth;
};
const ToothedSurface& toothed_surface_of(const Wheel& wheel, int phase, double edge_m) {
    static std::map<std::vector<double>, ToothedSurface> made;
    ToothedSurface& out = made[{wheel.radius_m, wheel.width_m, wheel.lug_count + 0.0,
                                wheel.lug_height_m, wheel.lug_thickness_m, phase + 0.0}];
    if (!out.facets.empty()) return out;
    const auto add = [&](const oracle::Facet& facet, bool is_over_tips) {
        const double r = std::hypot(facet.at.x, facet.at.z);
        const bool is_disc = std::abs(facet.normal.y) > 0.5 && r <= wheel.radius_m;
        if (is_disc && is_over_tips) return;
        out.facets.push_back(facet);
        const Vec3 spoke = Vec3{facet.at.x, 0, facet.at.z} * (1 / r);
        const double along = std::abs(dot(facet.normal, cross(spoke, {0, 1, 0})));
        const bool is_on_tooth = r > wheel.radius_m + 0.02 * wheel.lug_height_m;
        const bool is_of_row = !is_disc && (is_over_tips || !is_on_tooth || along > 0.7);
        const ToothPart part = is_over_tips  ? ToothPart::over_tips
                               : is_on_tooth ? ToothPart::tooth
                                             : ToothPart::base;
        out.teeth.push_back(is_of_row ? ToothRow{wheel.lug_height_m, wheel.lug_thickness_m,
                                                 2 * kPi * wheel.radius_m / wheel.lug_count,
                                                 r - wheel.radius_m, spoke, part}
                                      : ToothRow{});
    };
    for (const oracle::Facet& facet : surface_of(wheel, false, phase, edge_m)) add(facet, false);
    for (const oracle::Facet& facet : surface_of(wheel, true, phase, edge_m)) add(facet, true);
    return out;
}

oracle::Wrench wheel_at(const Law& law, const Wheel& wheel, double slip, double angle_rad,
                        double sinkage_m, bool as_cylinder, bool today_smooth) {
    const double tip_m = wheel.lug_count > 0 ? wheel.lug_height_m : 0;
    Case c;
    c.soil = wheel.soil;
    c.friction = friction_of(law, wheel, as_cylinder, today_smooth);
    c.radius_m = wheel.radius_m + tip_m;
    c.edge_m = wheel.radius_m / 16;
    // The data's slip is of the speed of travel, at any slip angle.
    const double rim = slip >= 0 ? 1 / (1 - std::min(slip, 0.999)) : 1 + slip;
    const Quat yaw{0, 0, std::sin(angle_rad / 2), std::cos(angle_rad / 2)};
    oracle::Wrench mean;
    const int phases = wheel.lug_count > 0 && !as_cylinder ? 3 : 1;
    for (int phase = 0; phase < phases; ++phase) {
        if (wheel.lug_count > 0 && law.rules.lugs == Rules::Lugs::trapped) {
            const ToothedSurface& surface = toothed_surface_of(wheel, phase, c.edge_m);
            c.surface = &surface.facets;
            c.teeth = &surface.teeth;
        } else {
            c.surface = &surface_of(wheel, as_cylinder, phase, c.edge_m);
        }
        c.motion.pose = {{0, 0, wheel.radius_m - sinkage_m}, yaw};
        c.motion.velocity_m_s = {1, 0, 0};
        c.motion.angular_velocity_rad_s = rotate(yaw, {0, rim / wheel.radius_m, 0});
        const oracle::Wrench found = force_of(law, c, sinkage_m + tip_m);
        mean.force_n += found.force_n * (1.0 / phases);
        mean.moment_n_m += found.moment_n_m * (1.0 / phases);
    }
    return mean;
}

/// Share of the soil between lugs that goes round with the wheel: the passive wedge before a lug
/// over the pitch.
double trapped_share(const Wheel& wheel) {
    const double pitch = 2 * kPi * wheel.radius_m / wheel.lug_count;
    const double wedge =
        wheel.lug_height_m * std::tan(kPi / 4 + radians(wheel.soil.friction_angle_deg) / 2);
    return std::min(1.0, (wedge + wheel.lug_thickness_m) / pitch);
}

}  // namespace

WheelForce wheel_under_load(const Law& law, const Wheel& wheel, double slip, double angle_rad,
                            double load_n, bool today_smooth) {
    const auto at = [&](double sinkage_m) {
        if (wheel.lug_count == 0 || law.rules.lugs == Rules::Lugs::apart ||
            law.rules.lugs == Rules::Lugs::trapped || law.is_granular) {
            return wheel_at(law, wheel, slip, angle_rad, sinkage_m, false, today_smooth);
        }
        oracle::Wrench plug = wheel_at(law, wheel, slip, angle_rad, sinkage_m, true, today_smooth);
        if (law.rules.lugs == Rules::Lugs::cylinder) return plug;
        const double share = trapped_share(wheel);
        const oracle::Wrench apart =
            wheel_at(law, wheel, slip, angle_rad, sinkage_m, false, today_smooth);
        return oracle::Wrench{share * plug.force_n + (1 - share) * apart.force_n,
                              share * plug.moment_n_m + (1 - share) * apart.moment_n_m};
    };
    double low = wheel.lug_count > 0 ? -wheel.lug_height_m : 0, high = 1.1 * wheel.radius_m;
    for (int i = 0; i < 14; ++i) {
        const double middle = (low + high) / 2;
        (at(middle).force_n.z < load_n ? low : high) = middle;
    }
    const oracle::Wrench found = at(high);
    const Vec3 heading{std::cos(angle_rad), std::sin(angle_rad), 0};
    const Vec3 axle{-heading.y, heading.x, 0};
    return {dot(found.force_n, heading), dot(found.force_n, axle), high,
            -dot(found.moment_n_m, axle)};
}

}  // namespace bsoil::flat_bed
