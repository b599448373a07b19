/// The kernels of one set as C++: the GLSL texts, read as the body of a struct whose members are
/// the buffers.
///
/// kernel_set.cmake compiles this file once per set, where the processor may have wider vectors
/// once more for those, and where the set says what its cells are once more to count what is
/// touched. It defines
///   BSOIL_KERNEL_SET      the function to define, e.g. soil_kernel_set
///   BSOIL_WIDE_KERNELS    the function with the kernels for wider vectors, e.g. soil_wide_kernels
///   BSOIL_IS_WIDE         in the second compilation, which defines that one alone
///   BSOIL_COUNTING_KERNELS  the function with the counting kernels, e.g. soil_counting_kernels
///   BSOIL_IS_COUNTING     in the third compilation, which defines that one alone
///   BSOIL_KERNEL_CELLS    in the third: a file with cells_of(), which words belong to a cell
///   BSOIL_SHADER_FILES    the function with the embedded texts, e.g. soil_shader_files
///   BSOIL_KERNEL_LIST     the list: PLAIN(name) or SCATTER(name) per kernel
///   BSOIL_KERNEL_BUFFERS  the list: BUFFER(name) or LONG_BUFFER(name) per buffer, in binding order
///   BSOIL_KERNEL_PARAMS   the members of the uniform block, 32-bit integers
///   BSOIL_KERNEL_LAYOUT   the constants that kernels and host share
///   BSOIL_KERNEL_COMMON   the helpers that all kernels of the set share
///   BSOIL_KERNEL_BODIES   a generated file that includes the helpers and the text of every kernel
///   on the list
#include <array>
#include <bit>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "device/cpu_shim.h"
#include "device/kernel_set.h"
#ifdef BSOIL_IS_COUNTING
#include "device/counted_buffer.h"
#endif

namespace bsoil::device {

std::span<const ShaderFile> BSOIL_SHADER_FILES();
#ifdef BSOIL_WIDE_KERNELS
std::span<const KernelInfo> BSOIL_WIDE_KERNELS();
#endif
#ifdef BSOIL_COUNTING_KERNELS
std::span<const KernelInfo> BSOIL_COUNTING_KERNELS();
#endif
#pragma GCC visibility push(default)
const KernelSet& BSOIL_KERNEL_SET();
#pragma GCC visibility pop

namespace {

using namespace shim;

/// The uniform block of every kernel.
struct KernelParams {
#include BSOIL_KERNEL_PARAMS
};
static_assert(std::is_trivially_copyable_v<KernelParams> &&
              sizeof(KernelParams) % sizeof(int32_t) == 0);

KernelParams params_from(const int32_t* words) {
    KernelParams params;
    std::memcpy(&params, words, sizeof(params));
    return params;
}

enum BufferPlace {
#define BUFFER(name) place_of_##name,
#include BSOIL_KERNEL_BUFFERS
#undef BUFFER
};

#ifdef BSOIL_IS_COUNTING
#include BSOIL_KERNEL_CELLS

using BufferWords = CountedBuffer;
BufferWords words_of(const KernelMemory& memory, BufferPlace place, const KernelParams& params) {
    return {memory, place, cells_of(place, params)};
}
#else
using BufferWords = int32_t*;
BufferWords words_of(const KernelMemory& memory, BufferPlace place, const KernelParams&) {
    return memory.buffers[place];
}
#endif

struct Kernels {
    explicit Kernels(const KernelMemory& memory)
        : params(params_from(memory.params))
#define BUFFER(name) , name(words_of(memory, place_of_##name, params))
#include BSOIL_KERNEL_BUFFERS
#undef BUFFER
    {
    }

