/// `bsoil render` and `bsoil export`: a moment of a scene as pictures, and as files for other
/// tools.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "command_line.h"
#include "commands.h"
#include "files/json_text.h"
#include "opened_scene.h"
#include "run/exports.h"
#include "run/scene_models.h"
#include "run/scene_picture.h"

namespace bsoil::command {
namespace {

/// Which moment of a scene: its start or a snapshot, and how many steps later.
struct Moment {
    OpenedScene opened;
    std::string from;
    long long advance = 0;

    void add_options(CLI::App& app) {
        app.add_option("scene", opened.path,
                       "the scene file (TOML), or a snapshot, which knows its scene")
            ->required();
        app.add_option("--from", from,
                       "the moment: a snapshot of this scene (bsoil run writes them)");
        app.add_option("--advance", advance, "make so many steps of the soil first")
            ->check(at_least(0));
        opened.device.add_to(app);
    }
    /// Opens the scene, or that of the snapshot. The exit code.
    int open() {
        if (!opened.path.ends_with(".snapshot")) {
            if (from.empty()) return opened.open();
            const auto scene = scene::scene_of_snapshot(from);
            if (!scene) return fail(scene.error());
            opened.up = scene->up;  // the run may have had --up
            return opened.open();
        }
        if (!from.empty()) {
            return fail("--from: " + opened.path +
                        " is a snapshot itself; give the scene, or leave --from out");
        }
        from = opened.path;
        const auto scene = scene::scene_of_snapshot(from);
        if (!scene) return fail(scene.error());
        opened.path = scene->path;
        opened.up = scene->up;
        if (!std::filesystem::exists(opened.path)) {
            return fail(
                fmt::format("{}: its scene {} is not there; say where it is now: "
                            "SCENE --from {}",
                            from, opened.path, from));
        }
        return opened.open();
    }
    /// Goes to the moment. The exit code.
    int go() {
        scene::SceneRun& run = *opened.run;
        if (!from.empty()) {
            if (const Status loaded = run.load(from); !loaded) return fail(loaded.error());
        }
        for (long long s = 0; s < advance; ++s) {
            run.step();
            if (const std::string failure = run.failure(); !failure.empty()) return fail(failure);
        }
        return kPassed;
    }
    static int fail(const std::string& text) {
        fmt::print(stderr, "{}\n", text);
        return kCouldNotRun;
    }
};

struct RenderArguments {
    Moment moment;
    std::string picture, depth, normals, labels;
    int width = 1280, height = 720;
    std::vector<double> eye, target;
    std::string volume;
    double sight_m = 0;
};

Status write_depth(const render::Buffers& buffers, const std::string& path) {
    std::vector<uint16_t> levels;
    for (const float depth_m : buffers.depths_m) {
        levels.push_back(static_cast<uint16_t>(
            std::clamp(std::lround(1e3 * static_cast<double>(depth_m)), 0l, 65535l)));
    }
    return render::write_grey_png(buffers.width, buffers.height, levels, path);
}

Status write_normals(const render::Buffers& buffers, const std::string& path) {
    render::Image image{buffers.width, buffers.height, {}};
    for (size_t p = 0; p < buffers.depths_m.size(); ++p) {
        for (size_t c = 0; c < 3; ++c) {
            const double share = 0.5 + 0.5 * static_cast<double>(buffers.normals[3 * p + c]);
            image.rgba.push_back(static_cast<uint8_t>(std::lround(255 * share)));
        }
        image.rgba.push_back(255);
    }
    return render::write_png(image, path);
}

/// A picture of the labels and, beside it, their names.
Status write_labels(const render::Buffers& buffers, const scene::SceneRun& run,
                    const std::string& path) {
    const std::vector<uint16_t> levels(buffers.labels.begin(), buffers.labels.end());
    const Status written = render::write_grey_png(buffers.width, buffers.height, levels, path);
    if (!written) return written;
    nlohmann::ordered_json names;
    names["0"] = "background";
    names[std::to_string(scene::kSoilLabel)] = "soil";
    names[std::to_string(scene::kTerrainLabel)] = "terrain";
    for (size_t b = 0; b < run.bullet().bodies().size(); ++b) {
        names[std::to_string(scene::kFirstBodyLabel + b)] = run.bullet().bodies()[b].name;
    }
    std::ofstream file(path + ".json");
    file << scene::json_text(names, 2) << '\n';
    file.close();
    if (!file) return Error{path + ".json: cannot be written whole; look whether the disk is full"};
    return Done{};
}

constexpr const char* kSoilVolume = "soil";  ///< the soil itself: no field of it

/// By what --volume calls them.
std::vector<std::string> volume_names() {
    std::vector<std::string> names{kSoilVolume};
    for (int f = 1; f < scene::kFieldCount; ++f) {
        names.emplace_back(scene::field_name(static_cast<scene::Field>(f)));
    }
    return names;
}

scene::Field field_of(const std::string& name) {
    const std::vector<std::string> names = volume_names();
    return static_cast<scene::Field>(std::find(names.begin(), names.end(), name) - names.begin());
}

int render(RenderArguments& arguments) {
    if (arguments.picture.empty() && arguments.depth.empty() && arguments.normals.empty() &&
        arguments.labels.empty()) {
        return Moment::fail("render: say what to write: --out, --depth, ...");
    }
    const int opened = arguments.moment.open();
    if (opened != kPassed) return opened;
    const scene::SceneRun& run = *arguments.moment.opened.run;
    if (!arguments.volume.empty()) {
        if (!run.has_soil()) return Moment::fail("--volume: this scene has no soil; leave it out");
        if (!scene::has_field(run.soil().materials(), field_of(arguments.volume))) {
            return Moment::fail("--volume: this soil has no " + arguments.volume +
                                "; take another");
        }
    }
    auto renderer = render::Renderer::create();
    if (!renderer) return Moment::fail("no pictures: " + renderer.error());
    scene::ScenePicture picture(run, **renderer);
    for (const std::string& note : picture.notes()) fmt::print(stderr, "{}\n", note);
    if (const int gone = arguments.moment.go(); gone != kPassed) return gone;
    if (!arguments.volume.empty()) {
        const scene::SoilVolumeDef def{field_of(arguments.volume), 0, 0, arguments.sight_m};
        if (const Status shown = picture.show_volume(def); !shown) {
            return Moment::fail(shown.error());
        }
    }
    const render::View view = picture.view([&arguments](render::View& made) {
        const auto vector = [](const std::vector<double>& v) { return Vec3{v[0], v[1], v[2]}; };
        made.width = arguments.width;
        made.height = arguments.height;
        if (!arguments.eye.empty()) made.camera.eye = vector(arguments.eye);
        if (!arguments.target.empty()) made.camera.target = vector(arguments.target);
        scene::keep_off_vertical(made.camera);
    });
    std::vector<Status> written;
    if (!arguments.picture.empty()) {
        const auto image = (*renderer)->render(view);
        if (!image) return Moment::fail(image.error());
        const bool is_jpeg =
            arguments.picture.ends_with(".jpg") || arguments.picture.ends_with(".jpeg");
        written.push_back(
            (is_jpeg ? render::write_jpeg : render::write_png)(*image, arguments.picture));
    }
    if (!arguments.depth.empty() || !arguments.normals.empty() || !arguments.labels.empty()) {
        const auto buffers = (*renderer)->buffers(view);
        if (!buffers) return Moment::fail(buffers.error());
        if (!arguments.depth.empty()) written.push_back(write_depth(*buffers, arguments.depth));
        if (!arguments.normals.empty()) {
            written.push_back(write_normals(*buffers, arguments.normals));
        }
        if (!arguments.labels.empty()) {
            written.push_back(write_labels(*buffers, run, arguments.labels));
        }
    }
    for (const Status& status : written) {
        if (!status) return Moment::fail(status.error());
    }
    return kPassed;
}

int export_moment(Moment& moment, const std::vector<std::string>& files) {
    const int opened = moment.open();
    if (opened != kPassed) return opened;
    if (const int gone = moment.go(); gone != kPassed) return gone;
    int exit_code = kPassed;
    for (const std::string& file : files) {
        const auto written = scene::export_run(*moment.opened.run, file);
        if (!written) {
            exit_code = Moment::fail(written.error());  // the others are written all the same
        } else if (!written->empty()) {
            fmt::print("{}: {}\n", file, *written);
        }
    }
    return exit_code;
}

}  // namespace

void add_render(CLI::App& app, int& exit_code) {
    auto arguments = std::make_shared<RenderArguments>();
    CLI::App* command = app.add_subcommand("render", "pictures of a moment of a scene");
    arguments->moment.add_options(*command);
    command->add_option("--out", arguments->picture,
                        "the picture: PNG, or JPEG where the file's ending is .jpg or .jpeg");
    command->add_option(
        "--depth", arguments->depth,
        "16-bit PNG: millimetres along the line of sight, 0 the sky; 65535 is all that "
        "lies farther");
    command->add_option("--normals", arguments->normals,
                        "PNG: x, y, z of the world's normals as red, green, blue; 128 is 0");
    command->add_option("--labels", arguments->labels,
                        "16-bit PNG: what is seen, by number; the names in FILE.json");
    for (const auto& [name, side] :
         {std::pair{"--width", &arguments->width}, std::pair{"--height", &arguments->height}}) {
        command->add_option(name, *side, "pixels")
            ->check(CLI::Range(1, 8192))
            ->capture_default_str();
    }
    command->add_option("--eye", arguments->eye, "x y z [m] in place of the scene's camera")
        ->expected(3);
    command->add_option("--target", arguments->target, "x y z [m]")->expected(3);
    command
        ->add_option("--volume", arguments->volume,
                     "look into the soil, or into a field of it, in place of its surface")
        ->check(CLI::IsMember(volume_names()));
    command
        ->add_option("--sight", arguments->sight_m,
                     "how far one sees into what hides most [m]: 1/e of the light is left; without "
                     "it as the volume needs it")
        ->check(CLI::PositiveNumber);
    command->callback([arguments, &exit_code] { exit_code = render(*arguments); });
}

void add_export(CLI::App& app, int& exit_code) {
    struct Arguments {
        Moment moment;
        std::vector<std::string> files;
    };
    auto arguments = std::make_shared<Arguments>();
    CLI::App* command = app.add_subcommand("export",
                                           "a moment of a scene for other tools: glTF, OBJ, PLY, "
                                           "ESRI ASCII, GeoTIFF, PNG, VTK, OpenVDB");
    arguments->moment.add_options(*command);
    command
        ->add_option("--out", arguments->files,
                     "files whose endings say the format: .glb .obj .ply (meshes), .asc .tif "
                     ".png (heights), .vti .vdb (voxels)")
        ->required();
    command->callback([arguments, &exit_code] {
        exit_code = export_moment(arguments->moment, arguments->files);
    });
}

}  // namespace bsoil::command
