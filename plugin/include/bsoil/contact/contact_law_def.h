/// ContactLawDef: which law soil answers bodies by, and every constant of it.
#pragma once

#include <vector>

#include "bsoil/contact/bekker_soil.h"
#include "bsoil/contact/orientation.h"
#include "bsoil/result.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// What soil does to bodies that press on it. Each constant says where it is from and what changes
/// with it. "Ours" is a choice of this project that no measurement gives directly. Its constants
/// stand once more in BSOIL_CONTACT_LAW_FIELDS below, which is what reads, checks, saves and
/// documents them.
struct ContactLawDef {
    /// Which law.
    enum class Kind {
        /// Resistive force theory at each element, its size effect by bearing capacity and passive
        /// wedges, density by Bolton, shear by Janosi: see granular_law.h
        granular,
        /// Bekker's pressure on what looks down, Mohr, Coulomb and Janosi's shear: see bekker_law.h
        bekker,
        /// Three-dimensional resistive force theory alone: density and friction angle, nothing
        /// fitted, no size, no memory of shear: see plain_law.h
        plain,
        /// The work that it takes to move what a face displaces to the free surface: lifting, and
        /// shear under the overburden on its path. Density and friction angle, nothing fitted, with
        /// the width of the body: see work_law.h
        work,
    };
    Kind kind = Kind::granular;
    /// Of each material, in the order of SoilDef::material_list(); for Kind::bekker, else unused.
    std::vector<BekkerSoil> bekker;

    /// @name Rules beside resistive force theory: of Kind::plain, granular and, the second, work
    /// @{
    /// A wall meets no more than its passive wedge (passive_wedge.h). Resistive force theory has no
    /// size: a wide blade would be met as its narrow strips are. The wedge of a sole's inclined
    /// part is that of an endless wall. Kind::granular has Coulomb's wedge instead where this is
    /// off.
    bool passive_wedge = false;
    /// Soil between the teeth of a row (lugs, grousers) goes with them: of what is between two, the
    /// share h tan(45 deg + phi / 2) / (pitch - thickness) of teeth h high, no more than all, as
    /// far as it is filled. There soil slides on soil at the tips and bears as deep as the roots
    /// are; on the rest what the teeth stand on slides by itself. Of shapes with faces_by_shape:
    /// the coverage field has no teeth. Off: each tooth meets the soil as if it stood alone.
    bool trapped_soil = true;
    /// @}

    /// @name Yield of an element
    /// @{
    /// An element that moves less than this share of its body's motion counts as resting: its limit
    /// is that of a push along its normal, and friction holds it in any direction. 0.001..0.2.
    /// Ours: a hundredth is below any slip that is measured, and above what single precision leaves
    /// of a body's motion. Larger: a wheel that slips a little is held like one that does not;
    /// smaller: rounding picks directions.
    double creep = 0.01;
    /// How many times as stiffly soil unloads as it was loaded: a sole of 0.1 m depth has left it
    /// after a rebound of 10 mm. 1..1000. Ours; LETE sand springs back by 16 mm there (Wong 2010).
    /// Larger: less hysteresis in a rut, and gaps open sooner.
    double unloading_stiffness = 10;
    /// The most that a face goes into the soil while it slips along it, as a share of its slip.
    /// Friction is Coulomb's then. Beyond that soil has to flow, and friction is what resistive
    /// force theory finds. 0.001..1. Ours, from direct shear, where a slip band in sand rises or
    /// settles by about a tenth of its slip. Chosen with Kruger's ring and Ding's wheel in view at
    /// 0.01 and at 0.1. Larger: a wheel's front rubs like a dragged plate; smaller: a shear ring
    /// that sinks loses a third of its friction.
    double slip_band_slope = 0.1;
    /// Gap across which soil that the grid holds in the next voxel loses touch [voxels]. 0.01..2.
    /// Ours: a contact must not end in one step where a voxel fills or empties. Larger: bodies bear
    /// on soil that has left them.
    double open_gap_voxels = 0.25;
    /// K of compacted soil over that of loose soil. 0.01..1. Wong gives 25 mm for loose and 6 mm
    /// for firm sand. Larger: dense soil shears later.
    double dense_shear_share = 0.25;
    /// Sinkage over which a sole's bearing develops in loose soil, in widths. 0.01..1. Vesic
    /// (1973) gives a settlement at failure of 5 to 25 % of the width in loose sand. Larger: plates
    /// sink further before they bear.
    double mobilization_widths = 0.15;
    /// How much less it is in compacted soil, in widths. 0..0.99, less than 0.99 of that in loose
    /// soil. Vesic (1973) gives 3 to 7 % of the width in dense sand. Larger: plates on dense soil
    /// bear sooner.
    double mobilization_fall_widths = 0.10;
    /// @}

