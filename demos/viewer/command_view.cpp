/// `bsoil view`: a window on a scene.
#include <CLI/CLI.hpp>
#include <memory>

#include "commands/command_line.h"
#include "commands/commands.h"
#include "commands/opened_scene.h"
#include "viewer.h"

namespace bsoil::command {

void add_view(CLI::App& app, int& exit_code) {
    struct Arguments {
        OpenedScene opened;
        viewer::ViewDef def;
    };
    auto arguments = std::make_shared<Arguments>();
    CLI::App* command = app.add_subcommand(
        "view", "a window on a scene: look at it, drive it, dig in it; see docs/viewer.md");
    command->add_option("scene", arguments->opened.path, "the scene file (TOML)")->required();
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
    arguments->opened.device.add_to(*command);
    command->callback([arguments, &exit_code] {
        OpenedScene& opened = arguments->opened;
        viewer::ViewDef& def = arguments->def;
        if (!def.snapshot.empty()) {
            const auto known = scene::scene_of_snapshot(def.snapshot);
            if (!known) {
                exit_code = could_not(known.error());
                return;
            }
            opened.up = known->up;  // the run may have had --up
        }
        exit_code = opened.load();
        if (exit_code != kPassed) return;
        def.run.backend = opened.device.chosen();
        def.run.thread_count = opened.device.thread_count;
        def.run.mesh_backend = opened.device.chosen_mesher();
        const Status shown = viewer::view_scene(opened.scene, def);
        if (!shown) exit_code = could_not(shown.error());
    });
}

}  // namespace bsoil::command
