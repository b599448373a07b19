/// `bsoil render` and `bsoil export` of a build without the renderer: neither is there.
#include "commands.h"

namespace bsoil::command {

void add_render(CLI::App&, int&) {}
void add_export(CLI::App&, int&) {}

}  // namespace bsoil::command
