/// Soil that falls between soil at rest, written from docs/decisions/hoppers.md. Not in the thesis.
///
/// - Soil falls in an arch where soil at rest stands on both sides along x or along y, at the same
/// height, with voxels of at least model.arch_least soil up to there and model.arch_reach voxels
/// away at most;
/// - it falls no faster than sqrt(2 g d), d being the harmonic mean of the ways from its voxel's
/// middle to the two sides; of x and y that which is less.
#pragma once

#include "oracle/field.h"
#include "oracle/spans.h"

namespace oracle {

/// How fast the soil of a voxel may fall [voxels a step]; infinite outside of arches.
double arch_speed(const Model& model, const Field& field, int x, int y, int z);

/// Whether the soil of a falling span is in an arch somewhere.
bool is_arched(const Model& model, const Field& field, int x, int y, const Span& span);

}  // namespace oracle
