/// Roofs of soil that was never moved, written from docs/decisions/banks.md. Not in the thesis.
///
/// - Most of a roof's voxel was never moved, and it is full. Along x, y or a diagonal it lies
///   between two abutments, voxels like it that are full down to the floor or to terrain, or
///   terrain itself, up to model.roof_reach voxels away, with voxels like it in between;
/// - it is held where the span is no more than 2 c / gamma, the mean over the voxels between the
///   abutments, of each by the share that was never moved, times the share of all soil from the
///   voxel up to the next hollow that was never moved.
#pragma once

#include "oracle/field.h"

namespace oracle {

/// strength: cohesion counts so many times.
bool is_held_roof(const Model& model, const Field& field, int x, int y, int z, double strength);

}  // namespace oracle
