#include "sweep_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <new>
#include <thread>

#include "measured_data.h"

namespace bsoil::experiment {
namespace {

/// How often progress is shown.
constexpr std::chrono::milliseconds kProgressInterval{200};

/// Of a point that needs more memory than there is an error: the others may need less.
PointRun run_point(const RigSetup& setup, std::atomic<double>& done) {
    PointRun run;
    try {
        auto output = run_rig(setup, [&](double fraction) {
            done.store(std::clamp(fraction, 0.0, 1.0), std::memory_order_relaxed);
        });
        if (output) {
            run.output = std::move(*output);
        } else {
            run.error = output.error();
        }
    } catch (const std::bad_alloc&) {
        run.error = "the memory of this machine is full; lower `size_m`, or give fewer --threads";
    }
    return run;
}

}  // namespace

std::vector<PointRun> run_points(const std::vector<const RigSetup*>& setups, int thread_count,
                                 const SweepProgress& progress) {
    const size_t point_count = setups.size();
    std::vector<PointRun> runs(point_count);
    std::vector<std::atomic<double>> fractions(point_count);
    std::atomic<size_t> next{0};
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<size_t> finished;  // guarded by the mutex

    const auto work = [&] {
        for (size_t i = next++; i < point_count; i = next++) {
            const auto start = std::chrono::steady_clock::now();
            runs[i] = run_point(*setups[i], fractions[i]);
            runs[i].wall_s =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            fractions[i] = 1;
            const std::lock_guard lock(mutex);
            finished.push_back(i);
            changed.notify_one();
        }
    };
    const size_t wanted = thread_count > 0 ? static_cast<size_t>(thread_count)
                                           : std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::thread> threads;
    for (size_t t = 0; t < std::min(wanted, point_count); ++t) threads.emplace_back(work);

    std::unique_lock lock(mutex);
    for (size_t told = 0; told < point_count;) {
        changed.wait_for(lock, kProgressInterval, [&] { return finished.size() > told; });
        for (; told < finished.size(); ++told) {
            if (progress.finished) progress.finished(finished[told], runs[finished[told]]);
        }
        double sum = 0;
        for (const std::atomic<double>& fraction : fractions) sum += fraction;
        if (progress.advanced) progress.advanced(sum / static_cast<double>(point_count));
    }
    lock.unlock();
    for (std::thread& thread : threads) thread.join();
    return runs;
}

std::vector<PointRun> run_sweep(const Experiment& experiment, int thread_count,
                                const SweepProgress& progress) {
    std::vector<const RigSetup*> setups;
    for (const Point& point : experiment.points) setups.push_back(&point.setup);
    return run_points(setups, thread_count, progress);
}

std::vector<Verdict> verdicts_on(const std::vector<PointRun>& runs) {
    std::vector<Verdict> verdicts;
    for (size_t i = 0; i < runs.size(); ++i) {
        for (const std::string& fault : runs[i].output.faults) {
            verdicts.push_back({Verdict::Kind::fail, fmt::format("point {}: {}", i, fault)});
        }
    }
    return verdicts;
}

CsvTable result_table(const Experiment& experiment, const std::vector<PointRun>& runs) {
    CsvTable table;
    table.columns = {"point"};
    std::vector<std::string> keys;
    if (!experiment.points.empty()) {
        for (const Parameter& p : experiment.points.front().parameters) keys.push_back(p.name);
    }
    table.columns.insert(table.columns.end(), keys.begin(), keys.end());
    const std::vector<std::string>& results = result_columns(experiment.rig);
    table.columns.insert(table.columns.end(), results.begin(), results.end());
    for (size_t i = 0; i < runs.size(); ++i) {
        for (const std::vector<double>& values : runs[i].output.results) {
            std::vector<std::string>& row = table.rows.emplace_back();
            row.push_back(std::to_string(i));
            for (const Parameter& p : experiment.points[i].parameters) row.push_back(p.text);
            for (const double value : values) row.push_back(cell(value));
        }
    }
    if (experiment.measured.rows.empty()) return table;
    const std::string station = station_column(experiment.rig);
    if (!station.empty()) keys.push_back(station);
    add_measured(table, experiment.measured, keys);
    return table;
}

CsvTable series_table(const RigOutput& output) {
    CsvTable table;
    table.columns = output.series_columns;
    for (const std::vector<double>& values : output.series) {
        std::vector<std::string>& row = table.rows.emplace_back();
        for (const double value : values) row.push_back(cell(value));
    }
    return table;
}

}  // namespace bsoil::experiment
