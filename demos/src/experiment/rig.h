/// The rigs: what they measure, and running one.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "experiment.h"

namespace bsoil::experiment {

/// What one run of a rig leaves behind.
struct RigOutput {
    std::vector<std::vector<double>> results;  ///< rows of result_columns()
    std::vector<std::string> series_columns;   ///< "time_s" first
    std::vector<std::vector<double>> series;   ///< one row for each step of the soil
    std::vector<std::string> status;  ///< sticky conditions of the soil, empty when all is well
    /// Why the results are not what their columns say: a tool that hangs on its stop, a heap that
    /// still moves. Empty when all is well.
    std::vector<std::string> faults;
};

/// Called with the share of the run that is done, 0..1.
using RigProgress = std::function<void(double)>;

/// "plate", "blade", "traction", "shear", "column".
std::vector<std::string> rig_names();
/// Headings of RigOutput::results; `rig` is the name of a rig's table and command.
const std::vector<std::string>& result_columns(const std::string& rig);
/// The result that each row of a run has a given value of: "sinkage_m" of a plate; empty for a rig
/// with one row a run.
std::string station_column(const std::string& rig);

/// How far the carriage of a wheel goes in a pass [m]: where the rim's speed is held, not as far as
/// the rim rolls, or farther.
double carriage_way_m(const TractionItem& wheel);

/// Builds the rig in a world and a soil of its own and runs it, on one thread. The error says what
/// could not be made.
Result<RigOutput> run_rig(const RigSetup& setup, const RigProgress& progress);

}  // namespace bsoil::experiment
