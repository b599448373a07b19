/// A set of kernels in both forms, compiled C++ and embedded GLSL, and the devices made of one.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "device/device.h"

namespace bsoil::device {

/// The uniform block of every kernel.
struct KernelParams {
#include "soil_params.h"
};
inline constexpr int kParamWords = sizeof(KernelParams) / sizeof(int32_t);
inline constexpr int kLanesPerGroup = 64;  ///< local_size_x in shaders/prelude.glsl

/// What a kernel reads and writes on the CPU.
struct KernelMemory {
    int32_t* buffers[kBufferCount] = {};
    KernelParams params{};
};

struct KernelInfo {
    const char* name;
    bool is_scatter;  ///< adds to neighbouring tiles: the colours of a WorkList run one after the
                      ///< other
    /// The compiled kernel: all lanes of the groups first_group .. first_group + group_count - 1,
    /// in order.
    void (*run)(const KernelMemory& memory, int first_group, int group_count);
};

/// A shader text as it was when the library was built.
struct ShaderFile {
    std::string_view name, text;
};

struct KernelSet {
    std::span<const KernelInfo> kernels;  ///< Device::dispatch takes an index into this
    std::span<const ShaderFile> files;    ///< everything the kernels' GLSL is put together from
    std::string_view common_file;         ///< of `files`: helpers of all kernels of the set
};

/// The kernels of shaders/kernel_list.h, in its order.
const KernelSet& soil_kernel_set();

/// As the functions of the same names in device.h, for any set of kernels, which must outlive the
/// device.
std::unique_ptr<Device> create_cpu_device(const KernelSet& kernel_set, int thread_count);
Result<std::unique_ptr<Device>> create_gl_device(const KernelSet& kernel_set, bool allow_software);

}  // namespace bsoil::device