    const KernelParams params;
#define BUFFER(name) const BufferWords name;
#include BSOIL_KERNEL_BUFFERS
#undef BUFFER
// Words of long buffers: here those lie in one piece, too. GLSL: add_long_buffer() in
// gl_program.cpp.
#define BUFFER(name)
#define LONG_BUFFER(name)                                                             \
    int name##_word(int at) const { return name[at]; }                                \
    void set_##name##_word(int at, int value) const { name[at] = value; }             \
    int add_to_##name(int at, int value) const { return add_owned(name[at], value); } \
    int raise_##name(int at, int value) const { return max_owned(name[at], value); }
#include BSOIL_KERNEL_BUFFERS
#undef BUFFER
#undef LONG_BUFFER

#include "exact_math.glsl"
#include BSOIL_KERNEL_LAYOUT
// Lanes that always have work need no group, and GLSL has no word for that.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include BSOIL_KERNEL_BODIES
#pragma GCC diagnostic pop
};

template <void (Kernels::*kernel)(int group, int lane), int (Kernels::*lanes)(int group, int half)>
int64_t run(const KernelMemory& memory, int first_group, int group_count) {
    Kernels kernels(memory);
    int64_t lane_count = 0;
    for (int group = first_group; group < first_group + group_count; ++group) {
        const auto low = static_cast<uint32_t>((kernels.*lanes)(group, 0));
        const auto high = static_cast<uint32_t>((kernels.*lanes)(group, 1));
        const uint64_t all = low | uint64_t{high} << 32;
        lane_count += std::popcount(all);
        for (uint64_t rest = all; rest != 0; rest &= rest - 1) {
            (kernels.*kernel)(group, std::countr_zero(rest));
        }
    }
    return lane_count;
}

constexpr KernelInfo kKernels[] = {
#define PLAIN(name) {#name, false, &run<&Kernels::name, &Kernels::name##_lanes>},
#define SCATTER(name) {#name, true, &run<&Kernels::name, &Kernels::name##_lanes>},
#include BSOIL_KERNEL_LIST
#undef PLAIN
#undef SCATTER
};

#if !defined(BSOIL_IS_WIDE) && !defined(BSOIL_IS_COUNTING)
/// The name at the end of a path. Only the name gets into the program, not the folder it was built
/// in.
template <size_t kSize>
struct FileName {
    std::array<char, kSize> text{};
    size_t length = 0;
    explicit constexpr FileName(const char (&path)[kSize]) {
        for (const char c : path) {
            if (c == '/') {
                text = {};
                length = 0;
            } else if (c != 0) {
                text[length++] = c;
            }
        }
    }
    constexpr std::string_view view() const { return {text.data(), length}; }
};
#endif

}  // namespace

#ifdef BSOIL_IS_WIDE

std::span<const KernelInfo> BSOIL_WIDE_KERNELS() { return kKernels; }

#elif defined(BSOIL_IS_COUNTING)

std::span<const KernelInfo> BSOIL_COUNTING_KERNELS() { return kKernels; }

#else

const KernelSet& BSOIL_KERNEL_SET() {
    static constexpr FileName kParams(BSOIL_KERNEL_PARAMS);
    static constexpr FileName kLayout(BSOIL_KERNEL_LAYOUT);
    static constexpr FileName kCommon(BSOIL_KERNEL_COMMON);
    static constexpr const char* kBuffers[] = {
#define BUFFER(name) #name,
#include BSOIL_KERNEL_BUFFERS
#undef BUFFER
    };
    static_assert(std::size(kBuffers) <= kBufferCapacity);
    static constexpr bool kAreLong[] = {
#define BUFFER(name) false,
#define LONG_BUFFER(name) true,
#include BSOIL_KERNEL_BUFFERS
#undef BUFFER
#undef LONG_BUFFER
    };
#ifdef BSOIL_WIDE_KERNELS
    const std::span<const KernelInfo> wide_kernels = BSOIL_WIDE_KERNELS();
#else
    const std::span<const KernelInfo> wide_kernels;
#endif
#ifdef BSOIL_COUNTING_KERNELS
    const std::span<const KernelInfo> counting_kernels = BSOIL_COUNTING_KERNELS();
#else
    const std::span<const KernelInfo> counting_kernels;
#endif
    static const KernelSet set{.kernels = kKernels,
                               .wide_kernels = wide_kernels,
                               .counting_kernels = counting_kernels,
                               .buffers = kBuffers,
                               .are_long = kAreLong,
                               .param_words = sizeof(KernelParams) / sizeof(int32_t),
                               .files = BSOIL_SHADER_FILES(),
                               .params_file = kParams.view(),
                               .layout_file = kLayout.view(),
                               .common_file = kCommon.view()};
    return set;
}

#endif

}  // namespace bsoil::device
