#include "bsoil/contact/granular_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "bsoil/contact/load_side.h"
#include "bsoil/contact/momentum_flux.h"
#include "bsoil/contact/orientation.h"
#include "bsoil/contact/passive_wedge.h"
#include "bsoil/contact/resistive_force_theory.h"
#include "bsoil/contact/soil_flow.h"
#include "bsoil/contact/trapped_soil.h"

namespace bsoil {

double bearing_capacity_factor_nc(double friction_angle_rad) {
    const double tan_phi = std::tan(friction_angle_rad);
    // The quotient loses its digits near phi = 0, where it tends to 2 + pi.
    if (tan_phi < 1e-4) return 2 + std::numbers::pi;
    const double t = std::tan(std::numbers::pi / 4 + friction_angle_rad / 2);
    return (std::exp(std::numbers::pi * tan_phi) * t * t - 1) / tan_phi;
}

namespace {

/// Stress over xi depth that counts as none. Ours: for the rounding; the least of resistive force
/// theory is a hundredth. Larger: faces that push hardly anything lose their bound.
constexpr double kSmallestStress = 1e-9;
/// Friction of a surface so rough that it bounds nothing. Ours: ten times what any soil slides on
/// itself with. Smaller than tan phi it would cap the stress that is asked for.
constexpr double kRoughFriction = 10;

// With as few functions as it takes: it is asked for every sole, each step. Nq = 1 + tan phi Nc is
// Reissner's exp(pi tan phi) tan(45 deg + phi / 2)^2.
BearingFactors bearing_factors(double friction_angle_rad) {
    constexpr double kPi = std::numbers::pi;
    const double sine = std::sin(friction_angle_rad);
    const double tan_phi = sine / std::sqrt(1 - sine * sine);
    const double nq = std::exp(kPi * tan_phi) * (1 + sine) / (1 - sine);
    const double ngamma =
        tan_phi > 0
            ? std::exp((kPi + 3 * kPi * kPi * tan_phi) / 6 + 2 * kPi / 5 * std::log(tan_phi))
            : 0;
    return {friction_angle_rad, tan_phi, sine, nq, ngamma};
}

// Lyamin and others (2007): sgamma of a square on soil of one angle, 0.0336 a degree. A larger one
// makes square soles on dense soil stronger.
constexpr double kSquareWidthTerm = 0.0336 * 180 / std::numbers::pi;

/// Ngamma's factor of a sole of this width over length.
double width_term_share(double friction_angle_rad, double slimness) {
    return 1 + slimness * (kSquareWidthTerm * friction_angle_rad - 1);
}

}  // namespace

namespace {

/// Bolton (1986), The strength and dilatancy of sands: phi = critical + `angle` I, I = D (Q - ln p)
/// - R within 0 to 4, p in kPa.
struct Dilatancy {
    // Bolton (1986), quartz. A larger Q is of grains that crush later: dense soil keeps its angle
    // under more stress. A larger most lets dense soil under little stress be stronger.
    static constexpr double kCrushing = 10, kOffset = 1, kMost = 4;
    // Bolton (1986), radians a unit of I; larger ones make dense soil stronger.
    static constexpr double kPlaneStrain = 5 * std::numbers::pi / 180;
    static constexpr double kTriaxial = 3 * std::numbers::pi / 180;

    double density = 0, angle = 0;

    /// Meyerhof (1963): the angle under a footing lies between those of a strip and of a square
    /// one, linear in width over length.
    Dilatancy(double relative_density, double slimness)
        : density(relative_density), angle(kPlaneStrain + slimness * (kTriaxial - kPlaneStrain)) {}

