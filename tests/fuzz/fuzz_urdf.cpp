#include "reading/scene_load.h"
#include "small_run.h"
#include "targets.h"

namespace bsoil::fuzz {

void fuzz_urdf(Bytes bytes) {
    Choices choices(bytes);
    const int how = choices.below(256);
    // Meshes are named by their path in BSOIL_FUZZ_FILES, which the folder above stands for.
    std::string scene = "[world]\nduration_s = 1\n[[robot]]\nname = \"r\"\nfile = \"robot.urdf\"\n";
    constexpr const char* kCollisions[] = {"hull", "components", "decompose", "mesh", "none"};
    scene += std::string("collision = \"") + kCollisions[how % 5] + "\"\n";
    if (how & 64) scene += "build = \"multibody\"\n";
    if (how & 128) scene += "fixed_base = true\n";
    scratch_file("robot.urdf", choices.rest());
    const auto read = scene::parse_scene(scene, scratch_path("scene.toml"));
    if (read) run_if_small(*read);
}

}  // namespace bsoil::fuzz
