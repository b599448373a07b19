/// The kernels' layout constants and uniform block for host code.
#pragma once

#include <cstdint>

#include "bsoil/limits.h"
#include "bsoil/material.h"
#include "device/device.h"

namespace bsoil::layout {

#define CONST_INT(name, value) inline constexpr int name = value;
#include "soil_layout.h"
#undef CONST_INT

/// The uniform block; the same integers in the same order for C++ and std140.
struct SoilParams {
#include "soil_params.h"
};

/// Kernels by number, in the order of kernel_list.h.
enum class Kernel {
#define PLAIN(name) name,
#define SCATTER(name) name,
#include "kernel_list.h"
#undef PLAIN
#undef SCATTER
};

/// The kernels' buffers, in the order of buffer_list.h.
struct Buffer {
    enum Place {
#define BUFFER(name) place_of_##name,
#include "buffer_list.h"
#undef BUFFER
    };
#define BUFFER(name) static constexpr device::BufferIndex name{place_of_##name};
#include "buffer_list.h"
#undef BUFFER
};

/// Buffer::result: the header and the loads of all bodies, then the contact records.
inline constexpr int kContactsFirst = kResultHeader + limits::kBodyCapacity * kLoadWords;

/// A 64-bit sum of the kernels, see add_wide().
inline int64_t wide_sum(const int32_t* words) {
    return static_cast<int64_t>(static_cast<uint64_t>(static_cast<uint32_t>(words[1])) << 32 |
                                static_cast<uint32_t>(words[0]));
}

/// Kilograms of one mass unit: a full voxel of this density has exactly kVoxelFull units.
inline constexpr double kReferenceDensity = 2000;

}  // namespace bsoil::layout
