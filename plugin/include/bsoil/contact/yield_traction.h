/// Yield of the soil at one element of a body's surface.
#pragma once

#include "bsoil/body.h"
#include "bsoil/material.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// An element that moves less than this share of its body's motion counts as resting: its limit is
/// that of a push along its normal, and friction holds it in any direction. Larger: a wheel that
/// slips a little is held like one that does not; smaller: rounding picks directions.
inline constexpr double kCreep = 0.01;

/// What the yield of one material needs, computed once.
struct SoilStrength {
    double stiffness_pa_m = 0;      ///< xi of resistive force theory
    double friction_angle_rad = 0;  ///< of the critical state
    double tan_phi = 0;             ///< its tangent
    double friction =
        0;  ///< min(tool friction, tan phi): sliding shears the weaker of contact and soil
    double adhesion_pa = 0;       ///< min(tool adhesion, cohesion)
    double cohesion_sole_pa = 0;  ///< c Nc: of a horizontal element pushed down
    double cohesion_wall_pa = 0;  ///< 2 c tan(45 + phi/2): of a vertical element pushed sideways
    double density_kg_m3 = 0;
    double weight_n_m3 = 0;     ///< unit weight gamma
    double passive_factor = 0;  ///< Coulomb's passive earth pressure coefficient of a vertical wall
    double wedge_sides = 0;     ///< share that the wedge's two sides add, per depth over width
    double sliding_share =
        1;                   ///< tan phi over what resistive force theory has along a sliding sole
    double sole_stress = 0;  ///< stress over xi depth that resistive force theory gives a level
                             ///< element pushed down
    double wall_stress = 0;  ///< ... an upright element pushed along its normal
    double shear_displacement_m = 0;  ///< Janosi's K of soil as placed
    double placed_relative_density = 0;
};
/// Of a material against a body with this surface. gravity_m_s2: > 0.
SoilStrength strength_of(const MaterialDef& material, double gravity_m_s2,
                         const SurfaceFriction& surface = {});

/// Size and state of the face that an element belongs to. Zero width: as small as resistive force
/// theory takes it.
struct FaceExtent {
    double width_m = 0;            ///< the shorter side of a sole; the level side of a wall
    double length_m = 0;           ///< the longer side of a sole
    double depth_m = 0;            ///< of its deepest element below the surface
    double relative_density = -1;  ///< of the soil at it; negative: not state
};

/// What a face's size and density make of resistive force theory: a factor on the frictional stress
/// of its level and of its upright elements.
struct FaceFactors {
    double sole = 1, wall = 1;
    double developed = 1;  ///< share of a sole's bearing that its sinkage has mobilized
};

/// A wide wall meets no more than Coulomb's passive wedge in front of it, with the friction of the
/// wedge's two sides at rest pressure K0 = 1 - sin phi (as in the wedge of Reese, Cox and Koop
/// 1974, without its fan): 1 + 2/3 (1 - sin phi) sin phi / sin(45 + phi/2) depth / width. A sole
/// bears gamma z Nq sq + 1/2 gamma B Ngamma sgamma (Vesic's factors and shape factors), mobilized
/// over a sinkage of 0.15 widths in loose soil, 0.05 in compacted: no less than resistive force
/// theory where density is not known, that where it is. Dense soil's friction angle is Bolton's. At
/// an element's depth.
FaceFactors face_factors(const SoilStrength& soil, const FaceExtent& face, double depth_m);

/// Bolton (1986), plane strain: phi + 5 deg I_R, I_R = I_D (10 - ln p') - 1 in 0..4, p' in kPa.
double peak_friction_angle(double critical_rad, double relative_density, double mean_stress_pa);

/// Coulomb's passive coefficient for a vertical wall with friction angle `wall_rad` and level
/// ground.
double passive_pressure_factor(double friction_angle_rad, double wall_rad);

/// Nc of Prandtl's bearing capacity: (Nq - 1) / tan phi, Nq = exp(pi tan phi) tan^2(45 + phi/2); 2
/// + pi at phi = 0.
double bearing_capacity_factor_nc(double friction_angle_rad);

/// Share 1 - exp(-j / K) of the shear stress that has developed after a shear displacement j
/// (Janosi and Hanamoto 1961); K falls with density, to a quarter from loose to compacted (Wong
/// gives 25 mm for loose and 6 mm for firm sand). 1 where the material has no K.
double developed_shear(const SoilStrength& soil, double displacement_m, double relative_density);

/// Depth [m] that an element's strength is reckoned from: below the soil's surface, at least what
/// the soil is pressed in by.
double bearing_depth_m(const ContactVoxel& contact);

/// Share 0..1 of an element that touches its soil. Soil pressed down rebounds by a part of its
/// depth; a gap beyond that opens within a quarter of a voxel.
double touching_share(const ContactVoxel& contact, double voxel_m);

/// Share 0..1 of the yield stress that is left once an element has drawn back from the soil by
/// retreat_m.
double unloaded_share(double depth_m, double retreat_m);

/// Stresses [Pa] at one element.
struct ElementYield {
    double normal_limit_pa =
        0;  ///< largest normal stress the soil can give the element if it is pushed in
    double friction = 0;     ///< shear over normal stress while sliding as it does
    double adhesion_pa = 0;  ///< shear stress besides
    Vec3 slide;  ///< direction of the sliding, shorter than 1 where the element hardly slides
    Vec3 mobilized_pa;  ///< stress on the body from the motion as it is; zero unless it moves into
                        ///< the soil
};

/// motion: of the element, as a share of its body's motion, length 0..1; at rest it is zero, and
/// the speed of the motion is in approach_m_s alone, along the normal: its momentum flux adds to
/// the limit. up: unit. Depth is at least the compression, so that a surface just
/// touching the soil has some bearing. shear: developed share of the shear stress, 0..1. held:
/// share of the limit that unloading has left, 0..1.
ElementYield yield_of_element(const ContactVoxel& contact, Vec3 motion, double approach_m_s,
                              Vec3 up, const SoilStrength& soil, const FaceExtent& face = {},
                              double shear = 1, double held = 1);

}  // namespace bsoil
#pragma GCC visibility pop