    /// @name Free surface
    /// @{
    /// Length of the wedge before a wall over its depth. 0..5, at least 0.5; 0: Rankine's
    /// tan(45 deg + phi / 2) with each material's own phi. Larger: soil further ahead counts for a
    /// blade's depth.
    double wedge_length = 0;
    /// That of a material.
    double wedge_length_of(double friction_angle_rad) const;
    /// How many widths around a sole's middle soil counts. 0.5..5. Ours: Prandtl's failure ends
    /// about two widths from the middle, and most of what is pressed up stands nearer. Larger: ruts
    /// and rims further away count.
    double sole_surroundings_widths = 1.5;
    /// Share of the hollow under a sole that counts with the rim around it. 0..1. Ours: what was
    /// pressed out of the one stands in the other, so both together are as high as the soil was.
    /// Smaller, down to 0: depth counts from the soil around alone, as for a bed that a body was
    /// put into without pressing anything out.
    double hollow_share = 1;
    /// @}

    /// @name What the grid makes of a body's surface
    /// @{
    /// Area, place and direction of an element come from the body's shapes; else they come from the
    /// coverage field, which rounds off edges and hardly knows what is thinner than a
    /// voxel. Meshes go by the coverage field in any case. See docs/verification.md.
    bool faces_by_shape = true;
    /// Displaced soil takes a few steps to flow away: excess below this share of a voxel is in
    /// transit and is no compression. 0..0.5. Ours: nine in ten voxels before a rolling wheel have
    /// less than 0.08, whatever their size. Larger: soft contacts sink in first.
    double under_way_share = 0.125;
    /// Sine of the angle from which a gradient beside a face is of an edge. 0.1..0.9. Ours: 20 deg,
    /// more than a round body of three voxels radius turns within a voxel. Larger: edges lose their
    /// second face; smaller: round bodies get walls.
    double edge_sine = 0.34;
    /// Faces round an edge whose normals are further apart than this cosine are different ones.
    /// 0..1. Ours: 45 deg, half the turn round a box's edge. Larger: an edge's second face keeps
    /// the gradient's place.
    double edge_face_cosine = 0.7;
    /// Parts of a sole no further apart than this are one [voxels]. 0..8. Ours: a lug's gap or an
    /// empty voxel does not part them. Larger: two tracks become one sole.
    int sole_gap_voxels = 2;
    /// @}

    /// @name What soil remembers
    /// Lengths between the centres of voxels [voxels]. All are ours. Across, a voxel's neighbour is
    /// one voxel away and its own column none: any length between the two tells them apart. Along
    /// the soil's path a step moves it by a voxel, and rounding adds the rest.
    /// @{
    /// Two voxels are the same soil if they are closer than this across the direction in which the
    /// soil moved. 0.1..4. Ours, as said above. Larger: soil beside a contact passes for sheared;
    /// smaller: it forgets.
    double same_across_voxels = 0.6;
    /// Two voxels are the same soil if they are closer than this along that direction. 0.1..4.
    /// Ours, as said above. Larger and smaller: likewise.
    double same_along_voxels = 1.75;
    /// Soil further off than this is not looked at. 0.1..4. Ours: longer than same_along_voxels by
    /// the rounding of a voxel's place. Larger: the search takes longer.
    double memory_reach_voxels = 2;
    /// Another body's face is the same contact where its normal is no further off than this cosine.
    /// 0..1. Ours: 60 deg, where faces of a box are 90 deg apart. Larger: links of a track start
    /// anew.
    double same_contact_cosine = 0.5;
    /// The soil under a face that looks down by this cosine at least goes down with it; that of any
    /// other face is pushed on along the normal. 0..1. Ours: as for Bekker's pressure. Larger: a
    /// wheel's steep front takes its soil along.
    double looks_down_cosine = kUprightCosine;
    /// @}

