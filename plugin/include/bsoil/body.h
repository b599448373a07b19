/// Bodies as the soil sees them: solids in motion.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "bsoil/geometry.h"

#pragma GCC visibility push(default)  // a class is what its first declaration makes it
namespace bsoil {
class DistanceLattice;
}
#pragma GCC visibility pop

namespace bsoil {

/// A solid in its body's frame: a convex one, or a lattice, which may have any form. The shape's
/// own axis is its local z.
struct ConvexShape {
    /// Its form.
    enum class Kind { box, sphere, capsule, cylinder, cone, hull, lattice };
    Kind kind = Kind::box;
    Pose local;           ///< shape frame -> body frame
    Vec3 half_extents_m;  ///< box
    double radius_m = 0;  ///< sphere, capsule, cylinder, cone (of its base)
    double half_height_m =
        0;  ///< capsule: half the segment; cylinder, cone: half the length. Cone: apex at +z
    std::vector<Plane> planes;  ///< hull: 4..256 half spaces with unit normals, in the shape frame
    double bound_m = 0;         ///< hull: largest distance of its points from the shape's origin
    double rounding_m = 0;      ///< added all around (a collision margin outside the core shape)
    /// lattice: the solid; its LatticeDef::voxel_m should be the soil's. See
    /// bsoil/distance_lattice.h.
    std::shared_ptr<const DistanceLattice> lattice;
};

/// What a body's surface is to the soil; negative: as the material says.
struct SurfaceFriction {
    double friction = -1;     ///< Coulomb's coefficient, 0..2
    double adhesion_pa = -1;  ///< shear stress without pressure, 0..200e3 Pa
    /// All fields are equal.
    bool operator==(const SurfaceFriction&) const = default;
};

/// One body for one step. World axes.
struct SoilBody {
    int id = 0;  ///< the caller's own key, 0..65534, unique in a step; comes back in contacts
    Pose pose;   ///< body frame -> world, at the end of the step
    Vec3 linear_velocity_m_s;  ///< of center_of_mass_m
    Vec3 angular_velocity_rad_s;
    Vec3 center_of_mass_m;  ///< world
    /// Mean normal pressure and width of its contact with the soil so far. Negative: what the soil
    /// knows of it (KnownContacts), which is right for a body whose forces somebody finds. A value
    /// of 0 or more counts instead, for this step: for a body pressed by what the soil cannot know.
    /// The pressure decides how far soil that the body presses on is compacted; soil counts for
    /// ContactVoxel::relative_density to half as far from the body as the contact is wide (1..8
    /// voxels).
    double contact_pressure_pa = -1;
    double contact_width_m = -1;
    /// Never moves: velocity ignored. At rest it is a *ground body*: the soil treats it as terrain,
    /// wakes no tile for it, and gives it no contacts. Soil that lies where it is put is buried: it
    /// is counted by Soil::totals() and comes back when the body goes. If its pose changes after
    /// all, it pushes soil like a body without velocity until it has stood still for 30 steps; a
    /// jump of more than SoilDef::substeps_max voxels puts it down anew.
    bool is_static = false;
    /// Its motion is given and not solved for: even the slowest is meant. Else it rests below
    /// ContactMotionDef::rest_voxels_per_s where the walls of loads are looked at.
    bool is_driven = false;
    bool may_leave = false;  ///< that it is out of the grid is not reported: another soil has it
    SurfaceFriction surface;
    const std::vector<ConvexShape>* shapes = nullptr;  ///< must outlive the call
    unsigned shape_revision = 0;                       ///< change it when *shapes changed
};

/// What of a row of teeth an element is: what they stand on, a face of a tooth towards the next, or
/// the surface over the tips, which is there as far as soil between the teeth goes with them.
enum class ToothPart : uint8_t { base, tooth, over_tips };

/// The row of teeth (a wheel's lugs, a track's grousers) that an element of a surface belongs to.
struct ToothRow {
    double height_m = 0, thickness_m = 0, pitch_m = 0;  ///< pitch: 0 where there is no row
    double above_m = 0;  ///< how far the element is above what the teeth stand on
    Vec3 outward;        ///< unit, from there to the tips; world axes
    ToothPart part = ToothPart::base;
};

/// A voxel in which a body's surface and soil meet, at the end of a step. World axes, SI.
struct ContactVoxel {
    int body = 0;        ///< SoilBody::id
    int carrier = -1;    ///< SoilBody::id of the body that its soil rests on; -1: the ground
    Vec3 center_m;       ///< the voxel's centre: tells voxels apart from step to step
    Vec3 position_m;     ///< a point on the surface within the voxel
    Vec3 normal;         ///< unit, out of the body (into the soil): of the shape's face there
    double area_m2 = 0;  ///< of that face in this voxel, from the gradient of the coverage field
    /// Below the local free surface of the soil, of the same carrier's where one carries it; >= 0.
    double depth_m = 0;
    double gap_m = 0;     ///< to the soil beside the face, where that has drawn back; 0..2 voxels
    double touching = 1;  ///< share 0..1 of area_m2 that touches the soil: touching_share()
    /// Excess soil per area, less what is in transit through the voxel. It is how far the body has
    /// pushed the surface in elastically; >= 0.
    double compression_m = 0;
    /// The law computes the element's strength from this depth: depth_m, before a wall no more than
    /// its wedge over the ground as it lies has, and at least compression_m.
    double bearing_depth_m = 0;
    int material = 0;  ///< index into SoilDef::material_list()
    /// Of the soil beside the body that is mostly of that material, mean along the way out: 0
    /// loose, 1 compacted; negative where its density is fixed.
    double relative_density = -1;
    double saturation = 0;  ///< share of that soil's pores that water fills, 0..1
    /// Share of that soil that was never moved, mean along the way out, 0..1: it has its cohesion.
    double undisturbed = 1;
    /// Share of the soil before a moving element that it sets in motion anew, 0..1: all of level
    /// ground, little of a heap that goes along.
    double inflow_share = 1;
    /// Of an upright face before another body's load, which fills all up to a wall of this one: it
    /// goes where the walls go, and pushes them by friction alone, as part of its momentum.
    bool is_between_walls = false;
    /// No part of the body's surface: the side of the column of soil that lies on a level face,
    /// along its edge, where soil on the ground is beside. position_m: on the edge; normal: up;
    /// area_m2: length of the edge times a voxel. See load_side_yield().
    bool is_load_side = false;
    ToothRow teeth;  ///< with ContactLawDef::trapped_soil
};

/// The soil a moving body carries (in a bucket, on a bed): it moves with the body, so its weight is
/// the body's to bear. And what the body did to soil that moves: soil that falls on it, or that
/// it takes along by friction.
struct BodyLoad {
    int body = 0;        ///< SoilBody::id
    double mass_kg = 0;  ///< 0 for a body that carries none: it has been hit, or is a wall
    Vec3 center_m;       ///< centre of mass, world; the body's where it carries none
    /// Momentum that the body has given soil in the last step, world: what changed that soil's
    /// velocity. What holds it up against gravity, mass times gravity times step, comes besides.
    Vec3 impulse_n_s;
    /// Mass whose weight friction with walls takes off the body: of its load what walls that are
    /// not its own bear, less what it bears itself as a wall of other bodies' loads. Whole parts of
    /// mass units, so that the sum over bodies and static ground is 0. See
    /// docs/decisions/silo_walls.md.
    double held_kg = 0;
    /// The same times where that friction acts, world [kg m].
    Vec3 held_kg_m{};
};

}  // namespace bsoil
