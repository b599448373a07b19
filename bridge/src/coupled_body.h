/// CoupledBody: a body beside soil and its patches, from one soil step to the next.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "body_state.h"
#include "bsoil/bullet/soil_action_types.h"
#include "bsoil/contact/contact_memory.h"
#include "bsoil/contact/patch_heirs.h"
#include "left_pose.h"
#include "link_patch_constraint.h"
#include "rigid_patch_constraint.h"

namespace bsoil::bullet {

/// A patch of a body's contact, and what the solver did at it last. Its point follows the centre of
/// mass, its directions stay.
struct CoupledPatch : PlacedPatch {
    Vec3 shear_offset_m;  ///< offset_m of the point where the shear force acts
    Vec3 carrier_offset_m, carrier_shear_offset_m;  ///< of both, from the carrier's
    double friction_normal_n = 0;                   ///< normal force the friction is reckoned from
    Vec3 applied_force_n;                           ///< by the last solve
    Vec3 preload_n;  ///< of it, what was given as a force before the solve
    Vec3 drift_m;    ///< see PatchRow

    /// Of a force [N] on it, about the centre of mass.
    Vec3 torque_n_m(Vec3 force_n) const {
        const Vec3 normal_n = dot(force_n, patch.normal) * patch.normal;
        return cross(offset_m, normal_n) + cross(shear_offset_m, force_n - normal_n);
    }
    /// Of the force on the carrier, about its centre of mass.
    Vec3 carrier_torque_n_m(Vec3 force_n) const {
        const Vec3 normal_n = dot(force_n, patch.normal) * patch.normal;
        return -1.0 * (cross(carrier_offset_m, normal_n) +
                       cross(carrier_shear_offset_m, force_n - normal_n));
    }
    double shear_limit_n() const {
        return patch.shear_share * (patch.friction * friction_normal_n + patch.adhesion_n);
    }
};

/// What carries soil that a body touches: the ground, or another body.
struct Carrier {
    int id = -1;
    BodyState body;  ///< of the ground: fixed
    LeftPose left;   ///< of its object, if it has one
    Pose pose_at_open;
    bool is_touched = false;  ///< by other bodies, in this substep
    bool is_there = true;     ///< it has not left the world since the rows were put in
    /// With it or with the body a link.
    std::unique_ptr<LinkPatchConstraint> link_rows;

    bool is_rigid() const { return body.role == BodyRole::rigid; }
    bool is_link() const { return body.role == BodyRole::link; }
    bool feels() const { return is_rigid() || is_link(); }
    /// Of a point of it since the substep was opened.
    Vec3 motion_in(double substep_s, Vec3 offset_m) const;
};

/// Force on a body through the soil that it carries.
struct PressedBody {
    int id = -1;
    Vec3 force_n;
};

/// A body beside soil.
struct CoupledBody {
    BodyState body;
    std::vector<CoupledPatch> patches;        ///< none for a wheel
    std::vector<ContactPatch> wheel_patches;  ///< only for a wheel
    std::vector<PatchElement> elements;       ///< of its patches, by which their limits follow it
    std::vector<std::unique_ptr<RigidPatchConstraint>>
        rigid_rows;  ///< a pool; the first patches.size() in use
    /// By id, so the ground first; always there. And the body's motion relative to each.
    std::vector<Carrier> carriers;
    std::vector<ContactMotion> motions;
    bool is_touched = false;  ///< by other bodies, in this substep
    bool is_there = true;     ///< it has not left the world since the rows were put in
    Pose pose_at_open;        ///< at the start of the substep
    btTransform bullet_pose_at_open = btTransform::getIdentity();  ///< the same, to the bit
    LeftPose left;
    /// Its contacts as limits_n was found from them while it slept.
    std::optional<std::vector<ContactVoxel>> slept_voxels;
    std::vector<FaceExtent> slept_faces;  ///< of these voxels, in the last step
    int asleep_step_count = 0;            ///< soil steps since it fell asleep; 0: awake
    /// Normal limits by bin, now; not known of one that comes from a snapshot.
    std::array<double, kNormalBinCount> limits_n{};
    bool has_limits = false;
    /// Of its normal limits by bin: the mean while it slept, and what that was at first.
    std::array<double, kNormalBinCount> mean_limits_n{}, limits_at_sleep_n{};
    BodyReport report;
    std::vector<PressedBody> pressed;  ///< carriers, by the last solve
    ContactMemory memory;
    std::unique_ptr<const ContactLaw> law;  ///< against this body's surface
    SurfaceFriction law_surface;
    bool seen = false;
    /// As the soil's last contacts with it have seen it; none before the first.
    std::optional<BodyMotion> met_motion;

    Carrier& carrier_of(const CoupledPatch& p) {
        return *std::find_if(carriers.begin(), carriers.end(),
                             [&p](const Carrier& c) { return c.id == p.patch.carrier; });
    }
    const Carrier& carrier_of(const CoupledPatch& p) const {
        return const_cast<CoupledBody*>(this)->carrier_of(p);
    }
    /// Whether a patch's row is one of a LinkPatchConstraint.
    bool is_link_row(const CoupledPatch& p) const {
        return body.role == BodyRole::link || carrier_of(p).is_link();
    }
};

}  // namespace bsoil::bullet