    double unbounded(double mean_stress_pa) const {
        const double stress_kpa = std::max(1e-3, mean_stress_pa / 1e3);
        return density * (kCrushing - std::log(stress_kpa)) - kOffset;
    }
};

}  // namespace

double peak_friction_angle(double critical_rad, double relative_density, double mean_stress_pa,
                           double slimness) {
    const Dilatancy dilatancy(relative_density, slimness);
    return critical_rad +
           dilatancy.angle * std::clamp(dilatancy.unbounded(mean_stress_pa), 0.0, Dilatancy::kMost);
}

double developed_shear(const SoilStrength& soil, double displacement_m, double relative_density,
                       const ContactLawDef& law) {
    if (!(soil.shear_displacement_m > 0)) return 1;
    const auto stiffening = [&law](double density) {
        return 1 - (1 - law.dense_shear_share) * density;
    };
    const double k_m = soil.shear_displacement_m * stiffening(relative_density) /
                       stiffening(soil.placed_relative_density);
    return -std::expm1(-displacement_m / k_m);
}

double slip_band_share(double approach, double sliding, const ContactLawDef& law) {
    const double into = std::max(0.0, approach), band = law.slip_band_slope * sliding;
    return sliding > 0 ? band * band / (band * band + into * into) : 1;
}

SoilStrength strength_of(const MaterialDef& material, double gravity_m_s2,
                         const SurfaceFriction& surface, const ContactLawDef& law) {
    const double phi = material.friction_angle_rad;
    const double tan_phi = std::tan(phi);
    SoilStrength out;
    out.stiffness_pa_m = resistive_stiffness_pa_m(material.density_kg_m3, gravity_m_s2, tan_phi);
    out.friction_angle_rad = phi;
    out.tan_phi = tan_phi;
    out.bearing = bearing_factors(phi);
    out.density_kg_m3 = material.density_kg_m3;
    out.friction =
        std::min(surface.friction >= 0 ? surface.friction : material.tool_friction, tan_phi);
    out.adhesion_pa =
        std::min(surface.adhesion_pa >= 0 ? surface.adhesion_pa : material.tool_adhesion_pa,
                 material.cohesion_pa);
    out.cohesion_pa = material.cohesion_pa;
    out.weight_n_m3 = material.density_kg_m3 * gravity_m_s2;
    const double wall_rad = std::atan(out.friction);
    out.passive_factor = law.passive_wedge ? log_spiral_passive_factor(phi, wall_rad)
                                           : passive_pressure_factor(phi, wall_rad);
    out.wedge_width_growth = passive_width_growth(out.passive_factor, phi);
    if (law.passive_wedge) out.wedge_normal_share = std::cos(wall_rad);
    out.wedge_sides =
        2.0 / 3 * (1 - std::sin(phi)) * std::sin(phi) / std::sin(std::numbers::pi / 4 + phi / 2);
    out.cohesion_sole_pa = material.cohesion_pa * bearing_capacity_factor_nc(phi);
    out.cohesion_wall_pa = 2 * material.cohesion_pa * std::tan(std::numbers::pi / 4 + phi / 2);
    const Vec3 up{0, 0, 1}, down{0, 0, -1}, level{1, 0, 0};
    out.sole_stress = -dot(resistive_stress(down, down, up, out.friction), down);
    out.wall_stress = -dot(resistive_stress(level, level, up, out.friction), level);
    out.flow_slope = flow_slope(phi);
    const Vec3 slid = resistive_stress(down, Vec3{1, 0, -law.creep}, up, kRoughFriction);
    out.sliding_share =
        tan_phi / (length(slid - dot(slid, down) * down) / length(dot(slid, down) * down));
    out.shear_displacement_m = material.shear_displacement_m;
    if (material.has_density_range()) {
        out.placed_relative_density = material.relative_density(material.density_kg_m3);
    }
    return out;
}

namespace {

/// Cohesive part of the normal stress: a sole pushed down meets Prandtl's c Nc, a wall pushed
/// sideways lifts a Rankine wedge; in between the two are mixed by the squares of the normal's
/// parts. A face that looks up lifts soil as a wall does. down: of the normal, 0..1; developed:
/// share of a sole's bearing that its sinkage has mobilized.
double cohesive_stress_pa(double down, double developed, const SoilStrength& soil) {
    const SoleAndWall parts = bearing_parts(down);
    return parts.sole * developed * soil.cohesion_sole_pa + parts.wall * soil.cohesion_wall_pa;
}

}  // namespace

double slimness_of(const FaceExtent& face) {
    return face.length_m > 0 ? face.width_m / face.length_m : 1;
}

double developed_bearing(const FaceExtent& face, double depth_m, const ContactLawDef& law) {
    const double developing_m =
        (law.mobilization_widths - law.mobilization_fall_widths * face.relative_density) *
        face.width_m;
    return depth_m < developing_m ? depth_m / developing_m : 1;
}

namespace {

/// Bearing pressure of a sole, in full.
double bearing_pressure_pa(const SoilStrength& soil, const FaceExtent& face, double depth_m,
                           const BearingFactors& factors) {
    const double slimness = slimness_of(face);
    return soil.weight_n_m3 * (depth_m * factors.nq * (1 + slimness * factors.tan_phi) +
                               0.5 * face.width_m * factors.ngamma *
                                   width_term_share(factors.friction_angle_rad, slimness));
}

/// About d ln p / d phi of the mean stress at failure: of sgamma Ngamma (1 - sin phi), most of it.
double stress_slope(const BearingFactors& factors, double slimness) {
    constexpr double kPi = std::numbers::pi;
    const double cos_phi = std::sqrt(1 - factors.sin_phi * factors.sin_phi);
    const double of_tangent = factors.tan_phi > 0 ? 2 * kPi / (5 * factors.tan_phi) : 0;
    return (kPi * kPi / 2 + of_tangent) / (cos_phi * cos_phi) +
           slimness * kSquareWidthTerm / width_term_share(factors.friction_angle_rad, slimness) -
           cos_phi / (1 - factors.sin_phi);
}

/// The friction angle falls with the mean stress at failure (De Beer's), which rises with it. By
/// Newton's method from the critical angle: three rounds leave 0.5 deg at most and 0.007 in the
/// mean. Putting one into the other in turn swings about the angle that is sought, by 8 deg in
/// dense soil.
BearingFactors dense_bearing_factors(const SoilStrength& soil, const FaceExtent& face,
                                     double depth_m) {
    const double slimness = slimness_of(face);
    const Dilatancy dilatancy(face.relative_density, slimness);
    const double critical = soil.friction_angle_rad;
    BearingFactors factors = soil.bearing;
    for (int round = 0; round < 3; ++round) {
        const double mean_pa =
            (bearing_pressure_pa(soil, face, depth_m, factors) + 3 * soil.weight_n_m3 * depth_m) /
            4 * (1 - factors.sin_phi);
        const double phi = factors.friction_angle_rad;
        const double wanted = critical + dilatancy.angle * dilatancy.unbounded(mean_pa);
        const double slope =
            1 + dilatancy.angle * dilatancy.density * stress_slope(factors, slimness);
        const double next = std::clamp(phi + (wanted - phi) / slope, critical,
                                       critical + dilatancy.angle * Dilatancy::kMost);
        if (next == phi) break;  // further rounds find it again
        factors = bearing_factors(next);
    }
    return factors;
}

/// xi times depth of an element that looks up. Where it pushes level it meets no more than the
/// wedge on a wall that leans as it does, and no more in whatever direction it goes.
double leaning_stress_pa(const SoilStrength& soil, const FaceFactors& factors, Vec3 normal, Vec3 up,
                         double depth_m, double resistive_normal) {
    const double resistive_pa = soil.stiffness_pa_m * depth_m;
    const double look_up = dot(normal, up);
    const double wedge_pa =
        factors.wedge_pa * leaning_wedge_share(soil.tan_phi, soil.friction, look_up);
    const Vec3 level = normal - look_up * up;
    const double size = length(level);
    double out = resistive_pa;
    if (size > 0) {
        const double pushed =
            -dot(resistive_stress(normal, level * (1 / size), up, soil.friction), normal);
        out = std::min(out, wedge_pa / std::max(pushed, kSmallestStress));
    }
    // An upright element knows no such bound in other directions: it comes in as it leans.
    const double most_pa = wedge_pa * std::max(1.0, kLeaningSine / look_up);
    return std::min(out, most_pa / std::max(resistive_normal, kSmallestStress));
}

}  // namespace

FaceFactors face_factors(const SoilStrength& soil, const FaceExtent& face, double depth_m,
                         const ContactLawDef& law, bool is_sole_asked) {
    if (!(face.width_m > 0) || !(depth_m > 0)) return {};
    const double bearing_pa =
        is_sole_asked
            ? bearing_pressure_pa(soil, face, depth_m, dense_bearing_factors(soil, face, depth_m))
            : 0;
    const double developed = developed_bearing(face, depth_m, law);
    const double resistive_pa = soil.stiffness_pa_m * depth_m;
    // Without friction there is no frictional stress to change.
    if (!(resistive_pa * soil.sole_stress > 0)) return {.developed = developed};
    const double sole = developed * bearing_pa / (resistive_pa * soil.sole_stress);
    const double spread =
        law.passive_wedge ? passive_width_factor(soil.wedge_width_growth, face.width_m, face.foot_m)
                          : 1 + soil.wedge_sides * face.depth_m / face.width_m;
    const double wedge_pa =
        soil.weight_n_m3 * depth_m * soil.passive_factor * soil.wedge_normal_share * spread;
    return {std::max(1.0, sole),
            wedge_pa < resistive_pa * soil.wall_stress
                ? wedge_pa / (resistive_pa * soil.wall_stress)
                : 1.0,
            developed, wedge_pa};
}

SoilStrength moistened(const SoilStrength& dry, const MaterialDef& material, double saturation) {
    SoilStrength out = dry;
    const double heavier = material.wet_mass_share(saturation);
    out.stiffness_pa_m *= heavier;
    out.density_kg_m3 *= heavier;
    out.weight_n_m3 *= heavier;
    const double cohesion_pa = material.moisture_cohesion_pa(saturation);
    const double phi = material.friction_angle_rad;
    out.cohesion_sole_pa += cohesion_pa * bearing_capacity_factor_nc(phi);
    out.cohesion_wall_pa += 2 * cohesion_pa * std::tan(std::numbers::pi / 4 + phi / 2);
    return out;
}

double cohesion_share(const MaterialDef& material, const ContactVoxel& contact) {
    const double water_pa = material.moisture_cohesion_pa(contact.saturation);
    const double whole_pa = material.cohesion_pa + water_pa;
    if (!(whole_pa > 0)) return 1;
    const double moved_pa = material.moved_cohesion_pa(std::max(0.0, contact.relative_density)) +
                            material.loose_cohesion_fraction * water_pa;
    return std::lerp(moved_pa / whole_pa, 1.0, contact.undisturbed);
}

GranularLaw::GranularLaw(std::shared_ptr<const ContactSoil> soil, const SurfaceFriction& surface)
    : ContactLaw(std::move(soil)) {
    for (const MaterialDef& material : this->soil().materials) {
        const double gravity_m_s2 = this->soil().gravity_m_s2;
        strengths_.push_back(strength_of(material, gravity_m_s2, surface, def()));
        if (!def().trapped_soil) continue;
        const SurfaceFriction soil_on_soil{std::tan(material.friction_angle_rad),
                                           material.cohesion_pa};
        trapped_strengths_.push_back(strength_of(material, gravity_m_s2, soil_on_soil, def()));
    }
}

GranularLaw::GranularLaw(std::shared_ptr<const ContactSoil> soil,
                         std::vector<SoilStrength> strengths)
    : ContactLaw(std::move(soil)), strengths_(std::move(strengths)) {}

namespace {

/// How an element that moves rubs against its soil.
struct Rubbing {
    Vec3 slide;           ///< ElementYield::slide
    double share = 0;     ///< of its shear strength that acts
    double upward = 0;    ///< share of the sliding that drags soil towards the free surface
    double friction = 0;  ///< shear over normal stress
};

/// resistive: stress of resistive force theory over xi depth; shear: developed_shear().
Rubbing rubbing_of(Vec3 n, Vec3 motion, Vec3 resistive, double shear, const SoilStrength& soil,
                   const ContactLaw& law) {
    const double approach = dot(motion, n), creep = law.def().creep;
    const Vec3 slide = motion - approach * n;
    const Vec3 past = slide_past_flow(slide, approach, n, law.up(), soil.flow_slope);
    const double sliding = length(slide), rubs = length(past);
    const double slid = sliding / (sliding + creep), rubbed = rubs / (rubs + creep);
    Rubbing out;
    out.share = 1 - slid + rubbed;
    if (rubs > 0) out.slide = past * (rubbed / rubs);
    // What hardly rubs or hardly pushes drags nothing, or rounding would decide.
    if (approach > 0) {
        out.upward = rubbed * approach / (approach + creep) * upward_share(past, n, law.up());
    }
    // Sticking, the contact can carry all its friction. Sliding, it has Coulomb's where it drags
    // soil up, else what resistive force theory finds along the surface.
    const double pressed = std::max(0.0, -dot(resistive, n));
    const double sheared = length(resistive + pressed * n);
    const double scale =
        1 + (soil.sliding_share - 1) * slip_band_share(approach, sliding, law.def());
    const double flowing =
        pressed > 0 ? std::min(soil.friction, scale * sheared / pressed) : soil.friction;
    const double sliding_friction = std::lerp(flowing, soil.friction, out.upward);
    out.friction = std::min((1 - slid) * soil.friction + rubbed * sliding_friction,
                            out.share * shear * soil.tan_phi);
    return out;
}

/// Normal stress over xi depth of an element that rubs so. What drags its soil towards the free
/// surface bears no more than the fan's share of a push along its normal.
double dragged_normal(double resistive_normal, Vec3 normal, Vec3 up, const Rubbing& rubbing,
                      const SoilStrength& soil) {
    if (!(rubbing.upward > 0)) return resistive_normal;
    const double pushed = -dot(resistive_stress(normal, normal, up, soil.friction), normal);
    const double most = pushed * fan_share(soil.friction_angle_rad, rubbing.friction);
    return std::lerp(resistive_normal, std::min(resistive_normal, most), rubbing.upward);
}

}  // namespace

Vec3 GranularLaw::slide_m_s(const ContactVoxel& contact, Vec3 velocity_m_s) const {
    const double approach = dot(velocity_m_s, contact.normal);
    const double slope = strengths_[static_cast<size_t>(contact.material)].flow_slope;
    return slide_past_flow(velocity_m_s - approach * contact.normal, approach, contact.normal, up(),
                           slope);
}

ElementYield GranularLaw::yield(const ContactElement& element, const ElementMotion& along,
                                const ContactHistory& memory) const {
    const ContactVoxel& contact = element.voxel;
    if (contact.is_load_side) return load_side_yield(this->soil(), contact, along);
    const FaceExtent& face = element.face;
    const bool is_soil = contact.teeth.part == ToothPart::over_tips && !trapped_strengths_.empty();
    const auto material = static_cast<size_t>(contact.material);
    const SoilStrength& dry = (is_soil ? trapped_strengths_ : strengths_)[material];
    std::optional<SoilStrength> wet;
    if (contact.saturation > 0) {
        wet = moistened(dry, this->soil().materials[material], contact.saturation);
    }
    const SoilStrength& soil = wet ? *wet : dry;
    const double bonded =
        contact.undisturbed < 1 ? cohesion_share(this->soil().materials[material], contact) : 1;
    const Vec3 motion = along.share, up = this->up();
    const double creep = def().creep;
    const double shear = developed_shear(soil, memory.sheared_m, face.relative_density, def());
    const double depth_m = bearing_depth_of(contact, up);
    const double held = unloaded_share(depth_m, memory.retreat_m, def());
    const Vec3 n = contact.normal;
    const double approach = dot(motion, n);
    const Vec3 slide = motion - approach * n;
    // The limit answers "what if it were pushed in": a slight retreat is taken out of the motion, a
    // creep along the normal is put in, so that it changes smoothly as the element comes to rest.
    const Vec3 push = slide + (std::max(approach, 0.0) + creep) * n;
    const Vec3 limit_stress = resistive_stress(n, push * (1 / length(push)), up, soil.friction);
    const double resistive_normal = std::max(0.0, -dot(limit_stress, n));
    const Rubbing rubbing = rubbing_of(n, motion, limit_stress, shear, soil, *this);
    const double dragged = dragged_normal(resistive_normal, n, up, rubbing, soil);
    const double down = looks_down(n, up);
    const SoleAndWall parts = bearing_parts(down);
    const FaceFactors factors = face_factors(soil, face, depth_m, def(), parts.sole > 0);
    double xi_depth =
        soil.stiffness_pa_m * depth_m * (parts.sole * factors.sole + parts.wall * factors.wall);
    if (dot(n, up) > 0 && factors.wedge_pa > 0) {
        xi_depth = leaning_stress_pa(soil, factors, n, up, depth_m, resistive_normal);
    }

    // A face above the surface has nothing to shear. Sliding takes from cohesion what it takes from
    // friction.
    const double pushed_normal = parts.sole * soil.sole_stress + parts.wall * soil.wall_stress;
    const double turned = pushed_normal > 0 ? std::min(1.0, dragged / pushed_normal) : 1.0;
    // What has been pressed down by less than it is deep has as much less of it.
    const double pressed = depth_m > 0 ? depth_m / contact.bearing_depth_m : 0;
    const double cohesive_pa =
        depth_m > 0 ? pressed * turned * bonded * cohesive_stress_pa(down, factors.developed, soil)
                    : 0;
    // Momentum flux of the soil that the element sets in motion anew.
    const double impact_m_s = std::max(0.0, along.approach_m_s);
    const double inertial_pa = contact.inflow_share * momentum_flux(soil.density_kg_m3, impact_m_s);

    ElementYield out;
    out.area_share = area_share_of(contact, soil.friction_angle_rad, def(), up);
    out.pushed_pa = xi_depth * dragged + cohesive_pa + inertial_pa;
    out.normal_limit_pa = held * out.pushed_pa;

    out.friction = rubbing.friction;
    out.slide = rubbing.slide;
    // The soil between teeth weighs on what it slides on.
    const double between_pa =
        (contact.bearing_depth_m - depth_m) * down * soil.weight_n_m3 * soil.tan_phi;
    const double adhesion_pa = std::min(soil.adhesion_pa, bonded * soil.cohesion_pa) + between_pa;
    const double held_at_tips = unloaded_share(contact.bearing_depth_m, memory.retreat_m, def());
    out.adhesion_pa =
        contact.bearing_depth_m > 0 ? rubbing.share * held_at_tips * shear * adhesion_pa : 0;

    if (along.asks_mobilized && approach > creep) {
        const Vec3 stress =
            xi_depth * resistive_stress(n, motion * (1 / length(motion)), up, soil.friction);
        const Vec3 normal = dot(stress, n) * n;
        const double left = resistive_normal > 0 ? dragged / resistive_normal : 1;
        const Vec3 flowing = shear * left * (stress - normal);
        const Vec3 dragging = out.friction * left * dot(stress, n) * out.slide;
        out.mobilized_pa = left * normal + flowing + rubbing.upward * (dragging - flowing) -
                           (cohesive_pa + inertial_pa) * n - out.adhesion_pa * out.slide;
    }
    return out;
}

}  // namespace bsoil
