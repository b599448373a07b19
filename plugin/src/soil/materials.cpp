#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bsoil/material.h"
#include "soil/def_fields.h"

namespace bsoil {

Status MaterialDef::validate() const {
    if (name.empty()) return Error{"material name is empty; give it one"};
    const std::string where = "material '" + name + "': ";
    if (Status status = check_numbers(*this, where); !status) return status;
    if (loose_density_kg_m3 == 0 && compacted_density_kg_m3 == 0) {
        for (const auto& [field, value] :
             {std::pair{"compaction_cohesion_ratio", compaction_cohesion_ratio},
              {"dilatancy_angle_rad", dilatancy_angle_rad}}) {
            if (value == 0) continue;
            return Error{where + field + " is " + std::to_string(value) +
                         ", but its density does not change; give loose_density_kg_m3 and "
                         "compacted_density_kg_m3"};
        }
        return Done{};
    }
    if (loose_density_kg_m3 < 100 || loose_density_kg_m3 > density_kg_m3 ||
        compacted_density_kg_m3 < density_kg_m3 || loose_density_kg_m3 >= compacted_density_kg_m3 ||
        loose_density_kg_m3 < compacted_density_kg_m3 / 2) {
        return Error{where + "densities are " + std::to_string(loose_density_kg_m3) + " loose, " +
                     std::to_string(density_kg_m3) + " placed, " +
                     std::to_string(compacted_density_kg_m3) +
                     " compacted [kg/m3]: must rise in this order, loose at least half of "
                     "compacted and at least 100; or give neither loose nor compacted"};
    }
    return Done{};
}

// Between the weight of a spade's depth of soil and the pressure that compacted densities are
// given for (MaterialDef::compacted_density_kg_m3), linear in the logarithm as compression tests
// are drawn. Ours for all materials. A higher first pressure: light bodies leave soil loose; a
// higher second one: machines compact less.
constexpr double kLoosePa = 1e3, kCompactedPa = 1e6;

double relative_density_under(double pressure_pa) {
    return pressure_pa > kLoosePa
               ? std::min(1.0, std::log(pressure_pa / kLoosePa) / std::log(kCompactedPa / kLoosePa))
               : 0;
}

double pressure_of_relative_density(double relative_density) {
    return kLoosePa * std::pow(kCompactedPa / kLoosePa, std::clamp(relative_density, 0.0, 1.0));
}

double MaterialDef::moved_cohesion_pa(double at_relative_density) const {
    const double kept_pa = cohesion_pa * loose_cohesion_fraction;
    if (compaction_cohesion_ratio == 0) return kept_pa;
    const double regained_pa =
        compaction_cohesion_ratio * pressure_of_relative_density(at_relative_density);
    return std::max(kept_pa, std::min(regained_pa, cohesion_pa));
}

void set_range_of_loose_bed(MaterialDef& material) {
    constexpr double kMost_kg_m3 = 4000;  // what MaterialDef takes
    const bool has_room = material.density_kg_m3 < kMost_kg_m3;
    material.loose_density_kg_m3 = has_room ? material.density_kg_m3 : 0;
    material.compacted_density_kg_m3 =
        has_room ? std::min(kMost_kg_m3, material.density_kg_m3 / kLooseOverCompacted) : 0;
}

double dilatancy_index(double relative_density) {
    return std::clamp(relative_density / kCriticalDensity - 1, 0.0, 4.0);
}

namespace materials {
namespace {

struct Densities {
    double loose, placed, compacted;  ///< kg/m3
};

MaterialDef make(const char* name, Densities density, double friction_deg, double cohesion_pa,
                 double tool_friction, std::array<float, 3> color) {
    return {.name = name,
            .density_kg_m3 = density.placed,
            .loose_density_kg_m3 = density.loose,
            .compacted_density_kg_m3 = density.compacted,
            .friction_angle_rad = friction_deg * std::numbers::pi / 180,
            .cohesion_pa = cohesion_pa,
            .tool_friction = tool_friction,
            .color = color};
}

/// Sand shears along a band of some 15 grains, 2 mm long where nobody says how large they are
/// (docs/decisions/missing_properties.md). Longer: wheels slip more before they pull.
MaterialDef with_slip_band(MaterialDef sand) {
    sand.shear_displacement_m = 0.002;
    return sand;
}

struct Moisture {
    double pore_water_fraction, placed_saturation, moist_cohesion_pa, conductivity_m_s,
        residual_saturation;
};

MaterialDef with_water(MaterialDef material, Moisture moisture) {
    material.pore_water_fraction = moisture.pore_water_fraction;
    material.placed_saturation = moisture.placed_saturation;
    material.moist_cohesion_pa = moisture.moist_cohesion_pa;
    material.conductivity_m_s = moisture.conductivity_m_s;
    material.residual_saturation = moisture.residual_saturation;
    return material;
}

// Sources of the figures: docs/materials.md. Colours are linear, and as far apart as dry, moist and
// loamy soils are to the eye.
const std::array<MaterialDef, 7>& table() {
    static const std::array<MaterialDef, 7> kTable = {
        with_slip_band(make("dry_sand", {1430, 1600, 1750}, 33, 0, 0.40, {0.70f, 0.57f, 0.34f})),
        with_slip_band(
            make("moist_sand", {1540, 1750, 1900}, 34, 1000, 0.42, {0.42f, 0.31f, 0.17f})),
        make("sandy_loam", {1480, 1850, 2050}, 26, 2000, 0.40, {0.26f, 0.15f, 0.075f}),
        make("loam", {1520, 1900, 2090}, 25, 6000, 0.38, {0.115f, 0.07f, 0.04f}),
        make("clay", {1440, 1950, 2150}, 20, 20000, 0.35, {0.38f, 0.15f, 0.08f}),
        make("gravel", {1600, 1800, 1960}, 38, 0, 0.45, {0.42f, 0.42f, 0.42f}),
        with_water(with_slip_band(
                       make("fine_sand", {1350, 1510, 1650}, 33, 0, 0.40, {0.80f, 0.74f, 0.62f})),
                   {0.285, 0.21, 640, 8.25e-5, 0.105}),
    };
    return kTable;
}

}  // namespace

MaterialDef dry_sand() { return table()[0]; }
MaterialDef moist_sand() { return table()[1]; }
MaterialDef sandy_loam() { return table()[2]; }
MaterialDef loam() { return table()[3]; }
MaterialDef clay() { return table()[4]; }
MaterialDef gravel() { return table()[5]; }
MaterialDef fine_sand() { return table()[6]; }

std::span<const MaterialDef> all() { return table(); }

Result<MaterialDef> find(const std::string& name) {
    std::string names;
    for (const MaterialDef& material : table()) {
        if (material.name == name) return material;
        names += (names.empty() ? "" : ", ") + material.name;
    }
    return Error{"material '" + name + "' is not built in; there are " + names};
}

}  // namespace materials
}  // namespace bsoil
