/// Running all points of an experiment over the cores, and the table of their results.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "csv_table.h"
#include "expectation.h"
#include "experiment.h"
#include "rig.h"

namespace bsoil::experiment {

/// One point's run.
struct PointRun {
    RigOutput output;
    std::string error;  ///< why it could not be run, or empty
    double wall_s = 0;
};

/// Watches a sweep, from the thread that runs it.
struct SweepProgress {
    std::function<void(double fraction)> advanced;  ///< of the whole sweep, several times a second
    std::function<void(size_t point, const PointRun& run)> finished;
};

/// Runs every setup, each on one thread, `thread_count` at a time (0: all cores). What comes out
/// does not depend on the number.
std::vector<PointRun> run_points(const std::vector<const RigSetup*>& setups, int thread_count,
                                 const SweepProgress& progress);
/// The same for the points of an experiment.
std::vector<PointRun> run_sweep(const Experiment& experiment, int thread_count,
                                const SweepProgress& progress);

/// A failed verdict for each fault of a run; none where all went well.
std::vector<Verdict> verdicts_on(const std::vector<PointRun>& runs);

/// The table of results.csv.
CsvTable result_table(const Experiment& experiment, const std::vector<PointRun>& runs);
/// The table of a point's series.
CsvTable series_table(const RigOutput& output);

}  // namespace bsoil::experiment
