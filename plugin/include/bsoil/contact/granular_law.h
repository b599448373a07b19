/// GranularLaw: soil that yields by resistive force theory, with the size effect of faces, density
/// and the shear that soil remembers.
#pragma once

#include <vector>

#include "bsoil/contact/contact_law.h"
#include "bsoil/contact/passive_wedge.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// What of a sole's bearing pressure follows from the friction angle.
struct BearingFactors {
    double friction_angle_rad = 0, tan_phi = 0, sin_phi = 0;
    double nq = 1, ngamma = 0;  ///< of depth and of width
};

/// What the yield of one material needs, computed once.
struct SoilStrength {
    double stiffness_pa_m = 0;      ///< xi of resistive force theory
    double friction_angle_rad = 0;  ///< of the critical state
    double tan_phi = 0;             ///< its tangent
    BearingFactors bearing;         ///< of this angle
    double friction =
        0;  ///< min(tool friction, tan phi): sliding shears the weaker of contact and soil
    double adhesion_pa = 0;       ///< min(tool adhesion, cohesion)
    double cohesion_pa = 0;       ///< c of soil that was never moved
    double cohesion_sole_pa = 0;  ///< c Nc: of a horizontal element pushed down
    double cohesion_wall_pa = 0;  ///< 2 c tan(45 + phi/2): of a vertical element pushed sideways
    double density_kg_m3 = 0;
    double weight_n_m3 = 0;  ///< unit weight gamma
    /// Passive earth pressure coefficient of a vertical wall: Coulomb's, or a log spiral's with
    /// ContactLawDef::passive_wedge.
    double passive_factor = 0;
    double wedge_width_growth =
        0;  ///< passive_width_growth() of it; 0: a wedge as wide as its wall
    double wedge_normal_share = 1;  ///< of the wedge's push that is along the wall's normal
    double wedge_sides = 0;         ///< share that the wedge's two sides add, per depth over width
    double sliding_share =
        1;                   ///< tan phi over what resistive force theory has along a sliding sole
    double flow_slope = 1;   ///< flow_slope() of its angle
    double sole_stress = 0;  ///< stress over xi depth that resistive force theory gives a level
                             ///< element pushed down
    double wall_stress = 0;  ///< ... an upright element pushed along its normal
    double shear_displacement_m = 0;  ///< Janosi's K of soil as placed
    double placed_relative_density = 0;
};
/// Of a material against a body with this surface. gravity_m_s2: > 0.
SoilStrength strength_of(const MaterialDef& material, double gravity_m_s2,
                         const SurfaceFriction& surface = {}, const ContactLawDef& law = {});

/// The same where water fills this share of the pores: heavier by it, so that friction holds more,
/// and with the cohesion of moisture.
SoilStrength moistened(const SoilStrength& dry, const MaterialDef& material, double saturation);

/// Share of its cohesion, with that of its water, that the soil beside a contact has: all of what
/// was never moved, and of the rest what moved soil keeps and what compaction gives it.
double cohesion_share(const MaterialDef& material, const ContactVoxel& contact);

/// What a face's size and density make of resistive force theory: a factor on the frictional stress
/// of its level and of its upright elements.
struct FaceFactors {
    double sole = 1, wall = 1;
    double developed = 1;  ///< share of a sole's bearing that its sinkage has mobilized
    double wedge_pa = 0;   ///< of an upright element; 0: nothing bounds it
};

