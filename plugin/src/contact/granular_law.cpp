#include "bsoil/contact/granular_law.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "bsoil/contact/momentum_flux.h"
#include "bsoil/contact/orientation.h"
#include "bsoil/contact/passive_wedge.h"
#include "bsoil/contact/resistive_force_theory.h"
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

/// Friction of a surface so rough that it bounds nothing. Ours: ten times what any soil slides on
/// itself with. Smaller than tan phi it would cap the stress that is asked for.
constexpr double kRoughFriction = 10;

BearingFactors bearing_factors(double friction_angle_rad) {
    const double tan_phi = std::tan(friction_angle_rad);
    const double nq = 1 + tan_phi * bearing_capacity_factor_nc(friction_angle_rad);
    return {friction_angle_rad, tan_phi, std::sin(friction_angle_rad), nq, 2 * (nq + 1) * tan_phi};
}

}  // namespace

double peak_friction_angle(double critical_rad, double relative_density, double mean_stress_pa) {
    // Bolton (1986), The strength and dilatancy of sands: I = D (Q - ln p) - R with Q 10 (quartz)
    // and R 1, I 0 to 4, and 5 deg a unit of I in plane strain (3 in triaxial compression). A
    // larger Q is of grains that crush later: dense soil keeps its angle under more stress.
    constexpr double kCrushing = 10, kOffset = 1, kDilatancyMost = 4;
    constexpr double kAngle = 5 * std::numbers::pi / 180;
    const double stress_kpa = std::max(1e-3, mean_stress_pa / 1e3);
    const double dilatancy = relative_density * (kCrushing - std::log(stress_kpa)) - kOffset;
    return critical_rad + kAngle * std::clamp(dilatancy, 0.0, kDilatancyMost);
}

