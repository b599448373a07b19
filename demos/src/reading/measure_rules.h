/// What a scene measures has to be there to measure, beyond what the schema's table says of each
/// key.
#pragma once

#include <vector>

#include "scene/scene.h"
#include "scene/scene_error.h"

namespace bsoil::scene {

/// The mistakes in times, places and limits of [record], probes and checks.
std::vector<SchemaError> measure_errors(const Scene& scene);

}  // namespace bsoil::scene
