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

/// Kernels by number: see kernels.h.
enum class Kernel;

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

/// Buffer::result: the header and the loads of all bodies, what the flows did, then the contact
/// records, aligned to their length. They are last, since there may come to be room for more.
/// @{
inline constexpr int kFlowResultsFirst = kResultHeader + limits::kBodyCapacity * kLoadWords;
inline constexpr int kContactsFirst =
    (kFlowResultsFirst + kFlowCapacity * kFlowResultWords + kContactWords - 1) / kContactWords *
    kContactWords;
/// @}

/// Planes of the voxels by the number of materials; water: 1 where soil takes it, else 0. What
/// moves with the soil has a delta plane; that and terrain are kept while a tile is asleep.
/// @{
constexpr int transported_planes(int materials, int water) {
    return kPlaneMaterial - kTransportFirst + materials + water;
}
constexpr int state_planes(int materials, int water) {
    return kTransportFirst + transported_planes(materials, water);
}
constexpr int kept_planes(int materials, int water) {
    return 1 + transported_planes(materials, water);
}
/// @}

/// Words that a column of an awake tile takes in Buffer::spans, without those of its tile.
inline constexpr int kColumnWordsInAll = kColumnWords + kColumnArrays;

/// Words that an awake tile takes in all buffers with a slot for it.
constexpr int64_t slot_words(int height, int materials, int water) {
    const int planes = state_planes(materials, water) + transported_planes(materials, water);
    return int64_t{kTileColumns} * (int64_t{height} * planes + kColumnWordsInAll) +
           int64_t{height / kTileSide} * (kFlagArrays + kMaskWords) + kTileArrays + kTileTableWords;
}

/// A 64-bit sum of the kernels, see add_wide().
inline int64_t wide_sum(const int32_t* words) {
    return static_cast<int64_t>(static_cast<uint64_t>(static_cast<uint32_t>(words[1])) << 32 |
                                static_cast<uint32_t>(words[0]));
}

/// Kilograms of one mass unit: a full voxel of this density has exactly kVoxelFull units.
inline constexpr double kReferenceDensity = 2000;

}  // namespace bsoil::layout
