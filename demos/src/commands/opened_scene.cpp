#include "opened_scene.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "bsoil/device_info.h"
#include "command_line.h"
#include "reading/scene_load.h"

namespace bsoil::command {
namespace {

/// Leaves the soil out, and all that measures it.
void remove_soil(scene::Scene& scene) {
    if (scene.soil) scene.world.step_s = scene.soil->def.step_s;
    scene.soil.reset();
    scene.fills.clear();
    scene.terrains.clear();
    scene.probes.clear();
    std::erase_if(scene.checks, [](const scene::CheckItem& check) { return check.needs_soil(); });
}

Backend backend_of(const std::string& name) {
    if (name == "cpu") return Backend::cpu;
    return name == "gl" ? Backend::gl : Backend::automatic;
}

bool has_gpu() {
    const std::vector<DeviceInfo> all = list_devices();
    return std::any_of(all.begin() + 1, all.end(),  // the first one is the processor
                       [](const auto& entry) { return entry.usable && entry.hardware; });
}

}  // namespace

void DeviceOptions::add_to(CLI::App& app) {
    app.add_option("--backend", backend, "where the soil is computed")
        ->check(CLI::IsMember({"auto", "cpu", "gl"}))
        ->capture_default_str();
    app.add_option("--threads", thread_count, "threads of the CPU backend; 0: all cores")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    app.add_option("--mesher", mesher,
                   "where the soil's surface is meshed for pictures; without: as --backend")
        ->check(CLI::IsMember({"auto", "cpu", "gl"}));
}

Backend DeviceOptions::chosen() const { return backend_of(backend); }

std::optional<Backend> DeviceOptions::chosen_mesher() const {
    return mesher.empty() ? std::nullopt : std::optional(backend_of(mesher));
}

void OpenedScene::add_options(CLI::App& app) {
    app.add_option("scene", path, "the scene file (TOML)")->required();
    app.add_option("--steps", step_count, "stop after this many steps of the soil")
        ->check(at_least(1));
    app.add_option("--up", up, "turn the whole scene so that this axis points up")
        ->check(CLI::IsMember({"y", "z"}));
    app.add_flag("--without-soil", without_soil,
                 "leave the soil out: shows quickly whether bodies and motions are right");
    device.add_to(app);
}

int OpenedScene::load() {
    auto loaded = scene::load_scene(path);
    if (!loaded) {
        fmt::print(stderr, "{}\n", loaded.error());
        return kCouldNotRun;
    }
    scene = std::move(*loaded);
    if (!scene.missing_data.empty()) {
        fmt::print("SKIP {}: {} is not there; set BULLETSOIL_DATA to the folder that has it\n",
                   path, scene.missing_data.front().substr(sizeof("data:") - 1));
        return kSkipped;
    }
    for (const std::string& warning : scene.warnings) fmt::print(stderr, "{}\n", warning);
    if (!up.empty()) set_up_axis(scene, up == "y" ? UpAxis::y : UpAxis::z);
    if (without_soil) remove_soil(scene);
    return kPassed;
}

int OpenedScene::open() {
    if (const int loaded = load(); loaded != kPassed) return loaded;
    auto made = scene::SceneRun::create(scene, {.backend = device.chosen(),
                                                .thread_count = device.thread_count,
                                                .step_count = step_count,
                                                .mesh_backend = device.chosen_mesher()});
    if (!made) {
        fmt::print(stderr, "{}\n", made.error());
        return kCouldNotRun;
    }
    run = std::move(*made);
    for (const std::string& warning : run->warnings()) fmt::print(stderr, "{}\n", warning);
    if (run->has_soil() && run->soil().backend_name() == "gl" && !has_gpu()) {
        fmt::print(
            stderr,
            "no GPU here: OpenGL runs in software ({}), seconds a step. The CPU backend gives "
            "the same bits sooner: --backend cpu\n",
            run->soil().device_name());
    }
    return kPassed;
}

}  // namespace bsoil::command
