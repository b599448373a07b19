/// What of a soil's definition may have been changed while it ran, for snapshots.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bsoil/soil_def.h"

namespace bsoil::scene {

/// The numbers that Soil::change() takes, and the colours, of a definition with `materials`.
std::vector<uint8_t> soil_settings(const SoilDef& def);

/// Puts them into a definition with as many `materials`; what they do not name keeps its value.
/// Their ranges are Soil::change()'s to check. Error: damaged.
Status set_soil_settings(std::span<const uint8_t> settings, SoilDef& def);

}  // namespace bsoil::scene
