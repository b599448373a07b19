/// What the kernel collect_contacts finds in a voxel where a body meets soil, in words and decoded.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bsoil/geometry.h"
#include "bsoil/work_threads.h"

namespace bsoil {

/// A voxel that a body's surface goes through, with soil beside it. Amounts and lengths as the
/// kernel counts them: kVoxelFull units are a voxel, or a voxel's side.
struct ContactRecord {
    int voxel[3] = {};    ///< of a small body: that with its middle
    int body = 0;         ///< index of its record in Buffer::shapes
    int carrier = -1;     ///< the same of the body that the soil rests on; kOnGround
    Vec3 gradient;        ///< of the bodies' coverage, over two voxels [units]; 0: a small body's
    Vec3 gap;             ///< room that the soil leaves along x, y, z [units]
    double excess = 0;    ///< soil and bodies beyond the voxel's room [units]
    int material = 0;     ///< of most of the soil
    double density = -1;  ///< relative density of the soil [units]; kDensityFixed
    int saturation = 0;   ///< share of its pores that water fills [units]
    int undisturbed = 0;  ///< share of it that was never moved [units]
    bool is_between_walls = false;  ///< ContactVoxel::is_between_walls
    /// Voxels from this one up to the lowest soil over it, where the body carries that; else -1.
    int load_above = -1;
    /// On which sides it lies there beside soil on the ground: +x, -x, +y, -y, a bit each.
    int load_sides = 0;
    /// One record for all of a small body: see collect_small_bodies.
    bool is_of_small_body() const { return dot(gradient, gradient) == 0; }
};

/// Where decode_contacts() sorts; keeps its memory from one call to the next.
struct ContactOrder {
    struct Entry {
        uint64_t key = 0;      ///< what a contact is sorted by
        uint32_t contact = 0;  ///< where its words are
    };
    std::vector<Entry> entries, room;
    std::vector<uint32_t> places;  ///< of the next entry with a digit, part by part
};

/// Decodes words of Buffer::result, kContactWords a contact. The device appends in any order; here
/// those of soil on the ground come first, then carrier by carrier, each by place and body.
/// threads: to share the work, or null.
void decode_contacts(std::span<const int32_t> words, ContactOrder& order,
                     std::vector<ContactRecord>& out, const WorkThreads* threads = nullptr);

}  // namespace bsoil
