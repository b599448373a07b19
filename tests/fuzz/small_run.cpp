#include "small_run.h"

#include <nlohmann/json.hpp>

#include "fuzz_target.h"
#include "reading/scene_load.h"
#include "run/scene_run.h"

namespace bsoil::fuzz {

void run_if_small(const scene::Scene& scene) {
    if (!scene.missing_data.empty() || scene.bodies.size() > 40) return;
    if (scene.soil) {
        const SoilDef def = scene::soil_def(scene);
        const Vec3 voxels = def.size_m * (1 / def.voxel_m);
        if (voxels.x * voxels.y * voxels.z > 20'000 || voxels.x * voxels.z > 2'000) return;
    }
    scene::RunDef def;
    def.backend = Backend::cpu;
    def.thread_count = 1;
    def.step_count = 2;
    auto run = scene::SceneRun::create(scene, def);
    if (!run) return;
    while (!(*run)->finished() && (*run)->step_count() < 2) (*run)->step();
    if ((*run)->has_soil()) {
        require((*run)->soil().totals().units == (*run)->totals_at_start().units,
                "soil is not conserved");
    }
    (*run)->summary();
}

std::unique_ptr<Soil> small_soil() {
    SoilDef def;
    def.size_m = {1, 1, 1};
    def.voxel_m = 0.1;
    def.backend = Backend::cpu;
    def.thread_count = 1;
    auto soil = Soil::create(def);
    require(soil.ok(), "no soil");
    return std::move(*soil);
}

}  // namespace bsoil::fuzz
