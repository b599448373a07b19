/// ContactMotion: the motion of a body against its soil, and the motion that the law is asked
/// about.
#pragma once

#include <span>

#include "bsoil/body.h"
#include "bsoil/work_threads.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// How a body moves. World axes.
struct BodyMotion {
    Pose pose;
    Vec3 center_of_mass_m;
    Vec3 linear_velocity_m_s;  ///< of the centre of mass
    Vec3 angular_velocity_rad_s;
    /// Of a point that moves with it [m/s].
    Vec3 velocity_at(Vec3 point_m) const {
        return linear_velocity_m_s + cross(angular_velocity_rad_s, point_m - center_of_mass_m);
    }
};

/// The constants of the motion that the law is asked about, each with its unit, where its value is
/// from and what another one would do.
struct ContactMotionDef {
    /// Time over which the motion of a body is averaged [s] where a solver finds it. Ours: six
    /// substeps of 1/60 s. Shorter, and a parked machine's jitter picks the direction of yield;
    /// longer, and a wheel that starts to slip meets the resistance of rolling.
    double yield_memory_s = 0.1;
    /// A body much slower than this rests [voxels a second]. Ours: in a step of 1/60 s that is a
    /// hundredth of a voxel, which the grid cannot tell from rest. Lower, and a parked machine's
    /// jitter picks the direction of yield; higher, and a slowly dragged body meets no direction.
    double rest_voxels_per_s = 0.5;
    /// The same of a driven body [m/s], whose speed has no jitter. Ours: for the rounding.
    /// Larger, and a slowly driven tool meets no direction.
    double driven_rest_m_s = 1e-6;
};
inline constexpr ContactMotionDef kContactMotion;

/// Who finds a body's motion, and how far its speed can be trusted.
struct MotionSource {
    bool is_solved = true;  ///< a solver, with jitter; else the body is driven
    /// Averaged over ContactMotionDef::yield_memory_s. Not of a body that is new, or has fallen
    /// asleep: an average that still changed would change its limits.
    bool is_averaged = true;
    double voxel_m = 0.05;
    /// Below it a body rests [m/s].
    double rest_m_s() const {
        return is_solved ? kContactMotion.rest_voxels_per_s * voxel_m
                         : kContactMotion.driven_rest_m_s;
    }
};

/// A motion as yield sees it (ElementMotion::share): linear and angular velocity as a share of the
/// speed of a contact `extent_m` off the centre of mass, so that the law's answer does not depend
/// on speed. Zero at rest.
BodyMotion as_share(const BodyMotion& motion, double extent_m, const MotionSource& source);

/// A body's motion relative to what carries the soil that it touches. Points of both move alike, so
/// the difference is that of a rigid body too.
struct ContactMotion {
    int carrier = -1;      ///< ContactVoxel::carrier
    BodyMotion motion;     ///< as it is now
    BodyMotion direction;  ///< as yield sees it, of contact points as a share of the body's motion
                           ///< (see ElementMotion)
    Vec3 linear_m_s, angular_rad_s;  ///< averaged: what direction is made of

    /// Moves on by `duration_s` to the body's motion as it is now. under: the motion of the
    /// carrier, or null for the ground. voxels: of the body; those of this carrier say how far it
    /// reaches. threads: to share the work, or null.
    void advance(const BodyMotion& body, const BodyMotion* under,
                 std::span<const ContactVoxel> voxels, double duration_s,
                 const MotionSource& source, const WorkThreads* threads = nullptr);
};
/// The one of a voxel's or a patch's carrier; the first where there is none of its own.
inline const ContactMotion& motion_for(std::span<const ContactMotion> motions, int carrier) {
    for (const ContactMotion& m : motions) {
        if (m.carrier == carrier) return m;
    }
    return motions.front();
}

}  // namespace bsoil
#pragma GCC visibility pop
