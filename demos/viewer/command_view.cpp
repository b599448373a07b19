/// `bsoil view`: a window on a scene.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "commands/command_line.h"
#include "commands/commands.h"
#include "reading/scene_load.h"
#include "viewer.h"

namespace bsoil::command {

void add_view(CLI::App& app, int& exit_code) {
    struct Arguments {
        std::string path;
        DeviceOptions device;
        viewer::ViewDef def;
    };
    auto arguments = std::make_shared<Arguments>();
    CLI::App* command = app.add_subcommand(
        "view", "a window on a scene: look at it, drive it, dig in it; see docs/viewer.md");
    command->add_option("scene", arguments->path, "the scene file (TOML)")->required();
    command->add_option("--from", arguments->def.snapshot,
                        "begin with this snapshot of the scene; Save writes it");
    command->add_option("--script", arguments->def.script,
                        "do what this file says instead of waiting for a person");
    command->add_option("--width", arguments->def.width, "of the window [pixels]")
        ->check(CLI::Range(320, 8192))
        ->capture_default_str();
    command->add_option("--height", arguments->def.height, "of the window [pixels]")
        ->check(CLI::Range(240, 8192))
        ->capture_default_str();
    command
        ->add_option("--samples", arguments->def.sample_count,
                     "samples per pixel; 0: 4, and 2 where OpenGL runs in software")
        ->check(CLI::Range(0, 8))
        ->capture_default_str();
    arguments->device.add_to(*command);
    command->callback([arguments, &exit_code] {
        auto scene = scene::load_scene(arguments->path);
        if (!scene) {
            fmt::print(stderr, "{}\n", scene.error());
            exit_code = kCouldNotRun;
            return;
        }
        if (!scene->missing_data.empty()) {
            fmt::print("SKIP {}: its data is not there\n", arguments->path);
            exit_code = kSkipped;
            return;
        }
        arguments->def.run.backend = arguments->device.chosen();
        arguments->def.run.thread_count = arguments->device.thread_count;
        arguments->def.run.mesh_backend = arguments->device.chosen_mesher();
        const Status shown = viewer::view_scene(*scene, arguments->def);
        if (shown) return;
        fmt::print(stderr, "{}\n", shown.error());
        exit_code = kCouldNotRun;
    });
}

}  // namespace bsoil::command
