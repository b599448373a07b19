/// `bsoil render` and `bsoil export` of a build without the renderer: neither is there.
#include "commands.h"
#include "picture_times.h"

namespace bsoil::command {

void add_render(CLI::App&, int&) {}
void add_export(CLI::App&, int&) {}

Result<nlohmann::ordered_json> time_pictures(scene::SceneRun&, int) {
    return Error{"no pictures: this bsoil was built without its renderer"};
}

}  // namespace bsoil::command
