/// `bsoil view`: a window on a scene that runs, to look at, to drive and to dig in.
#pragma once

#include <string>

#include "run/scene_run.h"

namespace bsoil::viewer {

/// How a scene is shown.
struct ViewDef {
    scene::RunDef run;
    int width = 1280, height = 720;
    std::string script;    ///< file of a ViewScript; empty: a person
    std::string snapshot;  ///< state to begin with; empty: the scene's start. F9 loads it again
    int sample_count = 0;  ///< per pixel; 0: 4, in software 2
};

/// Shows the scene until the window is closed or the script has ended. The error says what is
/// missing or what the script could not do.
Status view_scene(const scene::Scene& scene, const ViewDef& def);

}  // namespace bsoil::viewer
