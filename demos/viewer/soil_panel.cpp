#include "soil_panel.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

namespace bsoil::viewer {
namespace {

constexpr float kLabelWidth = 130;
constexpr float kDegrees = 180 / std::numbers::pi_v<float>;
constexpr float kHours = 3600;

/// A number on a slider: what is shown is `scale` times what the definition has. Ranges are those
/// of soils, narrower than the definition's; a slider takes a value typed in beyond them.
template <typename Def>
struct Slider {
    const char* label;
    double Def::*number;
    float low, high, scale;
    const char* format;
    bool of_water = false;  ///< only of a soil that takes some
    ImGuiSliderFlags flags = 0;
};

constexpr ImGuiSliderFlags kLog = ImGuiSliderFlags_Logarithmic;

constexpr Slider<MaterialDef> kMaterialSliders[] = {
    {"Friction angle", &MaterialDef::friction_angle_rad, 0, 60, kDegrees, "%.1f deg"},
    {"Cohesion", &MaterialDef::cohesion_pa, 0, 50, 1e-3f, "%.2f kPa", false, kLog},
    {"Kept when moved", &MaterialDef::loose_cohesion_fraction, 0, 1, 1, "%.2f"},
    {"When compacted", &MaterialDef::compaction_cohesion_ratio, 0, 0.3f, 1, "%.3f"},
    {"Dilatancy", &MaterialDef::dilatancy_angle_rad, 0, 5.7f, kDegrees, "%.1f deg"},
    {"Roughness", &MaterialDef::roughness, 0, 4, 1, "%.2f"},
    {"Viscosity", &MaterialDef::viscosity, 0, 1, 1, "%.2f"},
    {"Fall speed", &MaterialDef::fall_speed_m_s, 0, 20, 1, "%.1f m/s"},
    {"Tool friction", &MaterialDef::tool_friction, 0, 1.5f, 1, "%.2f"},
    {"Tool adhesion", &MaterialDef::tool_adhesion_pa, 0, 20, 1e-3f, "%.2f kPa", false, kLog},
    {"Janosi's K", &MaterialDef::shear_displacement_m, 0, 100, 1e3f, "%.1f mm"},
    {"Placed wet", &MaterialDef::placed_saturation, 0, 1, 1, "%.2f", true},
    {"Moist cohesion", &MaterialDef::moist_cohesion_pa, 0, 20, 1e-3f, "%.2f kPa", true, kLog},
    {"Conductivity", &MaterialDef::conductivity_m_s, 0, 100, 1e3f, "%.3f mm/s", true, kLog},
    {"Does not drain", &MaterialDef::residual_saturation, 0, 0.95f, 1, "%.2f", true},
};

constexpr Slider<SoilDef> kSoilSliders[] = {
    {"Rain", &SoilDef::rain_m_s, 0, 200, 1e3f * kHours, "%.1f mm/h", true, kLog},
    {"Drying", &SoilDef::drying_m_s, 0, 20, 1e3f * kHours, "%.2f mm/h", true, kLog},
    {"Floor drains", &SoilDef::floor_drainage_m_s, 0, 10, 1e3f, "%.3f mm/s", true, kLog},
    {"Groundwater", &SoilDef::water_table_m, 0, 5, 1, "%.2f m", true},
    {"Gusts", &SoilDef::gust, 0, 1, 1, "%.2f"},
    {"Gust size", &SoilDef::gust_size_m, 0.1f, 50, 1, "%.1f m", false, kLog},
    {"Shelter", &SoilDef::shelter_m, 0, 20, 1, "%.1f m"},
};

struct CountSlider {
    const char* label;
    int SoilDef::*count;
    int high;
};
constexpr CountSlider kCountSliders[] = {
    {"Propagation", &SoilDef::propagation_iterations, 32},
    {"Overflow passes", &SoilDef::overflow_passes, 16},
    {"Sub-steps", &SoilDef::substeps_max, 32},
};
constexpr size_t kWindAndOverflow = 2;

// Nothing that may change while the soil runs is without its slider.
namespace use {
enum Use { state, live, run, pace };
}
#define BSOIL_COUNT_LIVE(name, least, most, field_use, ...) +(use::field_use == use::live)
static_assert(std::size(kMaterialSliders) == 0 BSOIL_MATERIAL_FIELDS(BSOIL_COUNT_LIVE));
static_assert(std::size(kSoilSliders) + std::size(kCountSliders) + kWindAndOverflow ==
              0 BSOIL_SOIL_FIELDS(BSOIL_COUNT_LIVE));
#undef BSOIL_COUNT_LIVE

template <typename Def, size_t kCount>
bool lay_out(const Slider<Def> (&sliders)[kCount], Def& def, bool has_water, Widgets& widgets) {
    bool changed = false;
    for (const Slider<Def>& slider : sliders) {
        if (slider.of_water && !has_water) continue;
        double& number = def.*slider.number;
        float shown = static_cast<float>(number) * slider.scale;
        ImGui::SetNextItemWidth(-kLabelWidth);
        if (widgets.slider(slider.label, &shown, slider.low, slider.high, slider.format,
                           slider.flags)) {
            number = static_cast<double>(shown / slider.scale);
            changed = true;
        }
    }
    return changed;
}

bool lay_out_material(ViewState& state, Widgets& widgets) {
    std::vector<MaterialDef>& materials = state.soil.materials;
    auto& shown = state.material;
    shown = std::min(shown, materials.size() - 1);
    ImGui::SetNextItemWidth(-kLabelWidth);
    if (widgets.combo("Material", materials[shown].name.c_str())) {
        for (size_t m = 0; m < materials.size(); ++m) {
            if (widgets.selectable(materials[m].name.c_str(), m == shown)) shown = m;
        }
        ImGui::EndCombo();
    }
    MaterialDef& material = materials[shown];
    bool changed = lay_out(kMaterialSliders, material, material.pore_water_fraction > 0, widgets);
    ImGui::SetNextItemWidth(-kLabelWidth);
    changed |= ImGui::ColorEdit3("Colour", material.color.data(), ImGuiColorEditFlags_Float);
    return changed;
}

bool lay_out_wind(Vec3& wind_m_s) {
    std::array<float, 3> wind{static_cast<float>(wind_m_s.x), static_cast<float>(wind_m_s.y),
                              static_cast<float>(wind_m_s.z)};
    ImGui::SetNextItemWidth(-kLabelWidth);
    if (!ImGui::SliderFloat3("Wind [m/s]", wind.data(), -20, 20, "%.1f")) return false;
    wind_m_s = {wind[0], wind[1], wind[2]};
    return true;
}

bool lay_out_overflow(OverflowHeuristic& overflow) {
    constexpr const char* kNames[] = {"even", "up", "up_spread"};
    int chosen = static_cast<int>(overflow);
    ImGui::SetNextItemWidth(-kLabelWidth);
    if (!ImGui::Combo("Overflow", &chosen, kNames, static_cast<int>(std::size(kNames)))) {
        return false;
    }
    overflow = static_cast<OverflowHeuristic>(chosen);
    return true;
}

}  // namespace

bool lay_out_soil_parameters(ViewState& state, Widgets& widgets) {
    Widgets::heading("Soil");
    bool changed = false;
    if (widgets.button("As in the scene")) {
        state.soil = state.scene_soil;
        changed = true;
    }
    changed |= lay_out_material(state, widgets);
    Widgets::heading("Air and water");
    changed |= lay_out_wind(state.soil.wind_m_s);
    changed |= lay_out(kSoilSliders, state.soil,
                       scene::has_field(state.soil.materials, Field::moisture), widgets);
    Widgets::heading("Step");
    for (const CountSlider& slider : kCountSliders) {
        float count = static_cast<float>(state.soil.*slider.count);
        ImGui::SetNextItemWidth(-kLabelWidth);
        const int least = slider.count == &SoilDef::substeps_max ? 1 : 0;
        if (widgets.slider(slider.label, &count, static_cast<float>(least),
                           static_cast<float>(slider.high), "%.0f")) {
            const int now = static_cast<int>(std::lround(count));
            changed |= now != state.soil.*slider.count;
            state.soil.*slider.count = now;
        }
    }
    changed |= lay_out_overflow(state.soil.overflow);
    return changed;
}

}  // namespace bsoil::viewer
