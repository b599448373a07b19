/// is_same_contact: whether two contact voxels are the same, number by number.
#pragma once

#include "bsoil/body.h"

namespace bsoil::bullet {

inline bool is_same_vector(Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

inline bool is_same_row(const ToothRow& a, const ToothRow& b) {
    return a.height_m == b.height_m && a.thickness_m == b.thickness_m && a.pitch_m == b.pitch_m &&
           a.above_m == b.above_m && is_same_vector(a.outward, b.outward) && a.part == b.part;
}

static_assert(sizeof(void*) != 8 || sizeof(ContactVoxel) == 240,
              "a new field of ContactVoxel is compared here as well");
inline bool is_same_contact(const ContactVoxel& a, const ContactVoxel& b) {
    return a.body == b.body && a.carrier == b.carrier && is_same_vector(a.center_m, b.center_m) &&
           is_same_vector(a.position_m, b.position_m) && is_same_vector(a.normal, b.normal) &&
           a.area_m2 == b.area_m2 && a.depth_m == b.depth_m && a.gap_m == b.gap_m &&
           a.touching == b.touching && a.compression_m == b.compression_m &&
           a.bearing_depth_m == b.bearing_depth_m && a.material == b.material &&
           a.relative_density == b.relative_density && a.saturation == b.saturation &&
           a.undisturbed == b.undisturbed && a.inflow_share == b.inflow_share &&
           a.is_between_walls == b.is_between_walls && a.is_load_side == b.is_load_side &&
           is_same_row(a.teeth, b.teeth);
}

}  // namespace bsoil::bullet
