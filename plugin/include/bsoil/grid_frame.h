/// GridFrame: where a soil's grid lies in the world.
#pragma once

#include "bsoil/geometry.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Grid geometry. Grid axes: x and y horizontal, z up, voxel units, origin at the grid's lower
/// corner.
struct GridFrame {
    int size[3] = {0, 0, 0};  ///< voxels along grid x, y, z
    double voxel_m = 0;
    Pose grid_to_world;  ///< of metres in grid axes
    /// From grid axes and voxels to world axes and metres.
    Vec3 to_world(Vec3 grid_voxels) const;
    /// From world axes and metres to grid axes and voxels.
    Vec3 to_grid(Vec3 world_m) const;
    /// Whether a point of the world is above the grid's floor and between its sides.
    bool is_above(Vec3 world_m) const;
};

}  // namespace bsoil
#pragma GCC visibility pop