    /// Names the field, its value and its range when something is wrong. material_count: of the
    /// soil.
    Status validate(int material_count) const;
    bool operator==(const ContactLawDef&) const = default;  ///< number by number
};

// clang-format off
/// The constants of a ContactLawDef: FIELD(name, least, most, what it is, what else to know or "").
/// The name's ending is the unit; the default is the member's. One row makes a field of validate(), of
/// snapshots, of bulletsoil_contact_constants in C, of [soil.contact_constants] in scenes (what is on
/// or off: of [soil]) and of their page.
#define BSOIL_CONTACT_LAW_FIELDS(FIELD)                                                            \
    FIELD(passive_wedge, 0, 1,                                                                     \
          "a wall meets no more than its passive wedge",                                           \
          "that of a log spiral; where this is off, the granular law has Coulomb's wedge "         \
          "and the plain law none")                                                                \
    FIELD(trapped_soil, 0, 1,                                                                      \
          "soil between the teeth of a row (lugs, grousers) goes with them",                       \
          "as far as the passive wedge before each reaches; with faces by shape")                  \
    FIELD(creep, 0.001, 0.2,                                                                       \
          "an element that moves less than this share of its body's motion counts as "             \
          "resting",                                                                               \
          "")                                                                                      \
    FIELD(unloading_stiffness, 1, 1000,                                                            \
          "how many times as stiffly soil unloads as it was loaded", "")                            \
    FIELD(slip_band_slope, 0.001, 1,                                                               \
          "the most that a face goes into the soil while it slips along it, as a share of "        \
          "its slip",                                                                              \
          "")                                                                                      \
    FIELD(open_gap_voxels, 0.01, 2,                                                                \
          "gap across which soil that the grid holds in the next voxel loses touch", "")           \
    FIELD(dense_shear_share, 0.01, 1, "K of compacted soil over that of loose soil", "")           \
    FIELD(mobilization_widths, 0.01, 1,                                                            \
          "sinkage over which a sole's bearing develops in loose soil, in widths", "")      \
    FIELD(mobilization_fall_widths, 0, 0.99,                                                       \
          "how much less it is in compacted soil, in widths",                                        \
          "less than 0.99 of that in loose soil")                                                  \
    FIELD(wedge_length, 0, 5,                                                                      \
          "length of the wedge before a wall over its depth",                                      \
          "0: Rankine's tan(45 deg + phi / 2) with each material's own phi, else at least "        \
          "0.5")                                                                                   \
    FIELD(sole_surroundings_widths, 0.5, 5,                                                        \
          "how many widths around a sole's middle soil counts", "")                                 \
    FIELD(hollow_share, 0, 1,                                                                      \
          "share of the hollow under a sole that counts with the rim around it", "")               \
    FIELD(faces_by_shape, 0, 1,                                                                    \
          "area, place and direction of an element come from the body's shapes",                   \
          "else from the coverage field")                                                          \
    FIELD(under_way_share, 0, 0.5,                                                                 \
          "excess below this share of a voxel is in transit and is no compression", "")            \
    FIELD(edge_sine, 0.1, 0.9,                                                                     \
          "sine of the angle from which a gradient beside a face is of an edge", "")               \
    FIELD(edge_face_cosine, 0, 1,                                                                  \
          "faces round an edge whose normals are further apart than this cosine are "              \
          "different ones",                                                                        \
          "")                                                                                      \
    FIELD(sole_gap_voxels, 0, 8, "parts of a sole no further apart than this are one", "")         \
    FIELD(same_across_voxels, 0.1, 4,                                                              \
          "two voxels are the same soil if they are closer than this across the direction "        \
          "in which the soil moved",                                                               \
          "")                                                                                      \
    FIELD(same_along_voxels, 0.1, 4,                                                               \
          "two voxels are the same soil if they are closer than this along that direction", "")    \
    FIELD(memory_reach_voxels, 0.1, 4, "soil further off than this is not looked at", "")          \
    FIELD(same_contact_cosine, 0, 1,                                                               \
          "another body's face is the same contact where its normal is no further off than "       \
          "this cosine",                                                                           \
          "")                                                                                      \
    FIELD(looks_down_cosine, 0, 1,                                                                 \
          "the soil under a face that looks down by this cosine at least goes down with it", "")
// clang-format on

}  // namespace bsoil
#pragma GCC visibility pop
