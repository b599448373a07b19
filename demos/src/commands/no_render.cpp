/// `bsoil render` and `bsoil export` of a build without the renderer: they say so.
#include "command_line.h"
#include "commands.h"
#include "picture_times.h"

namespace bsoil::command {

void add_render(CLI::App& app, int& exit_code) {
    add_left_out(app, "render",
                 "this build has no pictures: it was made with BULLETSOIL_RENDER=OFF", exit_code);
}
void add_export(CLI::App& app, int& exit_code) {
    add_left_out(app, "export", "this build has no meshes: it was made with BULLETSOIL_RENDER=OFF",
                 exit_code);
}

Result<nlohmann::ordered_json> time_pictures(scene::SceneRun&, int) {
    return Error{
        "no pictures: this bsoil was built without its renderer; build with BULLETSOIL_RENDER=ON"};
}

}  // namespace bsoil::command
