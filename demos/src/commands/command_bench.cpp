/// `bsoil bench`: the numbers of docs/records/performance.md, here. The first two experiments are
/// those of the thesis, section 4.2: a rigid block pushes soil along the surface of a cube of N^3
/// voxels, half full; phi 25 deg, c 0, 2 t/m3, alpha 4.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench_page.h"
#include "bsoil/device_info.h"
#include "bsoil/soil.h"
#include "bsoil/surface_mesh.h"
#include "commands.h"
#include "experiment/page_tables.h"
#include "feature_bench.h"
#include "files/json_text.h"
#include "files/text_file.h"
#include "opened_scene.h"
#include "picture_times.h"
#include "pushing_block.h"
#include "scene_work.h"
#include "sweep_bench.h"

namespace bsoil::command {
namespace {

using Json = nlohmann::ordered_json;

const std::vector<int> kThesisSides = {56, 64, 72, 80, 88, 104};
constexpr int kAlphaSide = 72;
constexpr int kAlphas[] = {0, 2, 4, 8, 12, 16};
constexpr int kWarmUpFrames = 20;
/// Ours: 30 and as many before, half a block's way. Larger: minutes where there are many voxels;
/// smaller: what wakes at the start.
constexpr int kAwakeSteps = 30;
constexpr double kVoxelM = PushingBlock::kVoxelM;
// What the thesis measured on a Radeon R9 270: equations (36) and (38).
constexpr double kThesisMsPerVoxel = 2.4e-5, kThesisOverheadMs = 4.3;
constexpr double kThesisMsPerIteration = 1.17, kThesisAlphaOverheadMs = 8.95;

struct BenchArguments {
    DeviceOptions device;
    int frame_count = 200;
    std::vector<std::string> scenes;
    long long step_count = 0;  ///< of a scene; 0: all
    int picture_count = 0;     ///< of a scene
    bool is_thesis = true;
    int sweep_steps = 0;           ///< 0: no sweeps
    std::vector<int> awake_sides;  ///< voxels along cubes all of which is awake
    int feature_rounds = 0;        ///< 0: features are not timed
    bool on_gpu = false;
    bool is_counted = true;  ///< scenes are run once more, to count what passes touch
    std::vector<int> sides = kThesisSides;
    std::string out, page, document;
};

/// Milliseconds a frame: one step of the soil and the mesh of its surface.
struct FrameTimes {
    double mean_ms = 0, min_ms = 0, max_ms = 0, step_mean_ms = 0, mesh_mean_ms = 0;
    double blocks_mean = 0;  ///< blocks that moved or might
    double bytes_per_awake_voxel = 0;
    uint64_t checksum = 0;  ///< of the soil at the end
    std::string backend, device;
};

/// The line y = slope x + offset that fits best.
struct Line {
    double slope = 0, offset = 0;
};
Line fit_line(const std::vector<double>& x, const std::vector<double>& y) {
    const double n = static_cast<double>(x.size());
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (size_t i = 0; i < x.size(); ++i) {
        sx += x[i];
        sy += y[i];
        sxx += x[i] * x[i];
        sxy += x[i] * y[i];
    }
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    return {slope, (sy - slope * sx) / n};
}

Result<FrameTimes> push_block(const BenchArguments& arguments, int side, int alpha) {
    const double side_m = side * kVoxelM;
    SoilDef def;
    def.material = pushed_material();
    def.size_m = {side_m, side_m, side_m};
    def.voxel_m = kVoxelM;
    def.up = UpAxis::z;
    def.propagation_iterations = alpha;
    def.backend = arguments.device.chosen();
    def.thread_count = arguments.device.thread_count;
    auto made = Soil::create(def);
    if (!made) return Error{made.error()};
    Soil& soil = **made;
    const double half = side_m / 2;
    const Status filled = soil.fill(BoxFill{{{-half, -half, 0}, {half, half, half}}, "thesis"});
    if (!filled) return Error{filled.error()};
    const SoilTiles tiles(soil);
    SurfaceMesher mesher(tiles, {.backend = arguments.device.chosen_mesher(),
                                 .thread_count = arguments.device.thread_count});
    PushingBlock block(side_m, def.step_s);

    FrameTimes times;
    times.min_ms = 1e30;
    using Clock = std::chrono::steady_clock;
    const auto ms = [](Clock::duration d) {
        return std::chrono::duration<double, std::milli>(d).count();
    };
    for (int frame = 0; frame < kWarmUpFrames + arguments.frame_count; ++frame) {
        const SoilBody& body = block.at(frame);
        const auto start = Clock::now();
        const StepReport report = soil.step({&body, 1});
        const auto stepped = Clock::now();
        mesher.update();
        const auto meshed = Clock::now();
        if (frame < kWarmUpFrames) continue;
        const double frame_ms = ms(meshed - start);
        times.mean_ms += frame_ms / arguments.frame_count;
        times.step_mean_ms += ms(stepped - start) / arguments.frame_count;
        times.mesh_mean_ms += ms(meshed - stepped) / arguments.frame_count;
        times.min_ms = std::min(times.min_ms, frame_ms);
        times.max_ms = std::max(times.max_ms, frame_ms);
        times.blocks_mean += static_cast<double>(report.block_active_count) / arguments.frame_count;
    }
    if (!soil.device_failure().empty()) return Error{soil.device_failure()};
    times.bytes_per_awake_voxel = soil.memory_use().bytes_per_awake_voxel;
    times.checksum = soil.checksum();
    times.backend = soil.backend_name();
    times.device = soil.device_name();
    return times;
}

Json as_json(const FrameTimes& t, double thesis_ms) {
    return {{"mean_ms", t.mean_ms},
            {"thesis_ms", thesis_ms},
            {"checksum", fmt::format("{:016x}", t.checksum)},
            {"min_ms", t.min_ms},
            {"max_ms", t.max_ms},
            {"step_mean_ms", t.step_mean_ms},
            {"mesh_mean_ms", t.mesh_mean_ms},
            {"blocks_active_mean", t.blocks_mean}};
}

Status bench_sides(const BenchArguments& arguments, Json& json) {
    fmt::print(
        "Block pushing soil, N^3 voxels, alpha 4: ms a frame (step + mesh)\n"
        "    N    mean     min     max    step    mesh  blocks  thesis mean\n");
    std::vector<double> voxels, means;
    for (const int side : arguments.sides) {
        const auto times = push_block(arguments, side, 4);
        if (!times) return Error{times.error()};
        const double count = static_cast<double>(side) * side * side;
        const double thesis_ms = kThesisMsPerVoxel * count + kThesisOverheadMs;
        fmt::print("  {:3} {:7.2f} {:7.2f} {:7.2f} {:7.2f} {:7.2f} {:7.0f}  {:8.2f}\n", side,
                   times->mean_ms, times->min_ms, times->max_ms, times->step_mean_ms,
                   times->mesh_mean_ms, times->blocks_mean, thesis_ms);
        voxels.push_back(count);
        means.push_back(times->mean_ms);
        json["sides"][std::to_string(side)] = as_json(*times, thesis_ms);
        json["backend"] = times->backend;
        json["device"] = times->device;
    }
    if (arguments.sides.size() < 2) return Done{};  // no line through one point
    const Line line = fit_line(voxels, means);
    fmt::print("  fit: {:.2e} ms a voxel + {:.2f} ms; thesis (36): {:.1e} + {:.1f}\n\n", line.slope,
               line.offset, kThesisMsPerVoxel, kThesisOverheadMs);
    json["sides_fit"] = Json{{"ms_per_voxel", line.slope}, {"overhead_ms", line.offset}};
    return Done{};
}

Status bench_alphas(const BenchArguments& arguments, Json& json) {
    fmt::print("The same at {0}^3, by alpha: ms a frame\n  alpha    mean   thesis mean\n",
               kAlphaSide);
    std::vector<double> alphas, means;
    for (const int alpha : kAlphas) {
        const auto times = push_block(arguments, kAlphaSide, alpha);
        if (!times) return Error{times.error()};
        const double thesis_ms = kThesisMsPerIteration * alpha + kThesisAlphaOverheadMs;
        fmt::print("  {:5} {:7.2f}   {:7.2f}\n", alpha, times->mean_ms, thesis_ms);
        alphas.push_back(alpha);
        means.push_back(times->mean_ms);
        json["alphas"][std::to_string(alpha)] = as_json(*times, thesis_ms);
    }
    const Line line = fit_line(alphas, means);
    fmt::print("  fit: {:.3f} ms an iteration + {:.2f} ms; thesis (38): {:.2f} + {:.2f}\n\n",
               line.slope, line.offset, kThesisMsPerIteration, kThesisAlphaOverheadMs);
    json["alphas_fit"] = Json{{"ms_per_iteration", line.slope}, {"overhead_ms", line.offset}};
    return Done{};
}

/// The same steps again by kernels that count. The bits are the same, so that the counts are those
/// of the steps that were timed; where they are not, that is an error.
Result<WorkCounts> count_steps(const BenchArguments& arguments, const std::string& path,
                               const Json& timed) {
    const CountingKernels counting;
    OpenedScene opened;
    opened.path = path;
    opened.device = arguments.device;
    opened.device.backend = "cpu";
    if (opened.open() != kPassed) {
        return Error{path + ": cannot be run again to count; leave out --document"};
    }
    scene::SceneRun& run = *opened.run;
    const WorkCounts before = run.soil().work_counts();
    const long long steps = timed["steps"].get<long long>();
    for (long long i = 0; i < steps; ++i) run.step();
    const WorkCounts counts = difference(before, run.soil().work_counts());
    if (run.summary()["checksum"] != timed["checksum"]) {
        return Error{path + ": counted and timed steps end in different soils; report this scene"};
    }
    return counts;
}

int time_steps(const BenchArguments& arguments, scene::SceneRun& run, const std::string& path,
               Json& json) {
    const WorkCounts before = run.has_soil() ? run.soil().work_counts() : WorkCounts{};
    const std::clock_t cpu_start = std::clock();
    long long steps = 0;
    while (!run.finished() && (arguments.step_count == 0 || steps < arguments.step_count)) {
        run.step();
        ++steps;
    }
    if (const std::string failure = run.failure(); !failure.empty()) return could_not(failure);
    const double cpu_s = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
    Json of_scene = run.summary();
    for (const char* key : {"backend", "device"}) {
        if (run.has_soil()) json[key] = of_scene[key];
    }
    const double wall_s = of_scene["wall_s"].get<double>();
    const double step_ms = steps > 0 ? wall_s * 1e3 / static_cast<double>(steps) : 0;
    of_scene["ms_a_step"] = step_ms;
    if (double load = 0; getloadavg(&load, 1) == 1) of_scene["load"] = load;
    of_scene["cores_busy"] = wall_s > 0 ? cpu_s / wall_s : 0.0;
    fmt::print("{}: {} steps at {:.1f} steps/s, {:.2f} cores busy, {:.0f} of {} voxels active\n",
               path, steps, of_scene["steps_per_s"].get<double>(),
               of_scene["cores_busy"].get<double>(), of_scene.value("voxels_active_mean", 0.0),
               of_scene.value("voxels_total", 0LL));
    if (!run.has_soil() || steps == 0) {
        json["scenes"][path] = of_scene;
        return kPassed;
    }
    double stages_ms = 0;
    fmt::print("  {:.2f} ms a step:", step_ms);
    for (const auto& [name, ms] : of_scene["stages_ms"].items()) {
        fmt::print(" {} {:.2f},", name, ms.get<double>());
        stages_ms += ms.get<double>();
    }
    fmt::print(" Bullet, bridge and scene {:.2f}\n", step_ms - stages_ms);
    SceneWork work;
    work.timed = difference(before, run.soil().work_counts());
    work.step_count = static_cast<double>(steps);
    work.copy_bytes_per_s = json["copy_gb_per_s"].get<double>() * 1e9;
    int exit_code = kPassed;
    if (arguments.is_counted) {
        auto touched = count_steps(arguments, path, of_scene);
        if (touched) {
            work.touched = std::move(*touched);
        } else {
            exit_code = could_not(touched.error());
        }
    }
    of_scene["work"] = print_work(work);
    const MemoryUse memory = run.soil().memory_use();
    of_scene["bytes_an_awake_voxel"] = memory.bytes_per_awake_voxel;
    of_scene["bytes_a_sleeping_column"] = memory.bytes_per_asleep_column;
    fmt::print("  {:.1f} bytes an awake voxel, {:.1f} bytes a sleeping column\n\n",
               memory.bytes_per_awake_voxel, memory.bytes_per_asleep_column);
    json["scenes"][path] = of_scene;
    return exit_code;
}

int bench_scene(const BenchArguments& arguments, const std::string& path, Json& json) {
    OpenedScene opened;
    opened.path = path;
    opened.device = arguments.device;
    const int exit_code = opened.open();
    if (exit_code != kPassed) return exit_code;
    const int timed = time_steps(arguments, *opened.run, path, json);
    if (timed != kPassed || arguments.picture_count == 0) return timed;
    const auto pictures = time_pictures(*opened.run, arguments.picture_count);
    if (!pictures) {
        fmt::print(stderr, "{}\n", pictures.error());
        return kCouldNotRun;
    }
    json["scenes"][path]["pictures"] = *pictures;
    return kPassed;
}

/// True where a file was to be written and could not.
bool fails_to_write(const std::string& path, const std::string& text) {
    if (path.empty()) return false;
    std::ofstream file(path);
    file << text;
    if (file.flush()) return false;
    fmt::print(stderr, "{}: cannot be written; check its folder and the disk\n", path);
    return true;
}

/// The exit code where there is no OpenGL device but software, or none.
int find_gpu(DeviceOptions& options) {
    const std::vector<DeviceInfo> devices = list_devices();  // the CPU first
    const bool found =
        std::any_of(devices.begin() + 1, devices.end(),
                    [](const DeviceInfo& device) { return device.usable && device.hardware; });
    options.backend = "gl";
    if (found) return kPassed;
    fmt::print(stderr,
               "--gpu: no hardware OpenGL 4.5 device; look at bsoil info for what there is\n");
    return kCouldNotRun;
}

/// What the scenes' blocks of a document hold, written anew; kPassed or kCouldNotRun.
int write_document(const std::string& path, const Json& json) {
    if (path.empty()) return kPassed;
    const auto page = scene::read_file(path, experiment::kPageBytesMost);
    const auto written = page ? update_tables(*page, json) : page;
    if (!written) return could_not(path + ": " + written.error());
    const Status replaced = scene::replace_file(path, *written);
    return replaced ? kPassed : could_not(replaced.error());
}

/// Whether the document has the blocks for all that is to be measured.
Status has_blocks(const BenchArguments& arguments) {
    if (arguments.document.empty()) return Done{};
    std::vector<std::string> names;
    for (const std::string& scene : arguments.scenes) {
        names.push_back(std::filesystem::path(scene).stem().string());
    }
    if (arguments.sweep_steps > 0) names.push_back("sweeps");
    return experiment::has_blocks(arguments.document, "bench", names);
}

/// Threads that a soil of these options takes.
int thread_count(const DeviceOptions& options) {
    if (options.thread_count > 0) return options.thread_count;
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// A part that cannot be measured is said so, and costs none of the others. kCouldNotRun where
/// there was one, kSkipped where the data of a scene is not there.
int measure_all(const BenchArguments& arguments, Json& json) {
    int exit_code = kPassed;
    const auto take = [&exit_code](const Status& status) {
        if (!status) exit_code = could_not(status.error());
    };
    const Backend backend = arguments.device.chosen();
    const int threads = arguments.device.thread_count;
    if (arguments.is_thesis) {
        take(bench_sides(arguments, json));
        take(bench_alphas(arguments, json));
    }
    if (arguments.feature_rounds > 0) {
        const auto features =
            time_features({backend, threads}, arguments.feature_rounds, arguments.is_counted);
        if (features) json["features"] = *features;
        take(features ? Status(Done{}) : Status(Error{features.error()}));
    }
    if (arguments.sweep_steps > 0) {
        take(time_sweeps(backend, threads, arguments.sweep_steps, json));
    }
    if (!arguments.awake_sides.empty()) {
        take(time_awake(backend, threads, arguments.awake_sides, kAwakeSteps, json));
    }
    for (const std::string& scene : arguments.scenes) {
        const int of_scene = bench_scene(arguments, scene, json);
        if (exit_code == kPassed || of_scene == kCouldNotRun) exit_code = of_scene;
    }
    return exit_code;
}

int bench(BenchArguments& arguments) {
    if (arguments.on_gpu) {
        if (const int found = find_gpu(arguments.device); found != kPassed) return found;
    }
    if (const Status ready = has_blocks(arguments); !ready) return could_not(ready.error());
    Json json;
    const int threads = thread_count(arguments.device);
    const double copy_gb_s = copy_bytes_per_s(threads) / 1e9;
    json["threads"] = threads;
    json["copy_gb_per_s"] = copy_gb_s;
    fmt::print("A copy of 256 MB, threads: {}, here and now: {:.1f} GB/s read and written\n\n",
               threads, copy_gb_s);
    const size_t unmeasured = json.size();
    const int exit_code = measure_all(arguments, json);
    if (exit_code != kPassed && json.size() == unmeasured) return exit_code;  // older files stay
    const bool lacks_json = fails_to_write(arguments.out, scene::json_text(json, 2) + "\n");
    const bool lacks_page = fails_to_write(arguments.page, bench_page(json));
    const int documented = write_document(arguments.document, json);
    if (lacks_json || lacks_page || documented != kPassed) return kCouldNotRun;
    return exit_code == kSkipped ? kPassed : exit_code;  // there are other figures
}

}  // namespace

void add_bench(CLI::App& app, int& exit_code) {
    auto arguments = std::make_shared<BenchArguments>();
    CLI::App* command = app.add_subcommand(
        "bench",
        "measure speed again, as docs/records/performance.md does, beside the thesis's figures");
    arguments->device.add_to(*command);
    command->add_option("--frames", arguments->frame_count, "frames measured for each point")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command->add_option("--scene", arguments->scenes,
                        "scenes to time as well, such as excavator.toml, pass by pass");
    command->add_option("--steps", arguments->step_count, "of each scene; 0: all")
        ->check(CLI::Range(0, 100000000))
        ->capture_default_str();
    command
        ->add_option("--pictures", arguments->picture_count,
                     "of each scene, each after a step more than those")
        ->check(CLI::Range(0, 100000))
        ->capture_default_str();
    command
        ->add_option("--awake", arguments->awake_sides,
                     "voxels along a cube's side, all of it awake, each a point")
        ->check(CLI::Range(16, 512));
    command->add_flag("!--no-thesis", arguments->is_thesis, "the scenes alone");
    command
        ->add_option("--features", arguments->feature_rounds,
                     "what each feature of a soil costs beside a plain one, in so many rounds")
        ->check(CLI::Range(1, 1000));
    command->add_flag(
        "!--no-counts", arguments->is_counted,
        "the scenes' times alone; else each is run again, on one thread, to count the "
        "voxels and bytes that its passes touch");
    command
        ->add_option("--sweeps", arguments->sweep_steps,
                     "blocks that push soil, by size, threads, alpha, voxel and number: so many "
                     "steps of each")
        ->check(CLI::Range(1, 1000));
    command->add_flag("--gpu", arguments->on_gpu, "on a hardware OpenGL device; none is an error");
    command->add_option("--sides", arguments->sides, "voxels along the cube's side, each a point")
        ->check(CLI::Range(16, 512));
    command->add_option("--out", arguments->out, "write all figures as JSON");
    command->add_option("--page", arguments->page, "write them as a page (Markdown)");
    command->add_option(
        "--document", arguments->document,
        "write the tables of each scene and of the sweeps into their blocks of this "
        "page, between <!-- bsoil bench: NAME --> and <!-- end -->");
    command->callback([arguments, &exit_code] { exit_code = bench(*arguments); });
}

}  // namespace bsoil::command
