/// Loose soil as groups of grains.
#include <algorithm>
#include <cmath>

#include "bsoil/render/renderer.h"

namespace bsoil::render {
namespace {

/// Of a voxel's side. Grains of four groups then are a fifteenth of the voxel: what the eye takes
/// for a stream is mostly air.
constexpr float kGrainShare = 0.08f;
/// Cubes overlap by this much, so that nobody sees the grid.
constexpr float kCubeShare = 1.5f;
/// Rolling grains hop over a layer of this share of their cube, a third of a voxel. Half of it
/// stands out of the ground.
constexpr float kLayerShare = 0.25f;
/// Rolling grains are half as many as a full group has, and hide as much.
constexpr float kRollShare = 0.5f, kRollLarger = 1.41f;
/// Seeds of rolling groups are others than those of voxels.
constexpr uint32_t kRollSeeds = 0x80000000u;

GrainGroup rolling_group(const RollingSoil& soil) {
    GrainGroup group;
    group.center = soil.center_m;
    group.velocity_m_s = soil.velocity_m_s;
    group.side_m = kCubeShare * soil.side_m;
    group.grain_m = kRollLarger * kGrainShare * soil.side_m;
    group.share = kRollShare * soil.amount;
    group.color = soil.color;
    group.seed = kRollSeeds + soil.seed;
    group.normal = soil.normal;
    group.flatness = 1 - kLayerShare;
    return group;
}

}  // namespace

void append_grains(const SurfaceMesher& mesher, std::vector<GrainGroup>& grains) {
    for (int ty = 0; ty < mesher.tile_count_y(); ++ty) {
        for (int tx = 0; tx < mesher.tile_count_x(); ++tx) {
            for (const LooseVoxel& voxel : mesher.loose_soil(tx, ty)) {
                GrainGroup group;
                group.center = voxel.center_m;
                group.velocity_m_s = voxel.velocity_m_s;
                group.side_m = kCubeShare * voxel.side_m;
                group.grain_m = kGrainShare * voxel.side_m;
                group.color = voxel.color;
                float left = kVoxelGroups * voxel.volume;
                for (uint32_t i = 0; left > 0; ++i, left -= 1) {
                    group.share = std::min(1.0f, left);
                    group.seed = kVoxelGroups * voxel.seed + i;
                    grains.push_back(group);
                }
            }
            for (const RollingSoil& soil : mesher.rolling_soil(tx, ty)) {
                grains.push_back(rolling_group(soil));
            }
        }
    }
}

}  // namespace bsoil::render
