/// What a scene says of a run's beginning, for snapshots: a run that goes on has it already.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bsoil/soil_def.h"
#include "scene/scene.h"

namespace bsoil::scene {

/// Of the soil's settings, `soil` as the scene has it (none: the scene has no soil), of sources,
/// sinks, fills and terrain, and of where and how fast bodies start.
std::vector<uint8_t> scene_origin(const Scene& scene, const SoilDef* soil);

/// Whether the scene says the same as the one that wrote `saved`. The error names the first key
/// that differs, both values and what to do, or says that `saved` is damaged.
Status check_origin(std::span<const uint8_t> saved, const Scene& scene, const SoilDef* soil);

}  // namespace bsoil::scene