double developed_shear(const SoilStrength& soil, double displacement_m, double relative_density,
                       const ContactLawDef& law) {
    if (!(soil.shear_displacement_m > 0)) return 1;
    const auto stiffening = [&law](double density) {
        return 1 - (1 - law.dense_shear_share) * density;
    };
    const double k_m = relative_density < 0
                           ? soil.shear_displacement_m
                           : soil.shear_displacement_m * stiffening(relative_density) /
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
    out.weight_n_m3 = material.density_kg_m3 * gravity_m_s2;
    const double wall_rad = std::atan(out.friction);
    out.passive_factor = law.passive_wedge ? log_spiral_passive_factor(phi, wall_rad)
                                           : passive_pressure_factor(phi, wall_rad);
    if (law.passive_wedge) out.wedge_normal_share = std::cos(wall_rad);
    out.wedge_sides =
        2.0 / 3 * (1 - std::sin(phi)) * std::sin(phi) / std::sin(std::numbers::pi / 4 + phi / 2);
    out.cohesion_sole_pa = material.cohesion_pa * bearing_capacity_factor_nc(phi);
    out.cohesion_wall_pa = 2 * material.cohesion_pa * std::tan(std::numbers::pi / 4 + phi / 2);
    const Vec3 up{0, 0, 1}, down{0, 0, -1}, level{1, 0, 0};
    out.sole_stress = -dot(resistive_stress(down, down, up, out.friction), down);
    out.wall_stress = -dot(resistive_stress(level, level, up, out.friction), level);
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

namespace {

/// Bearing pressure of a sole on soil of a known density, in full.
double bearing_pressure_pa(const SoilStrength& soil, const FaceExtent& face, double depth_m,
                           const BearingFactors& factors) {
    const double slimness = face.length_m > 0 ? face.width_m / face.length_m : 1;
    return soil.weight_n_m3 * (depth_m * factors.nq * (1 + slimness * factors.tan_phi) +
                               0.5 * face.width_m * factors.ngamma * (1 - 0.4 * slimness));
}

}  // namespace

FaceFactors face_factors(const SoilStrength& soil, const FaceExtent& face, double depth_m,
                         const ContactLawDef& law) {
    if (!(face.width_m > 0) || !(depth_m > 0)) return {};
    const bool density_known = face.relative_density >= 0;
    const double density = std::max(0.0, face.relative_density);
    BearingFactors factors = soil.bearing;
    double bearing_pa = bearing_pressure_pa(soil, face, depth_m, factors);
    // The friction angle falls with the mean stress at failure, which rises with it (De Beer's mean
    // stress); three rounds leave less than a degree.
    for (int round = 0; density_known && round < 3; ++round) {
        const double mean_pa =
            (bearing_pa + 3 * soil.weight_n_m3 * depth_m) / 4 * (1 - factors.sin_phi);
        const double phi = peak_friction_angle(soil.friction_angle_rad, density, mean_pa);
        if (phi == factors.friction_angle_rad) break;  // further rounds find it again
        factors = bearing_factors(phi);
        bearing_pa = bearing_pressure_pa(soil, face, depth_m, factors);
    }
    const double developed = std::min(
        1.0, depth_m / ((law.mobilization_widths - law.mobilization_fall_widths * density) *
                        face.width_m));
    const double resistive_pa = soil.stiffness_pa_m * depth_m;
    // Without friction there is no frictional stress to change.
    if (!(resistive_pa * soil.sole_stress > 0)) return {.developed = developed};
    const double sole = developed * bearing_pa / (resistive_pa * soil.sole_stress);
    const double spread = law.passive_wedge
                              ? passive_width_factor(soil.passive_factor, soil.friction_angle_rad,
                                                     face.width_m, face.foot_m)
                              : 1 + soil.wedge_sides * face.depth_m / face.width_m;
    const double wedge_pa =
        soil.weight_n_m3 * depth_m * soil.passive_factor * soil.wedge_normal_share * spread;
    return {density_known ? sole : std::max(1.0, sole),
            wedge_pa < resistive_pa * soil.wall_stress
                ? wedge_pa / (resistive_pa * soil.wall_stress)
                : 1.0,
            developed};
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

ElementYield GranularLaw::yield(const ContactElement& element, const ElementMotion& along,
                                const ContactHistory& memory) const {
    const ContactVoxel& contact = element.voxel;
    const FaceExtent& face = element.face;
    const bool is_soil = contact.teeth.is_over_tips && !trapped_strengths_.empty();
    const auto material = static_cast<size_t>(contact.material);
    const SoilStrength& dry = (is_soil ? trapped_strengths_ : strengths_)[material];
    std::optional<SoilStrength> wet;
    if (contact.saturation > 0) {
        wet = moistened(dry, this->soil().materials[material], contact.saturation);
    }
    const SoilStrength& soil = wet ? *wet : dry;
    const Vec3 motion = along.share, up = this->up();
    const double creep = def().creep;
    const double shear = developed_shear(soil, memory.sheared_m, face.relative_density, def());
    const double depth_m = contact.bearing_depth_m;
    const double held = unloaded_share(depth_m, memory.retreat_m, def());
    const Vec3 n = contact.normal;
    const double approach = dot(motion, n);
    const Vec3 slide = motion - approach * n;
    const double sliding = length(slide);
    // The limit answers "what if it were pushed in": a slight retreat is taken out of the motion, a
    // creep along the normal is put in, so that it changes smoothly as the element comes to rest.
    const Vec3 push = slide + (std::max(approach, 0.0) + creep) * n;
    const Vec3 limit_stress = resistive_stress(n, push * (1 / length(push)), up, soil.friction);
    const double resistive_normal = std::max(0.0, -dot(limit_stress, n));
    const double down = looks_down(n, up);
    const SoleAndWall parts = bearing_parts(down);
    const FaceFactors factors = face_factors(soil, face, depth_m, def());
    const double xi_depth =
        soil.stiffness_pa_m * depth_m * (parts.sole * factors.sole + parts.wall * factors.wall);

    // A face above the surface has nothing to shear. Sliding takes from cohesion what it takes from
    // friction.
    const double pushed_normal = parts.sole * soil.sole_stress + parts.wall * soil.wall_stress;
    const double turned = pushed_normal > 0 ? std::min(1.0, resistive_normal / pushed_normal) : 1.0;
    const double cohesive_pa =
        depth_m > 0 ? turned * cohesive_stress_pa(down, factors.developed, soil) : 0;
    // Momentum flux of the soil that the element sets in motion.
    const double impact_m_s = std::max(0.0, along.approach_m_s);
    const double inertial_pa = momentum_flux(soil.density_kg_m3, impact_m_s);

    ElementYield out;
    out.area_share = area_share_of(contact, motion, soil.friction_angle_rad, def(), up);
    out.normal_limit_pa = held * (xi_depth * resistive_normal + cohesive_pa + inertial_pa);

    // Sticking, the contact can carry all its friction; sliding, what resistive force theory finds
    // along the surface.
    const double resistive_surface = length(limit_stress + resistive_normal * n);
    const double sliding_share =
        1 + (soil.sliding_share - 1) * slip_band_share(approach, sliding, def());
    const double sliding_friction =
        resistive_normal > 0
            ? std::min(soil.friction, sliding_share * resistive_surface / resistive_normal)
            : soil.friction;
    const double slid = sliding / (sliding + creep);
    if (sliding > 0) out.slide = slide * (slid / sliding);
    out.friction =
        std::min(soil.friction + slid * (sliding_friction - soil.friction), shear * soil.tan_phi);
    out.adhesion_pa = depth_m > 0 ? held * shear * soil.adhesion_pa : 0;

    if (approach > creep) {
        const Vec3 stress =
            xi_depth * resistive_stress(n, motion * (1 / length(motion)), up, soil.friction);
        const Vec3 normal = dot(stress, n) * n;
        out.mobilized_pa = normal + shear * (stress - normal) - (cohesive_pa + inertial_pa) * n;
        if (sliding > creep) out.mobilized_pa += slide * (-out.adhesion_pa / sliding);
    }
    return out;
}

}  // namespace bsoil
