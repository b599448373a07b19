/// How the cost of a step goes with threads, size, alpha, voxels and bodies.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bsoil/soil.h"

namespace bsoil::command {

/// Prints the sweeps, a row for each soil, and puts them into `figures`: milliseconds a step, and
/// what its passes touch. `step_count` steps of each are timed after as many that warm up, and made
/// once more by kernels that count. Takes a minute or two. Error: which soil could not be measured;
/// those before it are there.
Status time_sweeps(Backend backend, int thread_count, int step_count,
                   nlohmann::ordered_json& figures);

/// N^3 voxels, for each of `sides`, in all of which blocks push: prints and puts into `figures` how
/// many of them are awake, milliseconds a step, and how many of those the kernels take.
/// `step_count` steps of each are timed after as many that warm up. Error: as of time_sweeps.
Status time_awake(Backend backend, int thread_count, const std::vector<int>& sides, int step_count,
                  nlohmann::ordered_json& figures);

/// The same as tables (Markdown).
/// @{
std::string sweep_tables(const nlohmann::ordered_json& sweeps);
std::string awake_table(const nlohmann::ordered_json& awake);
/// @}

}  // namespace bsoil::command
