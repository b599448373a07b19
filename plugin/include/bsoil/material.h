/// Soil materials: what a soil is made of, with the units soil mechanics uses.
#pragma once

#include <array>
#include <span>
#include <string>

#include "bsoil/result.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// One granular material. All values are checked by validate(). Its numbers stand once more in
/// BSOIL_MATERIAL_FIELDS below, which is what reads, checks, saves and documents them.
struct MaterialDef {
    std::string name = "dry_sand";  ///< unique within a soil, used by scenes and summaries
    double density_kg_m3 = 1600;    ///< bulk density as placed, 200..4000
    /// bulk density once it has been dug and dropped, 0..4000; 0 here and in the next: the density
    /// does not change. Then soil neither swells nor compacts, and bears as loose soil does. Give
    /// both or none: loose <= placed <= compacted, loose at least half of compacted. A bed of one
    /// known density: set_range_of_loose_bed()
    double loose_density_kg_m3 = 0;
    double compacted_density_kg_m3 = 0;  ///< bulk density compacted by 1 MPa, 0..4000
    /// angle of internal friction phi, 0..1.2 (33 deg): of the critical state, that is of steady
    /// shearing
    double friction_angle_rad = 0.576;
    double cohesion_pa = 0;  ///< cohesion c, 0..200e3
    /// share of the cohesion that soil keeps once it has been moved, 0..1
    double loose_cohesion_fraction = 0;
    /// cohesion of moved soil over the pressure that compacted it, 0..0.5; 0: compaction gives it
    /// none. Hvorslev's kappa. The pressure is that which belongs to its density, see
    /// pressure_of_relative_density(). No more than all of the cohesion. Needs the densities
    double compaction_cohesion_ratio = 0;
    /// peak angle of friction over the critical one per unit of dilatancy index, 0..0.1; 0: density
    /// does not count. Bolton (1986) has 5 deg for slopes. Of soil that was never moved, see
    /// dilatancy_index(). Needs the densities
    double dilatancy_angle_rad = 0;
    /// slope above tan phi at which soil still stands, 0..40; by place between half of it and all
    /// of it: slopes stand irregularly. 40: every slope stands
    double roughness = 0;
    /// share of the slides that do not take place, 0..1; 0: as sand does, 1: nothing slides. Chance
    /// decides in each pass
    double viscosity = 0;
    /// water that its pores hold, as a share of the soil's mass, 0..1; 0: it takes none. Dry soil
    /// weighs density_kg_m3
    double pore_water_fraction = 0;
    double placed_saturation = 0;  ///< share of the pores that water fills as placed, 0..1
    /// cohesion that water gives where it fills half of the pores, 0..200e3; none dry and full. Of
    /// soil that was moved loose_cohesion_fraction of it
    double moist_cohesion_pa = 0;
    double conductivity_m_s = 0;       ///< of water down through full pores, 0..1
    double residual_saturation = 0.1;  ///< share of the pores that does not drain, 0..0.95
    /// speed at which its grains fall in air in the end, 0..100; 0: as in a vacuum, and no wind
    /// moves it
    double fall_speed_m_s = 0;
    double tool_friction = 0.4;  ///< Coulomb friction with bodies, 0..2
    /// shear stress between soil and bodies without pressure, 0..200e3
    double tool_adhesion_pa = 0;
    /// Janosi and Hanamoto's K of soil as placed, 0..0.2; 0: the shear stress is there at once.
    /// K is the shear displacement after which 1 - 1/e of the shear stress has developed
    double shear_displacement_m = 0;
    std::array<float, 3> color{0.76f, 0.66f, 0.45f};  ///< linear RGB, 0..1, for pictures only
    /// Whether density is state: it changes with what happens to the soil.
    bool has_density_range() const { return loose_density_kg_m3 > 0; }
    /// 0 at the loose density, 1 at the compacted one, linear in the volume of a mass. Needs
    /// has_density_range().
    double relative_density(double at_kg_m3) const {
        return (1 / loose_density_kg_m3 - 1 / at_kg_m3) /
               (1 / loose_density_kg_m3 - 1 / compacted_density_kg_m3);
    }
    /// Mass of the soil with its water over that of the dry soil, where water fills this share of
    /// the pores.
    double wet_mass_share(double saturation) const { return 1 + saturation * pore_water_fraction; }
    /// Cohesion that this water gives it: Bishop's effective stress with chi = S, and a suction
    /// that falls linearly with S.
    double moisture_cohesion_pa(double saturation) const {
        return 4 * saturation * (1 - saturation) * moist_cohesion_pa;
    }
    /// Cohesion, without that of water, of soil that was moved: loose_cohesion_fraction of it, and
    /// what compaction to this relative density gives.
    double moved_cohesion_pa(double at_relative_density) const;
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

// clang-format off
/// The numbers of a MaterialDef: FIELD(name, least, most, use, what it is, what else to know or "").
/// use: `live` where Soil::change() takes another value while the soil runs, else `state`. The
/// name's ending is the unit; the default is the member's. One row makes a field of validate(), of
/// snapshots, of bulletsoil_material in C and of [[material]] in scenes and their page.
#define BSOIL_MATERIAL_FIELDS(FIELD)                                                               \
    FIELD(density_kg_m3, 200, 4000, state, "bulk density as placed", "")                           \
    FIELD(loose_density_kg_m3, 0, 4000, state, "bulk density once it has been dug and dropped",    \
          "0 here and in the next: the density does not change")                                   \
    FIELD(compacted_density_kg_m3, 0, 4000, state, "bulk density compacted by 1 MPa", "")          \
    FIELD(friction_angle_rad, 0, 1.2, live, "angle of internal friction phi",                      \
          "of the critical state")                                                                 \
    FIELD(cohesion_pa, 0, 200e3, live, "cohesion c", "")                                           \
    FIELD(loose_cohesion_fraction, 0, 1, live,                                                     \
          "share of the cohesion that soil keeps once it has been moved", "")                      \
    FIELD(compaction_cohesion_ratio, 0, 0.5, live,                                                 \
          "cohesion of moved soil over the pressure that compacted it",                            \
          "0: compaction gives it none")                                                           \
    FIELD(dilatancy_angle_rad, 0, 0.1, live,                                                       \
          "peak angle of friction over the critical one per unit of dilatancy index",              \
          "0: density does not count")                                                             \
    FIELD(roughness, 0, 40, live, "slope above tan phi at which soil still stands",                \
          "by place between half of it and all of it")                                             \
    FIELD(viscosity, 0, 1, live, "share of the slides that do not take place",                     \
          "0: as sand does, 1: nothing slides")                                                    \
    FIELD(pore_water_fraction, 0, 1, state,                                                        \
          "water that its pores hold, as a share of the soil's mass", "0: it takes none")          \
    FIELD(placed_saturation, 0, 1, live, "share of the pores that water fills as placed", "")      \
    FIELD(moist_cohesion_pa, 0, 200e3, live,                                                       \
          "cohesion that water gives where it fills half of the pores", "")                        \
    FIELD(conductivity_m_s, 0, 1, live, "of water down through full pores", "")                    \
    FIELD(residual_saturation, 0, 0.95, live, "share of the pores that does not drain", "")        \
    FIELD(fall_speed_m_s, 0, 100, live, "speed at which its grains fall in air in the end",        \
          "0: as in a vacuum, and no wind moves it")                                               \
    FIELD(tool_friction, 0, 2, live, "Coulomb friction with bodies", "")                           \
    FIELD(tool_adhesion_pa, 0, 200e3, live,                                                        \
          "shear stress between soil and bodies without pressure", "")                             \
    FIELD(shear_displacement_m, 0, 0.2, live, "Janosi and Hanamoto's K of soil as placed",         \
          "0: the shear stress is there at once")
// clang-format on

/// Relative density that loose soil takes up under a pressure: 0 at 1 kPa, 1 at 1 MPa, linear in
/// the logarithm between (the straight virgin compression line of soil mechanics).
double relative_density_under(double pressure_pa);

/// The inverse of it, 1 kPa to 1 MPa: Hvorslev's equivalent pressure of soil of that density.
double pressure_of_relative_density(double relative_density);

/// Bolton's relative dilatancy index of soil under less than 150 kPa: 5 I - 1 of a relative density
/// I, 0..4. 0: it shears without a change of volume, at kCriticalDensity.
double dilatancy_index(double relative_density);
inline constexpr double kCriticalDensity = 0.2;

/// Loose over compacted density of a soil whose range nobody gives. Sands have 0.78 to 0.85 between
/// their standard least and most dry densities. Smaller: soil sinks together more under a load.
inline constexpr double kLooseOverCompacted = 0.8;
/// Gives a material the range of a bed of one density: loose as placed, compacted 1 /
/// kLooseOverCompacted of it (docs/decisions/one_density.md); 4000 kg/m3 at most.
void set_range_of_loose_bed(MaterialDef& material);

/// Built-in materials. Angles, cohesions and weights lie in the ranges of the thesis (Table 6)
/// where it has the soil, else in those of the usual soil mechanics tables; see docs/materials.md
/// for each figure's source.
namespace materials {
/// The built-in of that name.
/// @{
MaterialDef dry_sand();
MaterialDef moist_sand();
MaterialDef sandy_loam();
MaterialDef loam();
MaterialDef clay();
MaterialDef gravel();
MaterialDef fine_sand();  ///< takes water; placed damp, as it is a day or two after rain
/// @}
/// All of them, in the order above.
std::span<const MaterialDef> all();
/// The built-in of that name, or an error that lists the names.
Result<MaterialDef> find(const std::string& name);
}  // namespace materials

}  // namespace bsoil
#pragma GCC visibility pop
