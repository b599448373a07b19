#include "soil/slip_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/layout.h"
#include "soil/water.h"

namespace bsoil {
namespace {

/// Driving minus resisting force on the plane at theta, per metre of thickness: positive when F
/// < 1. Thesis (1)-(3).
double unbalanced(const MaterialDef& m, double gamma, double h, double dx, double theta) {
    const double weight = (h - std::tan(theta) * dx) * dx * gamma / 2;            // thesis (2)
    const double length = dx * std::sqrt(1 + std::tan(theta) * std::tan(theta));  // thesis (3)
    return weight * std::sin(theta) -
           (m.cohesion_pa * length + weight * std::cos(theta) * std::tan(m.friction_angle_rad));
}

/// A steeper peak, which phi and 4 units of dilatancy index could come to, counts as this: as steep
/// as any phi may be.
constexpr double kPeakMost = 1.2;

/// Cohesion over the weight of a voxel's height of soil [Pa], as kTableStrength.
int32_t strength_q16(double cohesion_pa, double weight_pa) {
    const double strength = weight_pa > 0 ? std::min(cohesion_pa / weight_pa * layout::kVoxelFull,
                                                     1.0 * layout::kStrengthMost)
                                          : 0;
    return strength < layout::kStrengthLeast ? 0 : static_cast<int32_t>(std::lround(strength));
}

}  // namespace

SlipWedge find_slip_wedge(const MaterialDef& m, double gravity, double h, double dx) {
    SlipWedge wedge;
    const double gamma = m.density_kg_m3 * gravity;
    const double steepest = std::atan2(h, dx);
    double theta = m.friction_angle_rad;
    if (steepest <= theta || gamma <= 0) return wedge;
    if (m.cohesion_pa > 0) {
        // thesis (4): the flattest plane on which F = 1; everything above it slides.
        constexpr int kScan = 400;
        double low = theta, high = -1;
        for (int i = 1; i < kScan; ++i) {
            const double probe =
                m.friction_angle_rad + (steepest - m.friction_angle_rad) * i / kScan;
            if (unbalanced(m, gamma, h, dx, probe) > 0) {
                high = probe;
                break;
            }
            low = probe;
        }
        if (high < 0) return wedge;
        for (int i = 0; i < 60; ++i) {
            const double middle = (low + high) / 2;
            (unbalanced(m, gamma, h, dx, middle) > 0 ? high : low) = middle;
        }
        theta = high;
    }
    wedge.fails = true;
    wedge.theta_rad = theta;
    wedge.height_m = h - std::tan(theta) * dx;
    const double t = std::tan(theta) * dx;
    const double force =
        // thesis (8): the sum of the shear stresses, (5) to (7), over ever thinner segments of the
        // wedge
        gamma * dx * dx / 4 * std::log((h * h + dx * dx) / (t * t + dx * dx)) * std::cos(theta) +
        gamma * dx / 2 * (h - t - dx * (std::atan(h / dx) - theta)) * std::sin(theta);
    const double weight = wedge.height_m * dx * gamma / 2;
    wedge.acceleration_m_s2 = weight > 0 ? std::max(0.0, force / weight * gravity) : 0;
    return wedge;
}

int32_t friction_speed(double friction, const SoilDef& def) {
    const double change = friction * def.gravity_m_s2 * def.step_s * (def.step_s / def.voxel_m);
    // Soil is never faster, so that more makes no difference.
    return static_cast<int32_t>(
        std::lround(std::min(change * layout::kOneQ16, 1.0 * layout::kSpeedMost)));
}

int32_t seepage_q4(double conductivity_m_s, const SoilDef& def) {
    const double voxels = conductivity_m_s * Water::period_s(def) / def.voxel_m;
    return static_cast<int32_t>(
        std::lround(std::min(1.0, voxels) * Water::kVoxelUnits * layout::kOneQ4));
}

int32_t suction_q16(const MaterialDef& m, const SoilDef& def) {
    const double suction_m =
        m.friction_angle_rad > 0
            ? 4 * m.moist_cohesion_pa / std::tan(m.friction_angle_rad) / (1000 * def.gravity_m_s2)
            : 0;
    return static_cast<int32_t>(std::lround(
        std::min(suction_m / def.voxel_m * layout::kOneQ16, 1.0 * layout::kSuctionMost)));
}

std::vector<int32_t> make_slip_table(const MaterialDef& m, const SoilDef& def) {
    using namespace layout;
    std::vector<int32_t> table(kTableWords, 0);
    for (int i = 0; i < kSlipEntries; ++i) {
        const double slope = i / 16.0;
        const SlipWedge wedge =
            find_slip_wedge(m, def.gravity_m_s2, slope * def.voxel_m, def.voxel_m);
        // Without cohesion the wedge is linear in the slope on both sides of phi, so that the table
        // is exact there.
        const double height = wedge.fails         ? wedge.height_m / def.voxel_m
                              : m.cohesion_pa > 0 ? -1.0
                                                  : slope - std::tan(m.friction_angle_rad);
        const double acceleration = wedge.acceleration_m_s2 * def.step_s * def.step_s / def.voxel_m;
        // The steeper the higher: slip_soil relies on it, and the search for the plane is no proof.
        const auto words = static_cast<int32_t>(std::lround(height * kVoxelFull));
        int32_t* wedges = &table[kTableWedge];
        wedges[i] = i > 0 ? std::max(wedges[i - 1], words) : words;
        table[kTableAcceleration + i] =
            static_cast<int32_t>(std::lround(std::min(acceleration, 1.0) * kVoxelFull));
    }
    table[kTableFriction] =
        static_cast<int32_t>(std::lround(std::tan(m.friction_angle_rad) * kVoxelFull));
    const double weight = m.density_kg_m3 * def.gravity_m_s2 * def.voxel_m;
    table[kTableStrength] = strength_q16(m.cohesion_pa, weight);
    table[kTableTool] = friction_speed(m.tool_friction, def);
    table[kTablePores] = static_cast<int32_t>(std::lround(m.pore_water_fraction * kOneQ16));
    table[kTableMoist] = weight > 0
                             ? static_cast<int32_t>(std::lround(std::min(
                                   m.moist_cohesion_pa / weight * kVoxelFull, 1.0 * kStrengthMost)))
                             : 0;
    table[kTableResidual] = static_cast<int32_t>(std::lround(m.residual_saturation * kOneQ16));
    table[kTableSeepage] = seepage_q4(m.conductivity_m_s, def);
    table[kTableSuction] = suction_q16(m, def);
    table[kTableRoughness] = static_cast<int32_t>(std::lround(m.roughness * kOneQ16));
    table[kTableViscosity] = static_cast<int32_t>(std::lround(m.viscosity * kOneQ16));
    const double drag = m.viscosity < 1 ? -std::log1p(-m.viscosity) * def.step_s * 60 : kDragMost;
    table[kTableDrag] =
        static_cast<int32_t>(std::lround(std::min(drag * kOneQ16, 1.0 * kDragMost)));
    const double fall_speed = m.fall_speed_m_s;
    const double air = fall_speed > 0 ? def.gravity_m_s2 * def.step_s / fall_speed : 0;
    table[kTableAir] = static_cast<int32_t>(std::lround(std::min(air * kOneQ16, 1.0 * kAirMost)));
    const double passive = std::tan(std::numbers::pi / 4 - m.friction_angle_rad / 2);
    table[kTablePassive] = static_cast<int32_t>(std::lround(passive * kVoxelFull));
    const double densest = m.has_density_range() ? m.compacted_density_kg_m3 : m.density_kg_m3;
    const double loosest = m.has_density_range() ? m.loose_density_kg_m3 : m.density_kg_m3;
    const auto volume_q16 = [](double density_kg_m3) {
        return static_cast<int32_t>(std::lround(kReferenceDensity / density_kg_m3 * kVoxelFull));
    };
    table[kTableHeld] = volume_q16(loosest);
    table[kTableHeldLeast] = volume_q16(densest);
    if (m.has_density_range()) {
        table[kTableLoose] = table[kTableHeld];
        table[kTableCompacted] = table[kTableHeldLeast];
    }
    table[kTableCritical] = m.dilatancy_angle_rad > 0
                                ? static_cast<int32_t>(std::lround(kCriticalDensity * kOneQ16))
                                : 0;
    return table;
}

std::vector<int32_t> peak_frictions(const MaterialDef& m) {
    using namespace layout;
    std::vector<int32_t> frictions;
    for (int i = 0; i < kDensityEntries; ++i) {
        const double angle_rad =
            m.friction_angle_rad +
            m.dilatancy_angle_rad * dilatancy_index(1.0 * i / (kDensityEntries - 1));
        frictions.push_back(static_cast<int32_t>(
            std::lround(std::tan(std::min(angle_rad, kPeakMost)) * kVoxelFull)));
    }
    return frictions;
}

std::vector<int32_t> regained_strengths(const MaterialDef& m, const SoilDef& def,
                                        const int32_t* loose) {
    using namespace layout;
    if (m.compaction_cohesion_ratio == 0) {
        return std::vector<int32_t>(kDensityEntries, loose[kTableStrength]);
    }
    std::vector<int32_t> strengths;
    for (int i = 0; i < kDensityEntries; ++i) {
        const double density = 1.0 * i / (kDensityEntries - 1);  // relative
        const double volume =
            std::lerp(1 / m.loose_density_kg_m3, 1 / m.compacted_density_kg_m3, density);
        strengths.push_back(
            strength_q16(m.moved_cohesion_pa(density), def.gravity_m_s2 * def.voxel_m / volume));
    }
    return strengths;
}

}  // namespace bsoil
