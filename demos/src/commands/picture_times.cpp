#include "picture_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <vector>

#include "run/scene_picture.h"

namespace bsoil::command {
namespace {

constexpr int kSamples = 2;

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// The middle one: a machine with other work makes some pictures slow.
double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

Result<nlohmann::ordered_json> time_pictures(scene::SceneRun& run, int count) {
    // As the window of a machine without a graphics card has it.
    auto renderer = render::Renderer::create({.sample_count = kSamples, .shadow_map_size = 1024});
    if (!renderer) return Error{"no pictures: " + renderer.error()};
    scene::ScenePicture picture(run, **renderer);
    if (const auto first = (*renderer)->render(picture.view()); !first) return Error{first.error()};
    struct Part {
        const char* name;
        std::vector<double> ms;
    };
    Part mesh{"mesh and upload", {}}, whole{"picture", {}}, cpu{"processor time of it", {}};
    std::vector<double> triangles, built, built_by_gl;
    scene::ScenePicture::SurfaceCounts counts;
    Part shadow{"shadow map", {}}, surface{"surface", {}}, occlusion{"occlusion", {}},
        light{"light", {}}, finish{"finish", {}};
    for (int i = 0; i < count; ++i) {
        run.step();
        if (const std::string failure = run.failure(); !failure.empty()) return Error{failure};
        const Clock::time_point meshed_from = Clock::now();
        const render::View view = picture.view();
        mesh.ms.push_back(ms_since(meshed_from));
        counts = picture.surface_counts();
        triangles.push_back(static_cast<double>(counts.triangle_count));
        built.push_back(counts.tile_built_count);
        built_by_gl.push_back(counts.tile_gl_count);
        const Clock::time_point start = Clock::now();
        const std::clock_t cpu_start = std::clock();
        if (const auto image = (*renderer)->render(view); !image) return Error{image.error()};
        whole.ms.push_back(ms_since(start));
        cpu.ms.push_back(1e3 * static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC);
        const render::PassTimes times = (*renderer)->pass_times();
        shadow.ms.push_back(times.shadow);
        occlusion.ms.push_back(times.occlusion);
        surface.ms.push_back(times.surface);
        light.ms.push_back(times.light);
        finish.ms.push_back(times.finish);
    }
    nlohmann::ordered_json json;
    json["device"] = (*renderer)->device_name();
    fmt::print("  {} pictures of 1280 x 720 by {}, medians:", count, (*renderer)->device_name());
    for (const Part* part : {&mesh, &whole, &shadow, &surface, &occlusion, &light, &finish, &cpu}) {
        json["ms"][part->name] = median(part->ms);
        fmt::print("{} {} {:.1f} ms", part == &mesh ? "" : ",", part->name, median(part->ms));
    }
    json["triangles"] = median(triangles);
    json["tiles meshed"] = median(built);
    json["tiles meshed by OpenGL"] = median(built_by_gl);
    json["tiles"] = counts.tile_count;
    json["tiles not at full detail"] = counts.tile_coarse_count;
    fmt::print(
        "\n  {:.0f} triangles; {:.0f} of {} tiles meshed for a picture, {:.0f} by OpenGL; {} are "
        "not at full "
        "detail\n",
        median(triangles), median(built), counts.tile_count, median(built_by_gl),
        counts.tile_coarse_count);
    return json;
}

}  // namespace bsoil::command
