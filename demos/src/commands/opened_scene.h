/// What the commands that run a scene have in common: its file and the options that shape its run.
#pragma once

#include <memory>
#include <string>

#include "commands.h"
#include "run/scene_run.h"

namespace bsoil::command {

/// Arguments of a scene's run, and the scene once opened.
struct OpenedScene {
    std::string path;
    std::string up;
    long long step_count = 0;
    bool without_soil = false;
    DeviceOptions device;
    scene::Scene scene;
    std::unique_ptr<scene::SceneRun> run;

    void add_options(CLI::App& app);
    /// Loads the scene, turned as `up` says. Prints what is wrong or odd; kPassed, kCouldNotRun or
    /// kSkipped.
    int load();
    /// Loads the scene and makes its run. Prints what is wrong; kPassed, kCouldNotRun or kSkipped.
    int open();
};

}  // namespace bsoil::command
