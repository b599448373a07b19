/// The soil's kernels and buffers, and the device that runs them.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "base/layout.h"
#include "bsoil/soil_def.h"
#include "device/kernel_set.h"

namespace bsoil {

namespace device {
/// The kernels of shaders/kernel_list.h over the buffers of shaders/buffer_list.h.
const KernelSet& soil_kernel_set();
}  // namespace device
using device::soil_kernel_set;

/// `automatic`: hardware GL, else CPU. `reason` says in one sentence why.
#pragma GCC visibility push(default)
Result<std::unique_ptr<device::Device>> create_device(Backend backend, int thread_count,
                                                      std::string& reason);
#pragma GCC visibility pop

/// The uniform block as the device takes it.
inline std::span<const int32_t> words_of(const layout::SoilParams& params) {
    return {reinterpret_cast<const int32_t*>(&params), sizeof(params) / sizeof(int32_t)};
}

}  // namespace bsoil
