/// What pictures of a scene take: for `bsoil bench`.
#pragma once

#include <nlohmann/json.hpp>

#include "bsoil/result.h"
#include "run/scene_run.h"

namespace bsoil::command {

/// Takes `count` pictures of 1280 x 720 pixels, each after a step of the run, prints what a picture
/// takes pass by pass, and returns the same. An error where there is no renderer or no OpenGL.
Result<nlohmann::ordered_json> time_pictures(scene::SceneRun& run, int count);

}  // namespace bsoil::command
