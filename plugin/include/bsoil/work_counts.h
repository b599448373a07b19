/// What a soil's steps have cost so far: for benches and for tests that hold a gain.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bsoil/cxx20.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Work of one pass (a kernel) in all steps.
struct PassWork {
    std::string name;
    int64_t dispatch_count = 0;
    /// Columns of 8 voxels that it looked at: the same on every machine. The CPU backend counts
    /// them; with OpenGL 0.
    int64_t column_count = 0;
    /// That it took the device [ms]; with OpenGL by the GPU's clock, without those of the last step
    /// or two.
    double time_ms = 0;
    // The rest is 0 but where BULLETSOIL_CPU=counting is in the environment when a soil is created
    // on the CPU. Its kernels then run on one thread and count: slower, with the same bits. Counts
    // are by dispatch, and summed over them.
    int64_t voxel_visited_count = 0;  ///< of whose state or deltas it read or wrote a word
    int64_t voxel_changed_count = 0;  ///< of these, those where it wrote another value
    /// Of all buffers, each word that it read and each that it wrote: what a pass without a wasted
    /// access moves.
    int64_t moved_bytes = 0;
};

/// Work of all steps, fills and questions since the soil was created. Counts that a device makes
/// are the same on every machine.
struct WorkCounts {
    int64_t dispatch_count = 0;
    int64_t read_count = 0, read_bytes = 0;    ///< from the device
    int64_t wait_count = 0;                    ///< of these, those that waited for a GPU
    int64_t write_count = 0, write_bytes = 0;  ///< to the device
    std::vector<PassWork> passes;              ///< in the order of the kernels
};

/// How a soil has kept up with its caller; see SoilDef::step_budget_ms.
struct StepRate {
    int64_t due_count = 0;  ///< calls of Soil::step()
    /// In which a step began. The soil has dropped the time of the others.
    int64_t begun_count = 0;
    /// That took longer than the budget, because a step had been spread over step_spread_max calls.
    int64_t held_count = 0;
    int call_count_most = 0;  ///< calls over which a step was spread, at most
    double call_most_ms = 0;  ///< the longest call; known with a budget only
    /// Of the world's time, 0..1.
    double share() const {
        return due_count > 0 ? static_cast<double>(begun_count) / static_cast<double>(due_count)
                             : 1;
    }
};

}  // namespace bsoil
#pragma GCC visibility pop
