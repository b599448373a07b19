/// Patches, their elements and motions of bodies in a snapshot.
#pragma once

#include <algorithm>
#include <span>

#include "bsoil/contact/contact_motion.h"
#include "bsoil/contact/contact_patches.h"
#include "bsoil/snapshot_file.h"

namespace bsoil::bullet {

inline void list(StateStream& stream, BodyMotion& motion) {
    stream(motion.pose, motion.center_of_mass_m, motion.linear_velocity_m_s,
           motion.angular_velocity_rad_s);
}

inline void list(StateStream& stream, ContactPatch& patch) {
    stream(patch.bin, patch.carrier, patch.point_m, patch.normal, patch.normal_limit_n,
           patch.friction, patch.adhesion_n, patch.area_m2, patch.rebound_m, patch.found_limit_n,
           patch.shear_point_m, patch.shear_share);
    if (patch.bin < 0 || patch.bin >= kNormalBinCount) stream.refuse();
}

inline void list(StateStream& stream, PatchElement& element) {
    stream(element.patch, element.normal, element.pushed_n, element.depth_m, element.retreat_m);
}

/// Whether each is of a patch, and has a depth to divide by.
inline bool are_elements_sound(std::span<const PatchElement> elements, size_t patch_count) {
    return std::ranges::all_of(elements, [patch_count](const PatchElement& element) {
        return element.patch >= 0 && static_cast<size_t>(element.patch) < patch_count &&
               element.depth_m > 0;
    });
}

}  // namespace bsoil::bullet
