/// `bsoil view` of a build without SDL2 and Dear ImGui: says so.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "commands/commands.h"

namespace bsoil::command {

void add_view(CLI::App& app, int& exit_code) {
    CLI::App* command =
        app.add_subcommand("view", "a window on a scene; this build has none (see docs/viewer.md)");
    command->allow_extras();
    command->callback([&exit_code] {
        fmt::print(stderr,
                   "this build has no window: install libsdl2-dev and libimgui-dev, then configure "
                   "anew (BULLETSOIL_VIEWER says AUTO, ON or OFF)\n");
        exit_code = kCouldNotRun;
    });
}

}  // namespace bsoil::command
