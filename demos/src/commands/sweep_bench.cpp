#include "sweep_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "experiment/page_tables.h"
#include "pushing_block.h"
#include "scene_work.h"

namespace bsoil::command {
namespace {

using Json = nlohmann::ordered_json;

/// Columns along a tile's side.
constexpr int kTileSide = 8;
/// Voxels along the square of each block where all of a soil is to be awake. Ours: 46, in which a
/// block goes to and fro in 110 steps and no tile falls asleep. Larger: some do; smaller: blocks
/// that meet.
constexpr int kBlockRoom = 46;

/// A bed of soil, half as high as its grid, and blocks that push through it.
struct Case {
    int nx = 56, ny = 56, nz = 56;  ///< voxels
    double voxel_m = 0.05;
    int alpha = 4;
    int body_count = 1;
    int thread_count = 0;
    bool is_all_awake = false;  ///< blocks as wide as their squares, and room for all tiles
};

/// Blocks in a square, all along the same course, each in a square of soil of its own.
class Blocks {
  public:
    Blocks(const Case& of, double step_s) : step_m_(0.5 * of.voxel_m), step_s_(step_s) {
        const int row = static_cast<int>(std::ceil(std::sqrt(of.body_count)));
        room_m_ = of.nx * of.voxel_m / row;
        const double height_m = of.nz * of.voxel_m;
        shapes_.resize(1);
        shapes_[0].half_extents_m = {room_m_ / 16, room_m_ / (of.is_all_awake ? 2.2 : 6.0),
                                     std::min(room_m_, height_m) / 8};
        for (int i = 0; i < of.body_count; ++i) {
            SoilBody body;
            body.shapes = &shapes_;
            body.id = i + 1;
            bodies_.push_back(body);
            const double middle = (row - 1) / 2.0;
            places_.push_back({(i % row - middle) * room_m_, (i / row - middle) * room_m_,
                               height_m / 2 + shapes_[0].half_extents_m.z / 6});
        }
    }
    /// Where they are at the end of step `step`.
    std::span<const SoilBody> at(int step) {
        const double way = room_m_ * 0.6;
        const double along = std::fmod(step * step_m_, 2 * way);
        const bool forth = along < way;
        for (size_t i = 0; i < bodies_.size(); ++i) {
            bodies_[i].pose.position = places_[i];
            bodies_[i].pose.position.x += (forth ? along : 2 * way - along) - way / 2;
            bodies_[i].center_of_mass_m = bodies_[i].pose.position;
            bodies_[i].linear_velocity_m_s = {(forth ? step_m_ : -step_m_) / step_s_, 0, 0};
        }
        return bodies_;
    }

  private:
    double step_m_, step_s_, room_m_ = 0;
    std::vector<ConvexShape> shapes_;
    std::vector<SoilBody> bodies_;
    std::vector<Vec3> places_;
};

struct Measured {
    double step_ms = 0, device_ms = 0;  ///< the kernels', by the GPU's clock
    double awake_voxel_count = 0;
    WorkCounts work;
    uint64_t checksum = 0;
};

Result<Measured> measure(const Case& of, Backend backend, int step_count) {
    SoilDef def;
    def.material = pushed_material();
    def.size_m = {of.nx * of.voxel_m, of.ny * of.voxel_m, of.nz * of.voxel_m};
    def.voxel_m = of.voxel_m;
    def.up = UpAxis::z;
    def.propagation_iterations = of.alpha;
    def.backend = backend;
    def.thread_count = of.thread_count;
    if (of.is_all_awake) {
        const auto tiles = [](int voxels) { return (voxels + kTileSide - 1) / kTileSide; };
        def.tile_capacity = tiles(of.nx) * tiles(of.ny);
    }
    auto made = Soil::create(def);
    if (!made) return Error{made.error()};
    Soil& soil = **made;
    const Vec3 half = def.size_m * 0.5;
    const Status filled =
        soil.fill(BoxFill{{{-half.x, -half.y, 0}, {half.x, half.y, half.z}}, "thesis"});
    if (!filled) return Error{filled.error()};
    Blocks blocks(of, def.step_s);
    int step = 0;
    while (step < step_count) soil.step(blocks.at(step++));
    const WorkCounts before = soil.work_counts();
    Measured out;
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < step_count; ++i) {
        const StepReport report = soil.step(blocks.at(step++));
        out.awake_voxel_count += 64.0 * of.nz * report.tile_awake_count / step_count;
    }
    out.step_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count() /
        step_count;
    out.work = difference(before, soil.work_counts());
    for (const PassWork& pass : out.work.passes) out.device_ms += pass.time_ms / step_count;
    if (!soil.device_failure().empty()) return Error{soil.device_failure()};
    out.checksum = soil.checksum();
    return out;
}

/// One soil, timed and counted.
Result<Json> sweep_point(const Case& of, Backend backend, int step_count) {
    const auto timed = measure(of, backend, step_count);
    if (!timed) return Error{timed.error()};
    const CountingKernels counting;
    const auto counted = measure(of, Backend::cpu, step_count);
    if (!counted) return Error{counted.error()};
    if (counted->checksum != timed->checksum) {
        return Error{"counted and timed steps end in different soils; report this sweep"};
    }
    double visited = 0, changed = 0, bytes = 0;
    for (const PassWork& pass : counted->work.passes) {
        visited += static_cast<double>(pass.voxel_visited_count) / step_count;
        changed += static_cast<double>(pass.voxel_changed_count) / step_count;
        bytes += static_cast<double>(pass.moved_bytes) / step_count;
    }
    return Json{{"voxels_awake", timed->awake_voxel_count},
                {"step_ms", timed->step_ms},
                {"dispatches", static_cast<double>(timed->work.dispatch_count) / step_count},
                {"voxels_visited", visited},
                {"voxels_changed", changed},
                {"visited_per_changed", changed > 0 ? visited / changed : 0},
                {"moved_bytes", bytes}};
}

std::vector<std::string> sweep_cells(const std::string& name, const Json& point) {
    const auto number = [&](const char* key) { return point[key].get<double>(); };
    return {name,
            fmt::format("{:.3g}", number("voxels_awake")),
            fmt::format("{:.2f}", number("step_ms")),
            fmt::format("{:.0f}", number("dispatches")),
            fmt::format("{:.0f}", number("voxels_visited")),
            fmt::format("{:.0f}", number("voxels_changed")),
            fmt::format("{:.1f}", number("visited_per_changed")),
            fmt::format("{:.0f}", number("moved_bytes") / 1e3)};
}

}  // namespace

