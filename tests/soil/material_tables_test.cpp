// The tables of docs/materials.md, printed: docs.figures compares them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "bsoil/material.h"

namespace bsoil::material_tables_test {
namespace {

double degrees(double angle_rad) { return angle_rad * 180 / std::numbers::pi; }

TEST(MaterialTables, properties) {
    for (const MaterialDef& m : materials::all()) {
        fmt::print("| `{}` | {:.0f} | {:.0f} | {:.0f} | {:.2f} |\n", m.name, m.density_kg_m3,
                   degrees(m.friction_angle_rad), m.cohesion_pa, m.tool_friction);
        EXPECT_TRUE(m.validate()) << m.name;
    }
}

TEST(MaterialTables, densities) {
    for (const MaterialDef& m : materials::all()) {
        fmt::print("| `{}` | {:.0f} | {:.0f} | {:.0f} | {:.1f} % |\n", m.name,
                   m.loose_density_kg_m3, m.density_kg_m3, m.compacted_density_kg_m3,
                   100 * (m.density_kg_m3 / m.loose_density_kg_m3 - 1));
        // The usual earthmoving tables: 8 to 12 % denser than in the bank.
        EXPECT_NEAR(m.compacted_density_kg_m3 / m.density_kg_m3, 1.10, 0.021) << m.name;
    }
}

TEST(MaterialTables, moisture) {
    for (const MaterialDef& m : materials::all()) {
        if (m.pore_water_fraction == 0) continue;
        const double porosity = m.pore_water_fraction * m.density_kg_m3 / 1000;
        const double fringe_m =
            4 * m.moist_cohesion_pa / std::tan(m.friction_angle_rad) / (1000 * 9.81);
        fmt::print("| `{}` | {:.3f} | {:.2f} | {:.0f} | {:.3g} | {:.3f} | {:.2f} | {:.2f} |\n",
                   m.name, m.pore_water_fraction, m.placed_saturation, m.moist_cohesion_pa,
                   m.conductivity_m_s * 1000, m.residual_saturation, porosity, fringe_m);
        EXPECT_NEAR(m.density_kg_m3 / (1 - porosity), 2650, 10) << "grains of quartz";
        EXPECT_GE(m.placed_saturation, m.residual_saturation);
    }
}

struct Range {
    double least, most;
};

/// Thesis, Table 6, in SI units.
struct ThesisRow {
    const char* title;
    MaterialDef ours;
    Range friction_deg, cohesion_kpa, density_kg_m3;
};

std::string range_text(Range range) {
    return range.least == range.most ? fmt::format("{:.3g}", range.least)
                                     : fmt::format("{:.4g} to {:.4g}", range.least, range.most);
}
/// Bold where it is outside.
std::string beside(Range range, double ours) {
    const std::string text = fmt::format("{:.4g}", ours);
    return ours < range.least || ours > range.most ? "**" + text + "**" : text;
}

TEST(MaterialTables, lie_in_the_ranges_of_the_thesis) {
    for (const ThesisRow& row :
         {ThesisRow{"dry sand", materials::dry_sand(), {26, 33}, {0, 0}, {1900, 2000}},
          {"sandy loam", materials::sandy_loam(), {14, 26}, {0, 19.6}, {1800, 2000}},
          {"loam", materials::loam(), {10, 28}, {4.9, 49}, {1800, 2100}}}) {
        const double friction_deg = std::round(degrees(row.ours.friction_angle_rad));
        const double cohesion_kpa = row.ours.cohesion_pa / 1000;
        fmt::print("| {} | {} | {} | {} | {} | {} | {} |\n", row.title,
                   range_text(row.friction_deg), beside(row.friction_deg, friction_deg),
                   range_text(row.cohesion_kpa), beside(row.cohesion_kpa, cohesion_kpa),
                   range_text(row.density_kg_m3),
                   beside(row.density_kg_m3, row.ours.density_kg_m3));
    }
}

}  // namespace
}  // namespace bsoil::material_tables_test
