/// The projectile motion (19) of the thesis: support, advection (21) to (28) with gravity (29),
/// overflow resolution (section 3.2.1, Fig. 30).
///
/// Deviations from the thesis:
/// - resting soil (all below it full, down to the floor, terrain or a body) does not move, and its
/// momentum is zero;
/// - soil that rests on a moving body takes over the body's velocity as far as Coulomb friction
/// allows, and as no wall of something else holds it back (held_load.h);
/// - only resting soil and voxels at least half covered lock a voxel: falling soil never does, and
/// soil caught in a wall moves on within it, but never further in (walls.h);
/// - backflow from a wall that recedes keeps what it has of the wall's velocity;
/// - carried soil goes before the wall behind it, and follows the wall before it into the voxel
/// that its face crosses, as far as there is room;
/// - soil that moves loses its bond;
/// - drift over a step is v + g dt / 2, exact for constant gravity, and the velocity after it v + g
/// dt;
/// - soil that falls between soil at rest goes no faster than from an arch (arches.h);
/// - soil whose materials fall in air is slowed down and carried by it (wind.h);
/// - shares below a speck stay where they are;
/// - crumbs go by whole voxels, by chance. So does soil that falls where all its shares are specks,
/// or of thin soil specks and barred;
/// - overflow that a body's push is moving is left to the next step's force propagation, up to an
/// amount;
/// - excess that stays by field.h is not overflow; what is caught in a wall is spread evenly, on
/// its own side.
#pragma once

#include <span>

#include "oracle/field.h"

namespace oracle {

/// What every voxel's soil rests on.
/// strength: of the cohesion of roofs (see roofs.h).
Field find_support(const Model& model, const Field& before, std::span<const Body> bodies,
                   double strength = 1);

/// (21) to (29) over one of model.substeps parts of a step, from the supports in `before`.
Field advect(const Model& model, const Field& before, std::span<const Body> bodies);

enum class Heuristic { even, up, up_spread };
/// One overflow pass.
Field resolve_overflow(const Model& model, const Field& before, std::span<const Body> bodies,
                       Heuristic heuristic);

}  // namespace oracle
