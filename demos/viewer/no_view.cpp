/// `bsoil view` of a build without SDL2 and Dear ImGui: says so.
#include "commands/command_line.h"
#include "commands/commands.h"

namespace bsoil::command {

void add_view(CLI::App& app, int& exit_code) {
    add_left_out(app, "view",
                 "this build has no window: install libsdl2-dev and libimgui-dev, then configure "
                 "anew (BULLETSOIL_VIEWER says AUTO, ON or OFF)",
                 exit_code);
}

}  // namespace bsoil::command
