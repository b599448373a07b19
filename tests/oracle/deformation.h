/// The deformation (18) of the thesis, section 3.2.4: force application (33) and force propagation
/// (34), (35).
///
/// Deviations from the thesis:
/// - the excess that a body may press in elastically stays, and so does excess not worth a pass
/// (field.h);
/// - voxels at least half covered are closed to inflow, except from within walls, whose soil leaves
/// on the side it came from, all of it where a wall has run over it (walls.h); a push that does not
/// lead out within 60 degrees takes the way out instead, and so does what it could not move; what
/// is barred then too stays where it is;
/// - a surface that recedes pushes out of the body, not after it;
/// - a body that presses down into a full bed pushes outwards from its middle, rising at 45 deg -
/// phi / 2;
/// - a push barred by soil turns towards the free surface by the shorter way: level, or rising at
/// 45 deg - phi / 2
///   (Rankine's passive wedge), looked for over 8 voxels; what a body bars above then goes level;
/// - soil that goes with the body it rests on is not pushed by it for what it makes room for by
/// itself (walls.h);
/// - a force is kept as a weighted sum, so only its direction is compared;
/// - where density is state, excess pressed into a voxel by a body compacts the soil before it
/// flows, to the relative density that the body packs it to; half of that in the voxel that a
/// body's own pushes into.
#pragma once

#include <span>

#include "oracle/field.h"

namespace oracle {

/// (33). The result's forces are scaled so that the largest component is 1, as (34) needs them.
Field apply_force(const Model& model, const Field& before, std::span<const Body> bodies);

/// One iteration of (34) and (35).
Field propagate_force(const Model& model, const Field& before, std::span<const Body> bodies);

}  // namespace oracle
