/// A set of kernels in both forms, compiled C++ and embedded GLSL, and the buffers they work on.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "device/device.h"

namespace bsoil::device {

inline constexpr int kLanesPerGroup = 64;   ///< local_size_x in shaders/prelude.glsl
inline constexpr int kBufferCapacity = 16;  ///< buffers of a set; GL 4.5 alone promises 8

/// What a kernel reads and writes on the CPU.
struct KernelMemory {
    int32_t* buffers[kBufferCapacity] = {};
    const int32_t* params = nullptr;  ///< KernelSet::param_words of them
};

struct KernelInfo {
    const char* name;
    bool is_scatter;  ///< adds to neighbouring tiles: the colours of a WorkList run one after the
                      ///< other
    /// The compiled kernel: all lanes of the groups first_group .. first_group + group_count - 1,
    /// in order. Returns how many lanes had work.
    int64_t (*run)(const KernelMemory& memory, int first_group, int group_count);
};

/// A shader text as it was when the library was built.
struct ShaderFile {
    std::string_view name, text;
};

struct KernelSet {
    std::span<const KernelInfo> kernels;        ///< Device::dispatch takes an index into this
    std::span<const KernelInfo> wide_kernels;   ///< the same for CPUs with AVX2, or none
    std::span<const char* const> buffers;       ///< names in the kernels; BufferIndex is the place
    int param_words = 0;                        ///< of the uniform block
    std::span<const ShaderFile> files;          ///< everything the kernels' GLSL is made from
    std::string_view params_file, layout_file;  ///< of `files`: members of the uniform block; the
                                                ///< constants that kernels and host share
    std::string_view common_file;               ///< of `files`: helpers of all kernels of the set
};

}  // namespace bsoil::device
