/// Soil given by Bekker's, Mohr and Coulomb's and Janosi's parameters, as bevameter tests give them
/// and as Chrono's SCM takes them, turned into a material. See docs/bekker_import.md.
#pragma once

#include <optional>
#include <vector>

#include "bsoil/material.h"
#include "bsoil/result.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Bekker's pressure under a plate, p = (kc / b + kphi) z^n, with b the radius of a circular plate
/// or the width of a long one. The strength in shear is c + sigma tan phi. A share 1 - exp(-j / K)
/// of it has developed after a displacement j. SCM's elastic stiffness and damping have no part
/// here: soil does not spring back.
struct BekkerSoil {
    double kphi_pa_m_n = 0;  ///< frictional modulus kphi [Pa/m^n = N/m^(n+2)], 0..1e9
    /// cohesive modulus kc [Pa/m^(n-1) = N/m^(n+1)], -1e8..1e8; fits of measurements give negative
    /// ones, which are accepted as long as every plate's pressure is positive
    double kc_pa_m_n1 = 0;
    double n = 1;                       ///< exponent of sinkage, 0..2.5
    double cohesion_pa = 0;             ///< Mohr cohesion c, 0..200e3 Pa
    double friction_angle_rad = 0.576;  ///< Mohr friction angle phi, 0..1.2 rad
    double shear_displacement_m = 0;    ///< Janosi's K, 0..0.2 m; 0: shear stress is there at once
    std::optional<double> density_kg_m3;  ///< bulk density where it is known, 200..3200
    bool operator==(const BekkerSoil&) const = default;  ///< number by number
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// Where the two bearing curves are compared, and what the search may choose.
struct BekkerOptions {
    double gravity_m_s2 = 9.81;  ///< where the parameters were measured, 0.1..30
    std::vector<double> plate_radii_m{0.025, 0.075, 0.15};  ///< 1 to 64 circular plates, 1 mm..10 m
    std::vector<double> sinkages_m{0.01, 0.02, 0.03,
                                   0.05, 0.1,  0.15};  ///< 1 to 64 sinkages, 0.1 mm..10 m
    /// Bulk densities a soil of unknown density may have, 200..3200 kg/m3, rising. Those of mineral
    /// soils; for snow or peat give the density itself
    double density_least_kg_m3 = 1200, density_most_kg_m3 = 2000;
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// Both bearing curves at one plate and sinkage.
struct BearingComparison {
    double plate_radius_m = 0, sinkage_m = 0;
    double bekker_pa = 0, soil_pa = 0;
    /// soil_pa over bekker_pa, less 1.
    double relative_error() const { return soil_pa / bekker_pa - 1; }
};

/// A material and how far its bearing is from Bekker's.
struct BekkerTranslation {
    MaterialDef material;                        ///< dry_sand's name, color and tool friction
    double relative_density = 0;                 ///< as placed, 0..1
    std::vector<BearingComparison> comparisons;  ///< every plate at every sinkage, plates outermost
    double median_error = 0;                     ///< of the magnitudes of the relative errors
    double largest_error = 0;                    ///< the same, of the worst plate and sinkage
};

/// The material whose own bearing, of level plates pressed down slowly into soil as placed, comes
/// nearest to Bekker's: least mean square of the logarithm of their ratio. Cohesion, friction angle
/// and K are taken as they are given; what is searched for is the density as placed, unless it is
/// given, and the relative density. The same input gives the same material. Fails on a value out of
/// range, naming it. Some 30 ms of computing, no simulation.
Result<BekkerTranslation> translate(const BekkerSoil& soil, const BekkerOptions& options = {});

/// The material's own bearing of a level circular plate, in soil as placed [Pa]: the normal limit
/// of its elements. Compaction by the plate itself is not in it.
double plate_bearing_pa(const MaterialDef& material, double gravity_m_s2, double plate_radius_m,
                        double sinkage_m);

}  // namespace bsoil
#pragma GCC visibility pop
