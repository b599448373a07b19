/// The constants of ContactLawDef by name and range: one list for whoever goes through them.
#pragma once

#include "bsoil/contact/contact_law_def.h"

namespace bsoil {

/// Calls visit(name, value, low, high) for each constant.
template <typename Visit>
void for_each_constant(const ContactLawDef& law, Visit&& visit) {
    // All members by name: one more does not compile until it stands in the list.
    const auto& [kind, bekker, passive_wedge, trapped_soil, creep, unloading_stiffness,
                 slip_band_slope, open_gap, dense_shear, mobilization, mobilization_fall,
                 wedge_length, sole_surroundings, hollow_share, by_shape, under_way, edge_sine,
                 edge_face, sole_gap, same_across, same_along, memory_reach, same_contact,
                 looks_down] = law;
    static_cast<void>(kind);
    static_cast<void>(bekker);
    visit("passive_wedge", static_cast<double>(passive_wedge), 0.0, 1.0);
    visit("trapped_soil", static_cast<double>(trapped_soil), 0.0, 1.0);
    visit("creep", creep, 0.001, 0.2);
    visit("unloading_stiffness", unloading_stiffness, 1.0, 1000.0);
    visit("slip_band_slope", slip_band_slope, 0.001, 1.0);
    visit("open_gap_voxels", open_gap, 0.01, 2.0);
    visit("dense_shear_share", dense_shear, 0.01, 1.0);
    visit("mobilization_widths", mobilization, 0.01, 1.0);
    visit("mobilization_fall_widths", mobilization_fall, 0.0, 0.99 * mobilization);
    visit("wedge_length", wedge_length, wedge_length == 0 ? 0.0 : 0.5, 5.0);
    visit("sole_surroundings_widths", sole_surroundings, 0.5, 5.0);
    visit("hollow_share", hollow_share, 0.0, 1.0);
    visit("faces_by_shape", static_cast<double>(by_shape), 0.0, 1.0);
    visit("under_way_share", under_way, 0.0, 0.5);
    visit("edge_sine", edge_sine, 0.1, 0.9);
    visit("edge_face_cosine", edge_face, 0.0, 1.0);
    visit("sole_gap_voxels", static_cast<double>(sole_gap), 0.0, 8.0);
    visit("same_across_voxels", same_across, 0.1, 4.0);
    visit("same_along_voxels", same_along, 0.1, 4.0);
    visit("memory_reach_voxels", memory_reach, 0.1, 4.0);
    visit("same_contact_cosine", same_contact, 0.0, 1.0);
    visit("looks_down_cosine", looks_down, 0.0, 1.0);
}

}  // namespace bsoil
