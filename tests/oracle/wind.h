/// The air that soil falls through: wind, gusts and shelter. Not in the thesis.
///
/// - Linear drag: in a step air takes model.air of the speed against it, by the implicit midpoint
/// rule, so that soil at its fall speed keeps it. All of it, where that would take more.
/// - No wind where a line that rises by 15 deg against it meets something solid or a voxel full of
/// soil within model.shelter columns (Werner 1995, of dunes).
/// - Gusts are value noise on a lattice of model.gust_cell voxels.
#pragma once

#include "oracle/field.h"

namespace oracle {

/// Of the air in a voxel [voxels a step].
Vec3 air_velocity(const Model& model, const Field& field, int x, int y, int z);

/// Velocity after a part `dt` of a step of soil that falls with `velocity`, of which air takes
/// `rate` in a step.
Vec3 fall_in_air(const Model& model, Vec3 velocity, Vec3 air, double rate, double dt);

}  // namespace oracle
