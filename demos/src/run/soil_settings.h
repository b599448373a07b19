/// What of a soil's definition may have been changed while it ran, for snapshots.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bsoil/soil_def.h"

namespace bsoil::scene {

struct NamedNumber {
    std::string name;  ///< "rain_m_s", "wind_m_s.x"; of the first material "0.cohesion_pa"
    double value = 0;
};

/// The numbers that Soil::change() takes, and the colours, of a definition with `materials`.
std::vector<NamedNumber> soil_numbers(const SoilDef& def);
/// The same as bytes.
std::vector<uint8_t> soil_settings(const SoilDef& def);

/// Puts them into a definition with as many `materials`; what they do not name keeps its value.
/// Their ranges are Soil::change()'s to check. Error: damaged.
Status set_soil_settings(std::span<const uint8_t> settings, SoilDef& def);

}  // namespace bsoil::scene
