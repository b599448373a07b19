#include "bsoil/grid_frame.h"

namespace bsoil {

Vec3 GridFrame::to_world(Vec3 grid_voxels) const {
    return transform(grid_to_world, grid_voxels * voxel_m);
}
Vec3 GridFrame::to_grid(Vec3 world) const {
    return transform(inverse(grid_to_world), world) * (1 / voxel_m);
}

bool GridFrame::is_above(Vec3 world) const {
    const Vec3 at = to_grid(world);
    return at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x <= size[0] && at.y <= size[1];
}

}  // namespace bsoil
