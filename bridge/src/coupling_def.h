/// CouplingDef: the constants by which the soil's contact goes to Bullet's solver.
#pragma once

namespace bsoil::bullet {

/// Each with its unit, where its value is from and what another one would do. All are ours: they
/// stand between a law of stresses and a solver of rows.
struct CouplingDef {
    // --- sleep
    /// Soil steps over which the limits of a sleeping body are averaged before they are compared.
    /// Ours: the soil beside it settles for some steps more, and a voxel of it caught between
    /// bodies may go to and fro for good, which would wake it. Lower: what settles beside a body
    /// wakes it; higher: it hangs longer over soil that is taken away.
    int wake_steps = 16;

    // --- loads
    /// Times its own mass, or its multibody's, 1..100. A body that carries more than that pays for
    /// what its load got besides (CarriedLoads) by that much less in each soil step. Ours: soil
    /// that is stopped by the ground below the body gets its share from the solver a step before it
    /// stops, and a body that paid at once flew off with it, ever faster as its load fell off.
    /// Larger, and light bodies under heavy soil are thrown: with 30 a capsule of 2 g under a
    /// stream of gravel turned at up to 717 rad/s, with 10 at 48, with 3 at 36 (seen before it was
    /// chosen). Smaller, and buckets and truck beds feel what falls into them late.
    double load_most = 10;

    // --- a patch's rows
    /// A tangential force below this share of the patch's force gives the tangential rows no
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
    /// Out of the soil the patch's rebound is less (ContactPatch::rebound_m).
    double drift_most_m = 0.01;
    /// Share of its drift that a patch works off in a substep. Ours. Larger overshoots where a
    /// light wheel carries a heavy machine; smaller lets the machine settle deeper before it
    /// stands.
    double drift_recovery_share = 0.1;
    /// Share of the last substep's force that is given as a preload. Ours: the whole of it rings
    /// after an impact. Lower, and with few iterations of the solver bodies sink in further.
    double preload_share = 0.85;

    // --- bodies that their host puts elsewhere
    /// A body that is this much further [voxels] than it can have got by its speed has been put
    /// there, and the patches that held it stay behind. Ours: the soil knows the place of a contact
    /// to a voxel. Larger: bodies that are lifted off the soil are still pushed by it; smaller: a
    /// host that corrects poses by a little loses the patches, and its bodies sink.
    double put_elsewhere_voxels = 1;

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
    /// A wheel's patches whose normal looks up by more than this cosine are left out. Ours: 10 deg;
    /// those of its sides look up a little, by their shear. Larger: soil over a wheel holds it
    /// down, and light cars shake; smaller: its sides are not pushed.
    double wheel_top_cosine = 0.17;
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
};

inline constexpr CouplingDef kCoupling;

}  // namespace bsoil::bullet
