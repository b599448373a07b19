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
};

/// Work of all steps, fills and questions since the soil was created. Counts that a device makes
/// are the same on every machine.
struct WorkCounts {
    int64_t dispatch_count = 0;
    int64_t read_count = 0, read_bytes = 0;    ///< from the device; each read waits for it once
    int64_t write_count = 0, write_bytes = 0;  ///< to the device
    std::vector<PassWork> passes;              ///< in the order of the kernels
};

}  // namespace bsoil
#pragma GCC visibility pop
