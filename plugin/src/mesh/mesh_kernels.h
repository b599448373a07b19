/// The kernels that mesh the surface on a device: their layout, their uniform block, and the
/// constants that the CPU's mesher shares with them.
#pragma once

#include "device/device.h"

namespace bsoil::device {
/// The kernels of shaders/mesh/kernel_list.h over the buffers of shaders/mesh/buffer_list.h.
#pragma GCC visibility push(default)
const KernelSet& mesh_kernel_set();
#pragma GCC visibility pop
}  // namespace bsoil::device

namespace bsoil::mesh::kernels {

#define CONST_INT(name, value) inline constexpr int name = value;
#define CONST_FLOAT(name, value) inline constexpr float name = value;
#include "mesh/mesh_layout.h"
#undef CONST_INT
#undef CONST_FLOAT

/// The uniform block; the same integers in the same order for C++ and std140.
struct Params {
#include "mesh/mesh_params.h"
};

/// Kernels by number, in the order in which they run.
enum class Kernel {
#define PLAIN(name) name,
#include "mesh/kernel_list.h"
#undef PLAIN
};

struct Buffer {
    enum Place {
#define BUFFER(name) place_of_##name,
#include "mesh/buffer_list.h"
#undef BUFFER
        count
    };
#define BUFFER(name) static constexpr device::BufferIndex name{place_of_##name};
#include "mesh/buffer_list.h"
#undef BUFFER
};

}  // namespace bsoil::mesh::kernels
