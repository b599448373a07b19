/// Contacts between bodies and soil: not in the thesis. The surface of a body in a voxel has the
/// area and normal of the coverage field's gradient (central differences, nothing outside of the
/// grid).
///
/// A voxel is a contact when four things hold. The gradient is not zero there. A body owns the
/// voxel or the one inwards of it. Soil lies in it or in the one outwards. That soil rests on the
/// ground or on another body; this is asked of the fullest of the voxel and the two outwards of it
/// that are not mostly body. Where that is soil which the body carries, what counts is the first
/// soil of another kind behind it, no more than eight voxels off along the level part of the
/// gradient. All between has to be full, and the face no flatter than one in four. Inwards and
/// outwards are along the gradient's largest component (z before x before y on a tie).
///
/// Soil on another body is between walls where the row outwards of a level gradient ends at a wall
/// of the contact's own body (held_load.h). It starts at the first voxel of three that is open.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "oracle/field.h"

namespace oracle {

struct Contact {
    int x = 0, y = 0, z = 0;
    int body = 0;
    Vec3 gradient;  ///< of coverage over two voxels: twice the area vector [voxel faces], into the
                    ///< body
    /// Per axis the room that the soil in the voxel and in the next one down the gradient along it
    /// leaves there. An axis along which there is no gradient has that of the largest one.
    Vec3 gap;
    double excess = 0;  ///< soil beyond the voxel's room
    int material = 0;
    /// Of the soil along the way out with most of that material; -1 where its density is fixed.
    double relative_density = -1;
    int carrier = -1;        ///< body that the soil rests on; -1: the ground
    double undisturbed = 1;  ///< share of that soil by volume that never moved
    bool is_between_walls = false;
    /// Voxels up to the lowest soil over it, in this voxel or the two above, where that is the
    /// body's load; else -1. And by side, +x, -x, +y, -y, whether it ends there at soil on the
    /// ground that fills its voxel.
    int load_above = -1;
    std::array<bool, 4> load_ends{};
};

/// Of all voxels, by z, then y, then x.
std::vector<Contact> find_contacts(const Model& model, const Field& field,
                                   std::span<const Body> bodies);

}  // namespace oracle
