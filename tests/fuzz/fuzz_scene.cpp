#include "reading/scene_load.h"
#include "small_run.h"
#include "targets.h"

namespace bsoil::fuzz {

void fuzz_scene(Bytes bytes) {
    // Beside it lie the files that the seeds name.
    const auto scene = scene::parse_scene(text_of(bytes), BSOIL_FUZZ_FILES "/scene.toml");
    if (scene) run_if_small(*scene);
}

}  // namespace bsoil::fuzz
