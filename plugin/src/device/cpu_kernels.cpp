/// The kernels of one set as C++: the GLSL texts, read as the body of a struct whose members are
/// the buffers.
///
/// kernel_set.cmake compiles this file once per set and defines
///   BSOIL_KERNEL_SET      the function to define, e.g. soil_kernel_set
///   BSOIL_SHADER_FILES    the function with the embedded texts, e.g. soil_shader_files
///   BSOIL_KERNEL_LIST     the list: PLAIN(name) or SCATTER(name) per kernel
///   BSOIL_KERNEL_COMMON   the name of the text of helpers that all kernels of the set share
///   BSOIL_KERNEL_BODIES   a generated file that includes that text and the text of every kernel on
///   the list
#include "device/cpu_shim.h"
#include "device/kernel_set.h"

namespace bsoil::device {

std::span<const ShaderFile> BSOIL_SHADER_FILES();
const KernelSet& BSOIL_KERNEL_SET();

namespace {

using namespace shim;

struct Kernels {
    explicit Kernels(const KernelMemory& memory)
        : state(buffer(memory, Buffer::state)),
          delta(buffer(memory, Buffer::delta)),
          tile_table(buffer(memory, Buffer::tile_table)),
          block_list(buffer(memory, Buffer::block_list)),
          block_flags(buffer(memory, Buffer::block_flags)),
          spans(buffer(memory, Buffer::spans)),
          shapes(buffer(memory, Buffer::shapes)),
          tables(buffer(memory, Buffer::tables)),
          result(buffer(memory, Buffer::result)),
          params(memory.params) {}

    static int32_t* buffer(const KernelMemory& memory, Buffer buffer) {
        return memory.buffers[static_cast<int>(buffer)];
    }

    int32_t* const state;
    int32_t* const delta;
    int32_t* const tile_table;
    int32_t* const block_list;
    int32_t* const block_flags;
    int32_t* const spans;
    int32_t* const shapes;
    int32_t* const tables;
    int32_t* const result;
    const KernelParams params;

#include "exact_math.glsl"
#include "soil_layout.h"
#include BSOIL_KERNEL_BODIES
};

template <void (Kernels::*kernel)(int group, int lane)>
void run(const KernelMemory& memory, int first_group, int group_count) {
    Kernels kernels(memory);
    for (int group = first_group; group < first_group + group_count; ++group) {
        for (int lane = 0; lane < kLanesPerGroup; ++lane) {
            (kernels.*kernel)(group, lane);
        }
    }
}

}  // namespace

const KernelSet& BSOIL_KERNEL_SET() {
    static constexpr KernelInfo kKernels[] = {
#define PLAIN(name) {#name, false, &run<&Kernels::name>},
#define SCATTER(name) {#name, true, &run<&Kernels::name>},
#include BSOIL_KERNEL_LIST
#undef PLAIN
#undef SCATTER
    };
    static const KernelSet set{kKernels, BSOIL_SHADER_FILES(), BSOIL_KERNEL_COMMON};
    return set;
}

}  // namespace bsoil::device
