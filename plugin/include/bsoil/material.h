/// Soil materials: what a soil is made of, with the units soil mechanics uses.
#pragma once

#include <array>
#include <span>
#include <string>

#include "bsoil/result.h"

namespace bsoil {

/// One granular material. All values are checked by validate().
struct MaterialDef {
    std::string name = "dry_sand";      ///< unique within a soil, used by scenes and summaries
    double density_kg_m3 = 1600;        ///< bulk density as placed, 200..4000
    double friction_angle_rad = 0.576;  ///< angle of internal friction phi, 0..1.2 rad (33 deg)
    double cohesion_pa = 0;             ///< cohesion c, 0..200e3 Pa
    double loose_cohesion_fraction =
        0;  ///< share of the cohesion that soil keeps once it has been moved, 0..1
    double tool_friction = 0.4;                       ///< Coulomb friction with bodies, 0..2
    std::array<float, 3> color{0.76f, 0.66f, 0.45f};  ///< linear RGB, 0..1, for pictures only
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// Built-in materials. Angles, cohesions and weights lie in the ranges of the thesis (Table 6)
/// where it has the soil, else in those of the usual soil mechanics tables; see docs/materials.md
/// for each figure's source.
namespace materials {
MaterialDef dry_sand();
MaterialDef moist_sand();
MaterialDef sandy_loam();
MaterialDef loam();
MaterialDef clay();
MaterialDef gravel();
/// All of them, in the order above.
std::span<const MaterialDef> all();
/// The built-in of that name, or an error that lists the names.
Result<MaterialDef> find(const std::string& name);
}  // namespace materials

}  // namespace bsoil
