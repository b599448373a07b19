#include "bench_page.h"

#include <fmt/format.h>

#include <iterator>

#include "scene_work.h"
#include "sweep_bench.h"

namespace bsoil::command {
namespace {

using Json = nlohmann::ordered_json;
using Page = std::back_insert_iterator<std::string>;

/// 0 where there is none: JSON has no number for what is not finite.
double number(const Json& json, const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_number() ? found->get<double>() : 0.0;
}

void write_sides(const Json& figures, Page page) {
    fmt::format_to(page,
                   "## A block pushes soil in N^3 voxels\n\n"
                   "Milliseconds a frame: a step, and the mesh of what changed. Alpha 4.\n\n"
                   "| N | voxels | mean | min | max | step | mesh | thesis | checksum |\n"
                   "|---|---|---|---|---|---|---|---|---|\n");
    for (const auto& [side, times] : figures["sides"].items()) {
        const long long n = std::stoll(side);
        fmt::format_to(
            page, "| {} | {:.3g} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} |\n",
            side, static_cast<double>(n * n * n), number(times, "mean_ms"), number(times, "min_ms"),
            number(times, "max_ms"), number(times, "step_mean_ms"), number(times, "mesh_mean_ms"),
            number(times, "thesis_ms"), times.value("checksum", ""));
    }
    if (figures.contains("sides_fit")) {
        fmt::format_to(page, "\nFit: {:.2e} ms a voxel + {:.2f} ms.\n",
                       number(figures["sides_fit"], "ms_per_voxel"),
                       number(figures["sides_fit"], "overhead_ms"));
    }
    fmt::format_to(page, "\n");
}

void write_alphas(const Json& figures, Page page) {
    fmt::format_to(page,
                   "The same at 72^3, by alpha:\n\n| alpha | mean | thesis |\n|---|---|---|\n");
    for (const auto& [alpha, times] : figures["alphas"].items()) {
        fmt::format_to(page, "| {} | {:.2f} | {:.2f} |\n", alpha, number(times, "mean_ms"),
                       number(times, "thesis_ms"));
    }
    if (figures.contains("alphas_fit")) {
        fmt::format_to(page, "\nFit: {:.3f} ms an iteration + {:.2f} ms.\n",
                       number(figures["alphas_fit"], "ms_per_iteration"),
                       number(figures["alphas_fit"], "overhead_ms"));
    }
    fmt::format_to(page, "\n");
}

void write_scene(const std::string& path, const Json& scene, Page page) {
    fmt::format_to(page, "## {}\n\n{} steps, {:.1f} a second, {:.2f} cores busy. Checksum {}.\n\n",
                   path.substr(path.find_last_of('/') + 1), scene.value("steps", 0LL),
                   number(scene, "steps_per_s"), number(scene, "cores_busy"),
                   scene.value("checksum", "none"));
    fmt::format_to(page, "| stage | ms a step |\n|---|---|\n| all | {:.3f} |\n",
                   number(scene, "ms_a_step"));
    if (scene.contains("stages_ms")) {
        for (const auto& [name, ms] : scene["stages_ms"].items()) {
            fmt::format_to(page, "| {} | {:.3f} |\n", name, ms.get<double>());
        }
    }
    if (!scene.contains("work")) return;
    fmt::format_to(page, "\n{}", work_table(scene["work"]));
    if (scene.contains("pictures")) {
        const Json& pictures = scene["pictures"];
        fmt::format_to(page, "\nPictures of 1280 x 720 by {}, ms:", pictures.value("device", ""));
        for (const auto& [name, ms] : pictures["ms"].items()) {
            fmt::format_to(page, " {} {:.1f};", name, ms.get<double>());
        }
        fmt::format_to(page, "\n");
    }
    fmt::format_to(page, "\n");
}

}  // namespace

std::string bench_page(const Json& figures) {
    std::string text;
    const Page page(text);
    fmt::format_to(
        page, "# Figures of {}\n\nBackend {}. A copy in the host's memory moves {:.1f} GB/s.\n\n",
        figures.value("device", "an unknown device"), figures.value("backend", "none"),
        number(figures, "copy_gb_per_s"));
    if (figures.contains("sides")) write_sides(figures, page);
    if (figures.contains("alphas")) write_alphas(figures, page);
    if (figures.contains("sweeps")) {
        fmt::format_to(page, "## Blocks that push soil\n\n{}", sweep_tables(figures["sweeps"]));
    }
    if (figures.contains("awake")) {
        fmt::format_to(page, "## N^3 voxels, all awake\n\n{}\n", awake_table(figures["awake"]));
    }
    if (figures.contains("scenes")) {
        for (const auto& [path, scene] : figures["scenes"].items()) write_scene(path, scene, page);
    }
    return text;
}

}  // namespace bsoil::command
