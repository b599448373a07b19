// The soil in a region of the world: weighing it, taking it out.
#include <algorithm>
#include <cmath>

#include "soil/shape_bounds.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

/// The voxels of a grid whose centres are in a convex region of the world.
class Region {
  public:
    Region(const ConvexShape& shape, const Pose& pose, const Pose& world_to_grid,
           const GridFrame& frame)
        : shape_(shape), voxel_m_(frame.voxel_m) {
        grid_to_region_ = inverse(world_to_grid * pose * shape.local);
        const Aabb box = shape_bounds(shape, world_to_grid * pose, frame.voxel_m);
        const double lows[3] = {box.min.x, box.min.y, box.min.z},
                     highs[3] = {box.max.x, box.max.y, box.max.z};
        for (int axis = 0; axis < 3; ++axis) {
            low_[axis] =
                static_cast<int>(std::clamp(std::floor(lows[axis]), 0.0, frame.size[axis] - 1.0));
            high_[axis] =
                static_cast<int>(std::clamp(std::floor(highs[axis]), 0.0, frame.size[axis] - 1.0));
        }
    }

    /// Calls visit(tx, ty) for each tile that its box touches.
    template <typename Visit>
    void for_each_tile(Visit visit) const {
        for (int ty = low_[1] / kTileSide; ty <= high_[1] / kTileSide; ++ty)
            for (int tx = low_[0] / kTileSide; tx <= high_[0] / kTileSide; ++tx) visit(tx, ty);
    }
    /// Calls visit(z, column) for each voxel of a tile that is inside and holds soil.
    template <typename Visit>
    void for_each_voxel(int tx, int ty, const TileVoxels& voxels, Visit visit) const {
        for (int z = low_[2]; z <= high_[2]; ++z) {
            for (int c = 0; c < kTileColumns; ++c) {
                if (voxels.at(kKeptVolume, z, c) == 0) continue;
                const Vec3 center{tx * kTileSide + c % kTileSide + 0.5,
                                  ty * kTileSide + c / kTileSide + 0.5, z + 0.5};
                if (contains(shape_, transform(grid_to_region_, center * voxel_m_))) visit(z, c);
            }
        }
    }

  private:
    const ConvexShape& shape_;
    double voxel_m_;
    Pose grid_to_region_;  ///< of metres
    int low_[3], high_[3];
};

}  // namespace

double Soil::mass_inside_kg(const ConvexShape& shape, const Pose& pose) const {
    const Impl& s = *impl_;
    if (!is_valid_shape(shape) || !is_finite(pose)) {
        return 0;
    }
    const Region region(shape, pose, s.world_to_grid, s.frame);
    int64_t units = 0;
    TileVoxels voxels;
    region.for_each_tile([&](int tx, int ty) {
        if (!s.tiles[s.tile_index(tx, ty)]) {
            return;
        }
        s.read_voxels(s.tile_index(tx, ty), voxels);
        region.for_each_voxel(tx, ty, voxels, [&](int z, int c) {
            for (int m = 0; m < s.params.material_count; ++m) {
                units += voxels.at(kKeptMaterial + m, z, c);
            }
        });
    });
    return static_cast<double>(units) * s.kg_per_unit;
}

Result<std::vector<int64_t>> Soil::take_out(const ConvexShape& shape, const Pose& pose) {
    Impl& s = *impl_;
    if (!is_valid_shape(shape)) {
        return Error{"take_out: the region's sizes must be finite and above zero"};
    }
    if (!is_finite(pose)) {
        return Error{"take_out: the region's pose has a NaN or infinite number"};
    }
    const Region region(shape, pose, s.world_to_grid, s.frame);
    std::vector<int64_t> units(s.materials.size());
    TileVoxels voxels;
    region.for_each_tile([&](int tx, int ty) {
        const int index = s.tile_index(tx, ty);
        if (!s.tiles[index]) {
            return;
        }
        s.read_voxels(index, voxels);
        bool changed = false;
        region.for_each_voxel(tx, ty, voxels, [&](int z, int c) {
            for (int m = 0; m < s.params.material_count; ++m) {
                units[m] += voxels.at(kKeptMaterial + m, z, c);
            }
            for (int plane = kKeptVolume; plane < s.kept_planes; ++plane) {
                voxels.at(plane, z, c) = 0;
            }
            changed = true;
        });
        if (!changed) {
            return;
        }
        s.write_voxels(index, voxels);
        Tile& tile = *s.tiles[index];
        ++tile.revision;
        tile.unchecked = s.any_unchecked = true;  // soil may have lost what it rested on
    });
    return units;
}

}  // namespace bsoil
