/// `bsoil info` and `bsoil scene-keys`: what there is to run on, and what a scene may say.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <numbers>

#include "bsoil/backend_choice.h"
#include "bsoil/device_info.h"
#include "bsoil/limits.h"
#include "commands.h"
#include "reading/scene_load.h"

namespace bsoil::command {
namespace {

int info(const DeviceOptions& options) {
    fmt::print("devices\n");
    for (const DeviceInfo& entry : list_devices()) {
        fmt::print("  {} {}{}\n      {}\n", entry.usable ? "+" : "-", entry.name,
                   entry.hardware ? "" : " (software)", entry.detail);
    }
    const auto chosen = choose_backend(options.chosen(), options.thread_count);
    if (!chosen) {
        fmt::print(stderr, "backend {}: {}\n", options.backend, chosen.error());
        return kCouldNotRun;
    }
    fmt::print("backend\n  {} on {}, {} threads: {}\n", chosen->backend_name, chosen->device_name,
               chosen->thread_count, chosen->reason);
    fmt::print(
        "limits\n  materials {}, grid height {} voxels, grid side {} voxels,\n"
        "  bodies a step {}, contact voxels a step {}, faces of a hull {}\n",
        limits::kMaterialCapacity, limits::kGridHeightMax, limits::kGridSideMax,
        limits::kBodyCapacity, limits::kContactCapacity, limits::kHullPlaneCapacity);
    fmt::print("materials\n");
    for (const MaterialDef& m : materials::all()) {
        fmt::print(
            "  {:<12} {:6.0f} kg/m3, phi {:4.1f} deg, c {:6.0f} Pa, tool friction {:.2f}{}\n",
            m.name, m.density_kg_m3, m.friction_angle_rad * 180 / std::numbers::pi, m.cohesion_pa,
            m.tool_friction, m.pore_water_fraction > 0 ? ", takes water" : "");
    }
    return kPassed;
}

}  // namespace

void add_info(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<DeviceOptions>();
    CLI::App* command = app.add_subcommand(
        "info", "list devices, the backend chosen and why, limits and materials");
    options->add_to(*command);
    command->callback([options, &exit_code] { exit_code = info(*options); });
}

void add_scene_keys(CLI::App& app, int& exit_code) {
    CLI::App* command = app.add_subcommand("scene-keys", "print every key a scene file may have");
    command->add_flag("--markdown")->description("as a Markdown page (the only form there is)");
    command->callback([&exit_code] {
        fmt::print("{}", scene::schema_markdown());
        exit_code = kPassed;
    });
}

}  // namespace bsoil::command
