#include "scene_work.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <thread>
#include <vector>

#include "experiment/page_tables.h"
#include "sweep_bench.h"

namespace bsoil::command {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kKernelsVariable[] = "BULLETSOIL_CPU";

/// What passes have touched in a step, and what a copy of as many bytes takes.
struct Touched {
    double visited = 0, changed = 0, bytes = 0, us = 0, copy_us = 0;

    void add(const Touched& other) {
        visited += other.visited;
        changed += other.changed;
        bytes += other.bytes;
        us += other.us;
        copy_us += other.copy_us;
    }
    Json json() const {
        Json json{{"voxels_visited_a_step", visited},
                  {"voxels_changed_a_step", changed},
                  {"moved_bytes_a_step", bytes},
                  {"copy_us_a_step", copy_us}};
        if (changed > 0) json["visited_per_changed"] = visited / changed;
        if (copy_us > 0) json["time_over_copy"] = us / copy_us;
        return json;
    }
};

Touched touched_by(const SceneWork& work, size_t pass) {
    const PassWork& counted = work.touched.passes[pass];
    Touched out;
    out.visited = static_cast<double>(counted.voxel_visited_count) / work.step_count;
    out.changed = static_cast<double>(counted.voxel_changed_count) / work.step_count;
    out.bytes = static_cast<double>(counted.moved_bytes) / work.step_count;
    out.us = work.timed.passes[pass].time_ms * 1e3 / work.step_count;
    out.copy_us = out.bytes / work.copy_bytes_per_s * 1e6;
    return out;
}

/// A number of the figures, "-" where there is none.
std::string cell(const Json& json, const char* key, int places, double factor = 1) {
    const auto found = json.find(key);
    const bool is_there = found != json.end() && found->is_number();
    return is_there ? fmt::format("{:.{}f}", found->get<double>() * factor, places) : "-";
}

/// Of a pass or of all of them: voxels visited, changed, the ratio, kB, us, us of a copy, ratio.
std::vector<std::string> touched_cells(const Json& json) {
    return {cell(json, "voxels_visited_a_step", 0),
            cell(json, "voxels_changed_a_step", 0),
            cell(json, "visited_per_changed", 1),
            cell(json, "moved_bytes_a_step", 0, 1e-3),
            cell(json, "us_a_step", 0),
            cell(json, "copy_us_a_step", 0),
            cell(json, "time_over_copy", 1)};
}

std::string line(const std::vector<std::string>& cells) {
    std::string text = fmt::format("  {:21}", cells.front());
    for (size_t i = 1; i < cells.size(); ++i) text += fmt::format(" {:>9}", cells[i]);
    return text + "\n";
}

std::vector<std::string> row_of(const std::string& name, const Json& json) {
    std::vector<std::string> cells{name, cell(json, "dispatches_a_step", 1),
                                   cell(json, "columns_a_step", 0)};
    for (std::string& text : touched_cells(json)) cells.push_back(std::move(text));
    return cells;
}

std::vector<std::vector<std::string>> rows_of(const Json& work) {
    std::vector<std::vector<std::string>> rows;
    if (work.contains("passes")) {
        for (const auto& [name, pass] : work["passes"].items()) rows.push_back(row_of(name, pass));
    }
    rows.push_back(row_of("all", work));
    return rows;
}

/// What a scene's tables are of: when, where, how fast.
std::string scene_head(const Json& figures, const Json& scene) {
    const std::time_t now = std::time(nullptr);
    const Json& stages = scene.contains("stages_ms") ? scene["stages_ms"] : Json::object();
    std::string text = fmt::format(
        "{:%Y-%m-%d}, {}, backend {}, {} threads: {} steps, {} a second, {} cores busy. A copy of "
        "256 MB on as many threads moved {} GB/s in the same run. Load of the "
        "machine: {}.\n\n{} ms a step:",
        fmt::gmtime(now), figures.value("device", "unknown device"),
        figures.value("backend", "none"), figures.value("threads", 0), scene.value("steps", 0LL),
        cell(scene, "steps_per_s", 1), cell(scene, "cores_busy", 2),
        cell(figures, "copy_gb_per_s", 1), cell(scene, "load", 1), cell(scene, "ms_a_step", 2));
    double stages_ms = 0;
    for (const auto& [name, ms] : stages.items()) {
        text += fmt::format(" {} {:.2f},", name, ms.get<double>());
        stages_ms += ms.get<double>();
    }
    const double step_ms = scene.value("ms_a_step", 0.0);
    text += fmt::format(" Bullet, bridge and scene {:.2f}.", step_ms - stages_ms);
    if (scene.value("step_ms_median", 0.0) > 0) {
        text += fmt::format(" The median step took {} ms, the longest {}.",
                            cell(scene, "step_ms_median", 2), cell(scene, "step_ms_most", 2));
    }
    text += fmt::format(
        " Voxels active: {} of {} in the mean. {} bytes an awake voxel, {} bytes a sleeping "
        "column.",
        cell(scene, "voxels_active_mean", 0), scene.value("voxels_total", 0LL),
        cell(scene, "bytes_an_awake_voxel", 1), cell(scene, "bytes_a_sleeping_column", 1));
    return text + "\n\n";
}

}  // namespace

CountingKernels::CountingKernels() {
    if (const char* before = std::getenv(kKernelsVariable)) {
        before_ = before;
        was_set_ = true;
    }
    setenv(kKernelsVariable, "counting", 1);
}

CountingKernels::~CountingKernels() {
    if (was_set_) {
        setenv(kKernelsVariable, before_.c_str(), 1);
    } else {
        unsetenv(kKernelsVariable);
    }
}

