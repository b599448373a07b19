/// A set of kernels in both forms, compiled C++ and embedded GLSL, and the buffers they work on.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "device/device.h"

namespace bsoil::device {

inline constexpr int kLanesPerGroup = 64;   ///< local_size_x in shaders/prelude.glsl
inline constexpr int kBufferCapacity = 16;  ///< buffers of a set; GL 4.5 alone promises 8

/// What the counting kernels have touched in the dispatch at hand. A mark is the dispatch's number
/// and the bits below.
struct TouchNotes {
    static constexpr uint32_t kRead = 1, kWritten = 2;     ///< of a word
    static constexpr uint32_t kVisited = 1, kChanged = 2;  ///< of a cell
    static constexpr uint32_t kBits = 3;
    std::vector<uint32_t> words[kBufferCapacity];  ///< a mark for each word of each buffer
    std::vector<uint32_t> cells;                   ///< a mark for each cell, as far as seen
    uint32_t dispatch = 0;                         ///< its number, behind the bits
    TouchCounts counts;                            ///< of this dispatch
};

/// What a kernel reads and writes on the CPU.
struct KernelMemory {
    int32_t* buffers[kBufferCapacity] = {};
    const int32_t* params = nullptr;  ///< KernelSet::param_words of them
    TouchNotes* notes = nullptr;      ///< for counting kernels
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
    std::span<const KernelInfo> kernels;       ///< Device::dispatch takes an index into this
    std::span<const KernelInfo> wide_kernels;  ///< the same for CPUs with AVX2, or none
    /// The same, noting what they touch in KernelMemory::notes, on one thread; or none.
    std::span<const KernelInfo> counting_kernels;
    std::span<const char* const> buffers;  ///< names in the kernels; BufferIndex is the place
    std::span<const bool> are_long;  ///< by buffer: it may lie in several storage blocks of OpenGL
    int param_words = 0;             ///< of the uniform block
    std::span<const ShaderFile> files;          ///< everything the kernels' GLSL is made from
    std::string_view params_file, layout_file;  ///< of `files`: members of the uniform block; the
                                                ///< constants that kernels and host share
    std::string_view common_file;               ///< of `files`: helpers of all kernels of the set
};

}  // namespace bsoil::device
