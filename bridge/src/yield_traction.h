/// Yield of the soil at one element of a body's surface.
#pragma once

#include "bsoil/body.h"
#include "bsoil/material.h"

namespace bsoil::bullet {

/// Slower than this the direction of an element's motion says nothing about what it would do to the
/// soil: its limit is that of a push along its normal. Larger: slow ploughs are held as if they
/// were pressed; smaller: the solver's rest velocities of about 1e-4 m/s pick the direction of a
/// body at rest.
inline constexpr double kCreepSpeedMS = 1e-3;

/// What the yield of one material needs, computed once.
struct SoilStrength {
    double stiffness_pa_m = 0;  ///< xi of resistive force theory
    double density_kg_m3 = 0;
    double friction =
        0;  ///< min(tool friction, tan phi): sliding shears the weaker of contact and soil
    double cohesion_sole_pa = 0;  ///< c Nc: of a horizontal element pushed down
    double cohesion_wall_pa = 0;  ///< 2 c tan(45 + phi/2): of a vertical element pushed sideways
    double weight_n_m3 = 0;       ///< unit weight gamma
    double passive_factor = 0;  ///< Coulomb's passive earth pressure coefficient of a vertical wall
    double wedge_spread = 0;    ///< tan(45 + phi/2): length of the passive wedge over its depth
    double bearing_nq = 0;      ///< bearing capacity factors of depth
    double bearing_ngamma = 0;  ///< ... and of width (Vesic)
};
SoilStrength strength_of(const MaterialDef& material, double gravity_m_s2);

/// Size of the face an element belongs to. Zero: as small as resistive force theory takes it.
struct FaceExtent {
    double width_m = 0;  ///< the shorter horizontal side of a sole; the horizontal side of a wall
    double depth_m = 0;  ///< of its deepest element below the surface
};

/// Coulomb's passive coefficient for a vertical wall with friction angle `wall_rad` and level
/// ground.
double passive_pressure_factor(double friction_angle_rad, double wall_rad);

/// Nc of Prandtl's bearing capacity: (Nq - 1) / tan phi, Nq = exp(pi tan phi) tan^2(45 + phi/2); 2
/// + pi at phi = 0.
double bearing_capacity_factor_nc(double friction_angle_rad);

/// Stresses [Pa] at one element.
struct ElementYield {
    double normal_limit_pa =
        0;  ///< largest normal stress the soil can give the element if it is pushed in
    double friction = 0;  ///< shear over normal stress while sliding as it does
    Vec3 mobilized_pa;  ///< stress on the body from the motion as it is; zero unless it moves into
                        ///< the soil
};

/// velocity_m_s: of the element. up: unit. Depth is counted with the compression added, so that a
/// surface just touching the soil has some bearing. Resistive force theory holds for small
/// intruders; a wide wall meets no more than the passive wedge in front of it (with its sides: 1 +
/// 2/3 tan(45 + phi/2) depth / width, after McKyes and Ali 1977), a wide sole no less than its
/// bearing capacity (gamma z Nq + 0.3 gamma B Ngamma, in full from a sinkage of 0.15 B on).
ElementYield yield_of_element(const ContactVoxel& contact, Vec3 velocity_m_s, Vec3 up,
                              const SoilStrength& soil, const FaceExtent& face = {});

}  // namespace bsoil::bullet