double copy_bytes_per_s(int thread_count) {
    constexpr size_t kWords = size_t{32} << 20;
    const std::vector<uint64_t> from(kWords, 1);
    std::vector<uint64_t> to(kWords);
    const size_t share = kWords / static_cast<size_t>(thread_count);
    const auto copy_share = [&](int thread) {
        const auto first = static_cast<ptrdiff_t>(share * static_cast<size_t>(thread));
        std::copy_n(from.begin() + first, share, to.begin() + first);
    };
    double best = 0;
    for (int round = 0; round < 5; ++round) {
        const auto start = std::chrono::steady_clock::now();
        {
            std::vector<std::jthread> threads;
            for (int i = 1; i < thread_count; ++i) threads.emplace_back(copy_share, i);
            copy_share(0);
        }
        const double took_s =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        const size_t words = share * static_cast<size_t>(thread_count);
        best = std::max(best, 2 * static_cast<double>(words * sizeof(uint64_t)) / took_s);
    }
    return best;
}

WorkCounts difference(const WorkCounts& before, WorkCounts after) {
    after.dispatch_count -= before.dispatch_count;
    after.read_count -= before.read_count;
    after.read_bytes -= before.read_bytes;
    after.wait_count -= before.wait_count;
    after.write_count -= before.write_count;
    after.write_bytes -= before.write_bytes;
    for (size_t i = 0; i < before.passes.size(); ++i) {
        const PassWork& was = before.passes[i];
        PassWork& is = after.passes[i];
        is.dispatch_count -= was.dispatch_count;
        is.column_count -= was.column_count;
        is.time_ms -= was.time_ms;
        is.voxel_visited_count -= was.voxel_visited_count;
        is.voxel_changed_count -= was.voxel_changed_count;
        is.moved_bytes -= was.moved_bytes;
    }
    return after;
}

Json print_work(const SceneWork& work) {
    Json json;
    const double steps = work.step_count;
    Touched all;
    double all_us = 0;
    for (size_t i = 0; i < work.timed.passes.size(); ++i) {
        const PassWork& pass = work.timed.passes[i];
        if (pass.dispatch_count == 0) continue;
        Json of_pass{{"dispatches_a_step", static_cast<double>(pass.dispatch_count) / steps},
                     {"columns_a_step", static_cast<double>(pass.column_count) / steps},
                     {"us_a_step", pass.time_ms * 1e3 / steps}};
        all_us += pass.time_ms * 1e3 / steps;
        if (!work.touched.passes.empty()) {
            const Touched touched = touched_by(work, i);
            all.add(touched);
            of_pass.update(touched.json());
        }
        json["passes"][pass.name] = of_pass;
    }
    json["dispatches_a_step"] = static_cast<double>(work.timed.dispatch_count) / steps;
    json["reads_a_step"] = static_cast<double>(work.timed.read_count) / steps;
    json["read_bytes_a_step"] = static_cast<double>(work.timed.read_bytes) / steps;
    json["write_bytes_a_step"] = static_cast<double>(work.timed.write_bytes) / steps;
    json["us_a_step"] = all_us;
    if (!work.touched.passes.empty()) json.update(all.json());

    fmt::print("{}", line({"pass", "a step", "columns", "visited", "changed", "ratio", "kB", "us",
                           "us copied", "ratio"}));
    for (const auto& row : rows_of(json)) fmt::print("{}", line(row));
    fmt::print("  a step: {} dispatches; {} reads of {} kB, {} kB written\n",
               cell(json, "dispatches_a_step", 1), cell(json, "reads_a_step", 1),
               cell(json, "read_bytes_a_step", 0, 1e-3), cell(json, "write_bytes_a_step", 0, 1e-3));
    if (!work.touched.passes.empty()) {
        fmt::print(
            "  {} voxels visited for one changed; passes take {} times a copy of their bytes\n",
            cell(json, "visited_per_changed", 1), cell(json, "time_over_copy", 1));
    }
    return json;
}

std::string work_table(const Json& work) {
    std::string text = fmt::format(
        "A step: {} dispatches, {} reads of {} kB, {} kB written.",
        cell(work, "dispatches_a_step", 1), cell(work, "reads_a_step", 1),
        cell(work, "read_bytes_a_step", 0, 1e-3), cell(work, "write_bytes_a_step", 0, 1e-3));
    if (work.contains("voxels_visited_a_step")) {
        text += fmt::format(
            " {} voxels visited for one changed. Passes take {} times a copy of their bytes.",
            cell(work, "visited_per_changed", 1), cell(work, "time_over_copy", 1));
    }
    text += "\n\n";
    text += experiment::table_head({"pass", "times a step", "columns", "voxels visited",
                                    "voxels changed", "visited for one", "kB moved", "us",
                                    "us of a copy", "time over copy"});
    for (const auto& row : rows_of(work)) text += experiment::table_row(row);
    return text;
}

Result<std::string> update_tables(std::string page, const Json& figures) {
    const auto put = [&page](const std::string& name, const std::string& text) -> Status {
        const auto block = experiment::block_of(page, "bench", name);
        if (!block) return Error{block.error()};
        page.replace(block->begin, block->end - block->begin, "\n" + text + "\n");
        return Done{};
    };
    if (figures.contains("scenes")) {
        for (const auto& [path, scene] : figures["scenes"].items()) {
            std::string text = scene_head(figures, scene);
            if (scene.contains("work")) text += work_table(scene["work"]);
            const Status done = put(std::filesystem::path(path).stem().string(), text);
            if (!done) return Error{done.error()};
        }
    }
    if (figures.contains("sweeps")) {
        const Status done = put("sweeps", sweep_tables(figures["sweeps"]));
        if (!done) return Error{done.error()};
    }
    return page;
}

}  // namespace bsoil::command
