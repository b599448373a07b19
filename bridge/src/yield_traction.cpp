#include "yield_traction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "resistive_force_theory.h"

namespace bsoil::bullet {

double bearing_capacity_factor_nc(double friction_angle_rad) {
    const double tan_phi = std::tan(friction_angle_rad);
    // The quotient loses its digits near phi = 0, where it tends to 2 + pi.
    if (tan_phi < 1e-4) return 2 + std::numbers::pi;
    const double t = std::tan(std::numbers::pi / 4 + friction_angle_rad / 2);
    return (std::exp(std::numbers::pi * tan_phi) * t * t - 1) / tan_phi;
}

double passive_pressure_factor(double phi, double wall) {
    const double root = std::sqrt(std::sin(phi + wall) * std::sin(phi) / std::cos(wall));
    return std::cos(phi) * std::cos(phi) / (std::cos(wall) * (1 - root) * (1 - root));
}

SoilStrength strength_of(const MaterialDef& material, double gravity_m_s2) {
    const double tan_phi = std::tan(material.friction_angle_rad);
    SoilStrength out;
    out.stiffness_pa_m = resistive_stiffness_pa_m(material.density_kg_m3, gravity_m_s2, tan_phi);
    out.density_kg_m3 = material.density_kg_m3;
    out.friction = std::min(material.tool_friction, tan_phi);
    out.weight_n_m3 = material.density_kg_m3 * gravity_m_s2;
    out.passive_factor =
        passive_pressure_factor(material.friction_angle_rad, std::atan(out.friction));
    out.wedge_spread = std::tan(std::numbers::pi / 4 + material.friction_angle_rad / 2);
    out.bearing_nq = 1 + tan_phi * bearing_capacity_factor_nc(material.friction_angle_rad);
    out.bearing_ngamma = 2 * (out.bearing_nq + 1) * tan_phi;
    out.cohesion_sole_pa =
        material.cohesion_pa * bearing_capacity_factor_nc(material.friction_angle_rad);
    out.cohesion_wall_pa =
        2 * material.cohesion_pa * std::tan(std::numbers::pi / 4 + material.friction_angle_rad / 2);
    return out;
}

namespace {

/// Cohesive part of the normal stress: a sole pushed down meets Prandtl's c Nc, a wall pushed
/// sideways lifts a Rankine wedge; in between the two are mixed by the squares of the normal's
/// parts. A face that looks up lifts soil as a wall does.
double cohesive_stress_pa(Vec3 normal, Vec3 up, const SoilStrength& soil) {
    const double down = std::max(0.0, -dot(normal, up));
    const double sole = down * down;
    return sole * soil.cohesion_sole_pa + (1 - sole) * soil.cohesion_wall_pa;
}

}  // namespace

namespace {

/// What the size of its face makes of an element's frictional stress: bounds the horizontal part of
/// a push by the wedge, raises the downward part to the bearing capacity. Returns a factor on the
/// stress of resistive force theory.
double size_factor(Vec3 normal, Vec3 up, double depth_m, double stress_pa, const SoilStrength& soil,
                   const FaceExtent& face) {
    if (!(face.width_m > 0) || !(stress_pa > 0)) return 1;
    const double down = std::max(0.0, -dot(normal, up));
    const double sole = down * down;
    const double spread = 1 + 2.0 / 3 * soil.wedge_spread * face.depth_m / face.width_m;
    const double wedge_pa = soil.weight_n_m3 * depth_m * soil.passive_factor * spread;
    const double mobilized = std::min(1.0, depth_m / (0.15 * face.width_m));
    const double bearing_pa =
        mobilized * soil.weight_n_m3 *
        (depth_m * soil.bearing_nq + 0.3 * face.width_m * soil.bearing_ngamma);
    return sole * std::max(1.0, bearing_pa / stress_pa) +
           (1 - sole) * std::min(1.0, wedge_pa / stress_pa);
}

}  // namespace

ElementYield yield_of_element(const ContactVoxel& contact, Vec3 velocity_m_s, Vec3 up,
                              const SoilStrength& soil, const FaceExtent& face) {
    const Vec3 n = contact.normal;
    const double depth_m = contact.depth_m + contact.compression_m;
    // A face above the surface has nothing to shear.
    const double cohesive_pa = depth_m > 0 ? cohesive_stress_pa(n, up, soil) : 0;
    const double speed = length(velocity_m_s);
    const double approach = dot(velocity_m_s, n);
    // Momentum flux of the soil that the element sets in motion.
    const double inertial_pa = approach > 0 ? soil.density_kg_m3 * approach * approach : 0;

    ElementYield out;
    // The limit answers "what if it were pushed in": a retreat is taken out of the motion, a creep
    // along the normal is put in, so that it changes smoothly as the element comes to rest.
    const Vec3 slide = velocity_m_s - approach * n;
    const Vec3 push = slide + (std::max(approach, 0.0) + kCreepSpeedMS) * n;
    const Vec3 limit_stress = resistive_stress(n, push * (1 / length(push)), up, soil.friction);
    const double resistive_normal = std::max(0.0, -dot(limit_stress, n));
    const double xi_depth =
        soil.stiffness_pa_m * depth_m *
        size_factor(n, up, depth_m, soil.stiffness_pa_m * depth_m * resistive_normal, soil, face);
    out.normal_limit_pa = xi_depth * resistive_normal + cohesive_pa + inertial_pa;

    // Sticking, the contact can carry all its friction; sliding, what resistive force theory finds
    // along the surface.
    const double resistive_surface = length(limit_stress + resistive_normal * n);
    const double sliding_friction =
        resistive_normal > 0 ? std::min(soil.friction, resistive_surface / resistive_normal)
                             : soil.friction;
    const double slide_speed = length(slide);
    const double slid = slide_speed / (slide_speed + kCreepSpeedMS);
    out.friction = soil.friction + slid * (sliding_friction - soil.friction);

    if (approach > 0 && speed > kCreepSpeedMS)
        out.mobilized_pa =
            xi_depth * resistive_stress(n, velocity_m_s * (1 / speed), up, soil.friction) -
            (cohesive_pa + inertial_pa) * n;
    return out;
}

}  // namespace bsoil::bullet
