/// How the cost of a step goes with threads, size, alpha, voxels and bodies.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "bsoil/soil.h"

namespace bsoil::command {

/// Prints the sweeps, a row for each soil, and returns them: milliseconds a step, and what its
/// passes touch. `step_count` steps of each are timed after as many that warm up, and made once
/// more by kernels that count. Takes a minute or two.
Result<nlohmann::ordered_json> time_sweeps(Backend backend, int thread_count, int step_count);

/// The same as tables (Markdown).
std::string sweep_tables(const nlohmann::ordered_json& sweeps);

}  // namespace bsoil::command
