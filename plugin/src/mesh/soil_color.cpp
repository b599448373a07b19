#include "mesh/soil_color.h"

#include <algorithm>
#include <cmath>

namespace bsoil::mesh {
namespace {

constexpr float kWearSteps = 4;  ///< from settled to moved, and to compacted
constexpr float kWetSteps = 8;   ///< from dry to full

/// Moved soil: what was inside, moister. Compacted soil: pressed smooth, so that it shines.
constexpr float kMovedBrightness = 0.80f, kMovedSaturation = 1.15f;
constexpr float kCompactedBrightness = 1.15f, kCompactedSaturation = 0.70f;
/// Wet soil: light is caught between grain and water, so that it sends back half of it (Angstrom
/// 1925).
constexpr float kWetBrightness = 0.5f;
/// Of the way from the density as placed to the compacted one, which takes 1 MPa: what the wheels
/// of a vehicle leave in poured sand looks fully compacted.
constexpr double kCompactedShare = 0.5;

float in_steps(double value, float steps) {
    return std::round(static_cast<float>(std::clamp(value, 0.0, 1.0)) * steps) / steps;
}

/// Brighter or darker, and nearer to grey or further from it.
Color toned(const Color& color, float brightness, float saturation) {
    const float grey = 0.2126f * color[0] + 0.7152f * color[1] + 0.0722f * color[2];
    Color result;
    for (size_t c = 0; c < 3; ++c) {
        const float tone = brightness * (grey + saturation * (color[c] - grey));
        result[c] = std::clamp(tone, 0.0f, 1.0f);
    }
    return result;
}

}  // namespace

float wet_brightness(float saturation) { return 1 + saturation * (kWetBrightness - 1); }

uint8_t wetness_of(double saturation) {
    return static_cast<uint8_t>(std::round(255 * in_steps(saturation, kWetSteps)));
}

Color worn_color(const MaterialDef& material, const VoxelSample& sample) {
    if (sample.volume <= 0) return material.color;
    double compaction = 0;
    if (material.has_density_range()) {
        compaction = (sample.density_kg_m3 - material.density_kg_m3) /
                     std::max(1.0, kCompactedShare *
                                       (material.compacted_density_kg_m3 - material.density_kg_m3));
    }
    const float moved = in_steps(1 - sample.undisturbed, kWearSteps);
    const float compacted = in_steps(compaction, kWearSteps);
    const auto mixed = [](float share, float full) { return 1 + share * (full - 1); };
    const float wet = in_steps(sample.saturation, kWetSteps);
    if (moved == 0 && compacted == 0 && wet == 0) return material.color;
    const float loose = moved * std::max(0.0f, 1 - 2 * compacted);  // pressed soil shows no grain
    return toned(material.color,
                 mixed(loose, kMovedBrightness) * mixed(compacted, kCompactedBrightness) *
                     wet_brightness(wet),
                 mixed(loose, kMovedSaturation) * mixed(compacted, kCompactedSaturation));
}

}  // namespace bsoil::mesh
