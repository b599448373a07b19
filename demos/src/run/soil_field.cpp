#include "soil_field.h"

#include <algorithm>
#include <cmath>

namespace bsoil::scene {
namespace {

constexpr double kBareVolume = 0.02;  ///< of a voxel: less soil than this has no colour

}  // namespace

const char* field_name(Field field) {
    constexpr const char* kNames[kFieldCount] = {"none",     "density",   "velocity", "force",
                                                 "coverage", "disturbed", "activity", "material",
                                                 "moisture", "compaction"};
    return kNames[static_cast<size_t>(field)];
}

bool has_field(const std::vector<MaterialDef>& materials, Field field) {
    return std::ranges::any_of(materials, [field](const MaterialDef& m) {
        return field == Field::moisture     ? m.pore_water_fraction > 0
               : field == Field::compaction ? m.has_density_range()
                                            : true;
    });
}

std::array<float, 3> ramp_color(double fraction) {
    // Eight colours of matplotlib's viridis (public domain), as on the screen.
    constexpr double kRamp[8][3] = {
        {0.267, 0.005, 0.329}, {0.275, 0.194, 0.496}, {0.212, 0.359, 0.552}, {0.153, 0.497, 0.558},
        {0.122, 0.632, 0.531}, {0.290, 0.759, 0.428}, {0.622, 0.854, 0.226}, {0.993, 0.906, 0.144}};
    const double at = std::clamp(fraction, 0.0, 1.0) * 7;
    const int i = std::min(6, static_cast<int>(at));
    std::array<float, 3> color{};
    for (size_t c = 0; c < 3; ++c) {
        color[c] = static_cast<float>(
            std::pow(kRamp[i][c] + (at - i) * (kRamp[i + 1][c] - kRamp[i][c]), 2.2));
    }
    return color;
}

SoilField::SoilField(const Soil& soil, Field field, double low, double high)
    : soil_(soil), field_(field) {
    const auto& materials = soil.materials();
    const auto [lightest, heaviest] = std::minmax_element(
        materials.begin(), materials.end(),
        [](const auto& a, const auto& b) { return a.density_kg_m3 < b.density_kg_m3; });
    switch (field) {
        case Field::none:
            break;
        case Field::density:
            bar_ = {"bulk density", "kg/m\u00b3", 0.7 * lightest->density_kg_m3,
                    1.25 * heaviest->density_kg_m3};
            break;
        case Field::velocity:
            bar_ = {"speed", "m/s", 0, 1};
            break;
        case Field::force:
            bar_ = {"pushed by bodies", "", 0, 1};
            break;
        case Field::coverage:
            bar_ = {"covered by bodies", "", 0, 1};
            break;
        case Field::disturbed:
            bar_ = {"has been moved", "", 0, 1};
            break;
        case Field::activity:
            bar_ = {"active", "", 0, 1};
            break;
        case Field::moisture:
            bar_ = {"pores filled with water", "", 0, 1};
            break;
        case Field::compaction:
            bar_ = {"relative density: loose to compacted", "", 0, 1};
            break;
        case Field::material:
            bar_ = {"material", "", 0,
                    static_cast<double>(std::max<size_t>(1, materials.size() - 1))};
            break;
    }
    if (low != 0 || high != 0) {
        bar_.low = low;
        bar_.high = high;
    }
}

std::optional<double> SoilField::value(const VoxelSample& s) const {
    if (field_ == Field::coverage) return s.coverage + s.body_coverage;
    if (s.volume < kBareVolume) return {};
    const MaterialDef& material = soil_.materials()[static_cast<size_t>(s.material)];
    switch (field_) {
        case Field::compaction:
            if (!material.has_density_range() || !(s.density_kg_m3 > 0)) return {};
            return std::clamp(material.relative_density(s.density_kg_m3), 0.0, 1.0);
        case Field::density:
            return s.density_kg_m3;
        case Field::velocity:
            return length(s.velocity_m_s);
        case Field::force:
            return length(s.push);
        case Field::disturbed:
            return 1 - s.undisturbed;
        case Field::activity:
            return s.is_active ? 1.0 : 0.0;
        case Field::moisture:
            return s.saturation;
        case Field::material:
            return s.material;
        default:
            return {};
    }
}

double SoilField::fraction(double value) const {
    return std::clamp((value - bar_.low) / std::max(1e-12, bar_.high - bar_.low), 0.0, 1.0);
}

std::array<float, 3> SoilField::color(double value, const VoxelSample& sample) const {
    if (field_ == Field::material) {
        return soil_.materials()[static_cast<size_t>(sample.material)].color;
    }
    return ramp_color(fraction(value));
}

}  // namespace bsoil::scene
