/// Soil on a body that slides along under it, written from docs/decisions/silo_walls.md. Not in the
/// thesis.
///
/// - From a carried voxel a row goes on along x or y over voxels without room for pushed soil that
/// hold soil carried by any body, up to model.held_reach voxels. It ends at a wall or is open;
/// - where it is open the row of the voxel below counts, as long as that is carried by the same
/// body;
/// - at a wall of another body, at terrain and at the grid's end soil is no faster along the row
/// than the wall goes away; at a wall of its own body it is free;
/// - speeds up to model.still_speed are left alone.
#pragma once

#include <optional>
#include <span>

#include "oracle/field.h"

namespace oracle {

/// A voxel, and the way from it along x or y.
struct RowStart {
    int x = 0, y = 0, z = 0, dx = 0, dy = 0;
};

/// The body of the wall at which a row ends, -1: terrain or the grid's end; nothing where it is
/// open.
std::optional<int> wall_of_row(const Model& model, const Field& field, const RowStart& row);

/// What is left of a velocity at which the body would carry a voxel's soil [voxels a step].
Vec3 held_back(const Model& model, const Field& field, std::span<const Body> bodies, int x, int y,
               int z, Vec3 velocity);

}  // namespace oracle
