/// CouplingDef: the constants by which the soil's contact goes to Bullet's solver.
#pragma once

namespace bsoil::bullet {

/// Each with its unit, where its value is from and what another one would do. All are ours: they
/// stand between a law of stresses and a solver of rows.
struct CouplingDef {
    // --- the motion that the law is asked about
    /// Time over which a body's motion is averaged [s]. Ours: six substeps of 1/60 s. Shorter, and
    /// a parked machine's jitter picks the direction of yield; longer, and a wheel that starts to
    /// slip meets the resistance of rolling.
    double yield_memory_s = 0.1;
    /// A body much slower than this rests [voxels a second]. Ours. Lower, and a parked machine's
    /// jitter picks the direction of yield.
    double rest_voxels_per_s = 0.5;
    /// The same of a driven body [m/s], whose speed has no jitter. Ours: for the rounding.
    double driven_rest_m_s = 1e-6;
    /// Soil steps over which the limits of a sleeping body are averaged before they are compared.
    /// Ours: the soil beside it settles for some steps more, and a voxel of it caught between
    /// bodies may go to and fro for good, which would wake it.
    int wake_steps = 16;
    /// Patches whose normals are further apart than this cosine are not the same contact, and take
    /// over no preload. Ours: 60 deg, where faces of a box are 90 deg apart.
    double same_patch_cosine = 0.5;

    // --- a patch's rows
    /// A tangential force below this share of the normal limit gives the tangential rows no
    /// direction. Ours: for the rounding.
    double no_direction_share = 1e-6;
    /// A row that gives this share of its limit has yielded. Ours: the solver clamps in single
    /// precision, so that none gives exactly its limit.
    double yielded_share = 0.999;
    /// A patch slides when its speed exceeds this share of the body's. Ours.
    double sliding_share = 0.01;
    /// And when it gives this share of its friction against the direction of sliding. Ours.
    double mostly_yielded_share = 0.95;
    /// Share of its limit that a sliding patch may give across that direction, at least. Ours: a
    /// body pushed aside turns that fast.
    double across_share = 0.1;
    /// More drift than this [m] is not the solver's remainder but the contact's own motion. Ours.
    double drift_most_m = 0.01;
    /// Share of the last substep's force that is given as a preload. Ours: the whole of it rings
    /// after an impact.
    double preload_share = 0.85;
};

inline constexpr CouplingDef kCoupling;

}  // namespace bsoil::bullet
