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
    /// A body much slower than this rests [voxels a second]. Ours: in a step of 1/60 s that is a
    /// hundredth of a voxel, which the grid cannot tell from rest. Lower, and a parked machine's
    /// jitter picks the direction of yield; higher, and a slowly dragged body meets no direction.
    double rest_voxels_per_s = 0.5;
    /// The same of a driven body [m/s], whose speed has no jitter. Ours: for the rounding.
    /// Larger, and a slowly driven tool meets no direction.
    double driven_rest_m_s = 1e-6;
    /// Soil steps over which the limits of a sleeping body are averaged before they are compared.
    /// Ours: the soil beside it settles for some steps more, and a voxel of it caught between
    /// bodies may go to and fro for good, which would wake it. Lower: what settles beside a body
    /// wakes it; higher: it hangs longer over soil that is taken away.
    int wake_steps = 16;
    /// Patches whose normals are further apart than this cosine are not the same contact, and take
    /// over no preload. Ours: 60 deg, where faces of a box are 90 deg apart. Larger, and
    /// a rolling wheel starts every patch from nothing; smaller, and a face passes its force on to
    /// the one round the edge.
    double same_patch_cosine = 0.5;

    // --- a patch's rows
    /// A tangential force below this share of the normal limit gives the tangential rows no
    /// direction. Ours: for the rounding. Larger, and a body that slides slowly has its rows
    /// anyhow.
    double no_direction_share = 1e-6;
    /// A row that gives this share of its limit has yielded. Ours: the solver clamps in single
    /// precision, so that none gives exactly its limit. Lower, and rows that still hold count as
    /// yielded.
    double yielded_share = 0.999;
    /// A patch slides when its speed exceeds this share of the body's. Ours: ContactLawDef::creep's
    /// default, below which the law takes an element for resting. Higher, and a wheel that slips a
    /// little keeps rows across its sliding.
    double sliding_share = 0.01;
    /// And when it gives this share of its friction against the direction of sliding. Ours: less
    /// than all, so that the solver's remainder does not turn a row to and fro; 0.95 is a turn of
    /// 18 deg off the sliding. Lower, and resting patches get turned rows.
    double mostly_yielded_share = 0.95;
    /// Share of its limit that a sliding patch may give across that direction, at least. Ours: with
    /// none a body that slides straight on could be pushed aside by nothing; with more it would
    /// have both the friction along and that across. Higher, and sliding bodies keep their line.
    double across_share = 0.1;
    /// More drift than this [m] is not the solver's remainder but the contact's own motion. Ours: a
    /// fifth of a voxel of 5 cm, which the grid cannot tell from none. Higher, and a
    /// body that soil has let go is pulled back; lower, and parked machines creep.
    double drift_most_m = 0.01;
    /// Share of the last substep's force that is given as a preload. Ours: the whole of it rings
    /// after an impact. Lower, and with few iterations of the solver bodies sink in further.
    double preload_share = 0.85;

    // --- raycast wheels
    /// A wheel that the soil has carried wakes its chassis when the soil bears less than this share
    /// of what it bore. Ours: less than all, since soil that settles beside a wheel changes its
    /// limits. Higher, and sleeping vehicles wake for nothing; lower, and one hangs over soil dug
    /// away.
    double wheel_wake_share = 0.9;
    /// A strut this near to its full length [m] is at its end. Ours: above the rounding of single
    /// precision, below any travel of a strut. Larger, and a wheel in the air counts as loaded.
    double strut_end_m = 1e-4;
    /// Sinkage [voxels] that doubles the limits of a wheel's contact within a substep. Ours: the
    /// limits are those of the soil's last step, and without a slope a wheel between two of them
    /// falls or stands. Larger, and a wheel whose limits have just fallen below its load drops past
    /// the depth that carries it; smaller, and it sinks more slowly than the soil would let it.
    double wheel_stiffening_voxels = 0.05;
    /// Slower than this [m/s], slip is the difference of speeds over it and no ratio. Ours: a ratio
    /// of two remainders says nothing. No force depends on it. Larger, and slow wheels report less
    /// slip.
    double slip_speed_m_s = 0.1;

    // --- first contact, solved within a substep
    /// A body that moves less than this between two steps of the soil has stopped [voxels]. Ours:
    /// the grid cannot tell it from one at rest. Larger, and the soil's contacts take over a body
    /// that still falls; smaller, and an impact lasts until impact_most_s.
    double stopped_voxels = 0.01;
    /// An impact is over after this [s], stopped or not. Ours: 15 substeps of 1/60 s; what is still
    /// on its way then sinks and is no impact. Longer, and what others push down is held by what
    /// its underside met alone; shorter, and a deep impact is cut off.
    double impact_most_s = 0.25;

    // --- the soil below a body
    /// A voxel with this share of soil or rock in it is below the surface. Ours: half, where the
    /// error of either answer is the same. Larger, and a loose crust is looked through.
    double mostly_full_share = 0.5;
    /// The topmost surface of a column is the one below a body unless it is this far [voxels] from
    /// what the column holds there. Ours: a surface's heights and a column's voxels differ by one
    /// voxel at most, so more means a roof or a gap between them. Larger, and a body under a roof
    /// lands on the roof's height.
    double same_surface_voxels = 1.5;
};

inline constexpr CouplingDef kCoupling;

}  // namespace bsoil::bullet
