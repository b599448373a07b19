/// How much of each voxel a solid at rest covers, reckoned on the host: for ground bodies, whose
/// tiles may be asleep.
#pragma once

#include <cstdint>
#include <span>

#include "bsoil/body.h"

namespace bsoil {

/// Voxels of a tile: x0..x0 + 7, y0..y0 + 7, 0..height - 1 of the grid; index z * 64 + y * 8 + x.
struct TilePlace {
    int x0 = 0, y0 = 0, height = 0;
};

/// Adds to `units` what the shape covers of each voxel of the tile [volume units, sum over shapes],
/// by the rule of shaders/voxelize_shapes.glsl. to_grid: shape's body -> grid, metres. Cost: some
/// thousand distances where the surface crosses the tile, a few where it does not.
void add_coverage(const ConvexShape& shape, const Pose& body_to_grid, double voxel_m,
                  const TilePlace& tile, std::span<int32_t> units);

}  // namespace bsoil
