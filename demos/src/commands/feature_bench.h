/// What each feature of a soil costs beside the plain soil, measured in turn.
#pragma once

#include <nlohmann/json.hpp>

#include "bsoil/soil.h"

namespace bsoil::command {

/// Where the soils run.
struct FeatureDevice {
    Backend backend = Backend::automatic;
    int thread_count = 0;
};

/// Prints a table of processor time a step, by feature, and returns it. Every round runs each soil
/// anew, one after the other, so that what else the machine does falls on all of them; of a soil's
/// rounds the fastest counts. Takes a second or so for each soil and round. A feature can set more
/// soil in motion than the plain soil has: where `is_counted` the table also says how many voxels
/// change, and the time for one. Kernels that count take some ten seconds for each soil.
Result<nlohmann::ordered_json> time_features(FeatureDevice device, int round_count,
                                             bool is_counted);

}  // namespace bsoil::command