Status time_awake(Backend backend, int thread_count, const std::vector<int>& sides, int step_count,
                  Json& figures) {
    fmt::print(
        "N^3 voxels, all awake: blocks push everywhere\n  {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}\n",
        "N", "awake", "blocks", "ms a step", "kernels", "a second");
    for (const int side : sides) {
        const int row = std::max(1, side / kBlockRoom);
        const auto timed = measure({.nx = side,
                                    .ny = side,
                                    .nz = side,
                                    .body_count = row * row,
                                    .thread_count = thread_count,
                                    .is_all_awake = true},
                                   backend, step_count);
        if (!timed) return Error{fmt::format("{}^3 voxels awake: {}", side, timed.error())};
        fmt::print("  {:>8} {:>9.3g} {:>9} {:>9.2f} {:>9.2f} {:>9.1f}\n", side,
                   timed->awake_voxel_count, row * row, timed->step_ms, timed->device_ms,
                   1e3 / timed->step_ms);
        figures["awake"][std::to_string(side)] =
            Json{{"voxels_awake", timed->awake_voxel_count},
                 {"bodies", row * row},
                 {"step_ms", timed->step_ms},
                 {"kernels_ms", timed->device_ms},
                 {"checksum", fmt::format("{:016x}", timed->checksum)}};
    }
    fmt::print("\n");
    return Done{};
}

std::string awake_table(const Json& awake) {
    std::string text = experiment::table_head(
        {"N", "voxels awake", "blocks", "ms a step", "of it kernels", "steps a second"});
    for (const auto& [side, point] : awake.items()) {
        const double step_ms = point["step_ms"].get<double>();
        text += experiment::table_row(
            {side, fmt::format("{:.3g}", point["voxels_awake"].get<double>()),
             std::to_string(point["bodies"].get<int>()), fmt::format("{:.2f}", step_ms),
             fmt::format("{:.2f}", point["kernels_ms"].get<double>()),
             fmt::format("{:.1f}", 1e3 / step_ms)});
    }
    return text;
}

Status time_sweeps(Backend backend, int thread_count, int step_count, Json& figures) {
    struct Point {
        std::string name;
        Case of;
    };
    struct Sweep {
        std::string name;
        std::vector<Point> points;
    };
    const auto cube = [&](int side) {
        return Case{.nx = side, .ny = side, .nz = side, .thread_count = thread_count};
    };
    std::vector<Sweep> sweeps{{"N, of N^3 voxels", {}},
                              {"threads, at 72^3", {}},
                              {"alpha, at 56^3", {}},
                              {"voxel, of a cube of 2.8 m", {}},
                              {"bodies, on 256 x 256 x 32 voxels", {}}};
    for (const int side : {24, 40, 72, 104, 152}) {
        sweeps[0].points.push_back({std::to_string(side), cube(side)});
    }
    for (const int threads : {1, 2}) {
        Case of = cube(72);
        of.thread_count = threads;
        sweeps[1].points.push_back({std::to_string(threads), of});
    }
    for (const int alpha : {1, 2, 4, 8, 16, 32}) {
        Case of = cube(56);
        of.alpha = alpha;
        sweeps[2].points.push_back({std::to_string(alpha), of});
    }
    for (const int side : {28, 56, 112, 224}) {
        Case of = cube(side);
        of.voxel_m = 2.8 / side;
        sweeps[3].points.push_back({fmt::format("{:.3g} cm", of.voxel_m * 100), of});
    }
    for (const int bodies : {1, 10, 100, 1000}) {
        Case of{.nx = 256, .ny = 256, .nz = 32, .body_count = bodies, .thread_count = thread_count};
        sweeps[4].points.push_back({std::to_string(bodies), of});
    }
    for (const Sweep& sweep : sweeps) {
        fmt::print("{}\n  {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", sweep.name, "",
                   "awake", "ms a step", "dispatch", "visited", "changed", "ratio", "kB");
        for (const Point& point : sweep.points) {
            const auto measured = sweep_point(point.of, backend, step_count);
            if (!measured) return Error{sweep.name + ", " + point.name + ": " + measured.error()};
            fmt::print(" ");
            for (const std::string& text : sweep_cells(point.name, *measured)) {
                fmt::print(" {:>9}", text);
            }
            fmt::print("\n");
            figures["sweeps"][sweep.name][point.name] = *measured;
        }
        fmt::print("\n");
    }
    return Done{};
}

std::string sweep_tables(const Json& sweeps) {
    std::string text;
    for (const auto& [name, points] : sweeps.items()) {
        text += experiment::table_head({name, "voxels awake", "ms a step", "dispatches",
                                        "voxels visited", "voxels changed", "visited for one",
                                        "kB moved"});
        for (const auto& [point, figures] : points.items()) {
            text += experiment::table_row(sweep_cells(point, figures));
        }
        text += "\n";
    }
    if (!text.empty()) text.pop_back();
    return text;
}

}  // namespace bsoil::command