/// The factors at an element's depth.
///
/// A wide wall meets no more than Coulomb's passive wedge in front of it. The friction of the
/// wedge's two sides at rest pressure K0 = 1 - sin phi counts with it, as in the wedge of Reese,
/// Cox and Koop (1974) without its fan:
///
///     1 + 2/3 (1 - sin phi) sin phi / sin(45 + phi/2) depth / width
///
/// With ContactLawDef::passive_wedge it is a log spiral's wedge with passive_width_factor().
///
/// A sole bears gamma z Nq sq + 1/2 gamma B Ngamma sgamma. Nq is Prandtl's, with De Beer's sq = 1 +
/// B/L tan phi. Ngamma is of rough strips by limit analysis (Hjiaj, Lyamin and Sloan 2005), within
/// 2 % of the exact values. sgamma = 1 + (0.0336 phi[deg] - 1) B/L is of squares on soil of the
/// same angle (Lyamin and others 2007). De Beer's 0.6 is not: it belongs to the angle of plane
/// strain under all soles. This is mobilized over a sinkage of 0.15 widths in loose soil and 0.05
/// in compacted. The friction angle is Bolton's. A sole bears no less than by resistive force
/// theory, whatever its density: the capacity of footings counts soil above the sole as a load
/// without strength, and that theory was measured deeper than wide.
///
/// is_sole_asked: a face that does not look down has no use for a sole's factor, which costs most.
/// It is 1 then.
FaceFactors face_factors(const SoilStrength& soil, const FaceExtent& face, double depth_m,
                         const ContactLawDef& law = {}, bool is_sole_asked = true);

/// Share 0..1 of a sole's bearing that its sinkage has mobilized:
/// ContactLawDef::mobilization_widths in loose soil.
double developed_bearing(const FaceExtent& face, double depth_m, const ContactLawDef& law = {});

/// Width over length, 0..1; 1 where a face has no length.
double slimness_of(const FaceExtent& face);

/// Bolton (1986): phi + 5 deg I_R in plane strain and 3 in triaxial compression, I_R = I_D (10 - ln
/// p') - 1 in 0..4, p' in kPa. slimness: width over length of the sole, 0 a strip to 1 a square,
/// and linear between (Meyerhof 1963).
double peak_friction_angle(double critical_rad, double relative_density, double mean_stress_pa,
                           double slimness);

/// Nc of Prandtl's bearing capacity: (Nq - 1) / tan phi, Nq = exp(pi tan phi) tan^2(45 + phi/2); 2
/// + pi at phi = 0.
double bearing_capacity_factor_nc(double friction_angle_rad);

/// Share 1 - exp(-j / K) of the shear stress that has developed after a shear displacement j
/// (Janosi and Hanamoto 1961); K falls with density, to a quarter from loose to compacted (Wong
/// gives 25 mm for loose and 6 mm for firm sand). 1 where the material has no K.
double developed_shear(const SoilStrength& soil, double displacement_m, double relative_density,
                       const ContactLawDef& law = {});

/// Share 0..1 of an element's friction that is a slip along its face: 1 along it, half where it
/// goes into the soil by ContactLawDef::slip_band_slope of its slip, falling with the square.
/// approach, sliding: along the outward normal and along the face, in one unit.
double slip_band_share(double approach, double sliding, const ContactLawDef& law = {});

/// The law. Depth is at least the compression, so that a surface just touching the soil has some
/// bearing; the momentum flux of an approach adds to the limit.
class GranularLaw final : public ContactLaw {
  public:
    /// soil: not null.
    GranularLaw(std::shared_ptr<const ContactSoil> soil, const SurfaceFriction& surface);
    /// With strengths of its own, indexed by ContactVoxel::material.
    GranularLaw(std::shared_ptr<const ContactSoil> soil, std::vector<SoilStrength> strengths);
    /// See ContactLaw::yield().
    ElementYield yield(const ContactElement& element, const ElementMotion& motion,
                       const ContactHistory& memory) const override;
    /// Soil that the face pushes flows along it: slide_past_flow().
    Vec3 slide_m_s(const ContactVoxel& contact, Vec3 velocity_m_s) const override;

  private:
    /// Indexed by ContactVoxel::material.
    std::vector<SoilStrength> strengths_;
    std::vector<SoilStrength> trapped_strengths_;  ///< of soil between teeth, which meets soil
};

}  // namespace bsoil
#pragma GCC visibility pop
