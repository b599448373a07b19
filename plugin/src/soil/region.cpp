// The soil in a region of the world: weighing it, taking it out.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "soil/shape_bounds.h"
#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

/// Words of tiles that are kept from one weighing of a region to the next. Ours: 4 MB, a pit of
/// four by four metres in voxels of 5 cm. Larger: more memory stays with a soil; smaller: the
/// system makes the pages of it anew in each step.
constexpr size_t kRegionWordsKept = size_t{1} << 20;

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
        for (int ty = low_[1] / kTileSide; ty <= high_[1] / kTileSide; ++ty) {
            for (int tx = low_[0] / kTileSide; tx <= high_[0] / kTileSide; ++tx) visit(tx, ty);
        }
    }
    /// Calls visit(z, column) for each voxel of a tile that is inside and has_soil(z, column).
    template <typename HasSoil, typename Visit>
    void for_each_voxel(int tx, int ty, HasSoil has_soil, Visit visit) const {
        for (int z = low_[2]; z <= high_[2]; ++z) {
            for (int c = 0; c < kTileColumns; ++c) {
                if (has_soil(z, c) && is_inside(tx, ty, z, c)) visit(z, c);
            }
        }
    }
    /// How many voxels of a column's from z on are inside.
    int count_inside(int tx, int ty, int c, int z, int length) const {
        int count = 0;
        const int last = std::min(high_[2], z + length - 1);
        for (int at = std::max(low_[2], z); at <= last; ++at) count += is_inside(tx, ty, at, c);
        return count;
    }
    int lowest_layer() const { return low_[2]; }
    int layer_count() const { return high_[2] - low_[2] + 1; }

  private:
    bool is_inside(int tx, int ty, int z, int c) const {
        const Vec3 center{tx * kTileSide + c % kTileSide + 0.5,
                          ty * kTileSide + c / kTileSide + 0.5, z + 0.5};
        return contains(shape_, transform(grid_to_region_, center * voxel_m_));
    }

    const ConvexShape& shape_;
    double voxel_m_;
    Pose grid_to_region_;  ///< of metres
    int low_[3], high_[3];
};

/// Of each material, in a region of the world.
std::vector<int64_t> units_inside(const Soil::Impl& s, const ConvexShape& shape, const Pose& pose) {
    std::vector<int64_t> units(s.materials.size());
    if (!is_valid_shape(shape) || !is_rigid(pose)) return units;
    const Region region(shape, pose, s.world_to_grid, s.frame);
    const int material_count = s.params.material_count;
    TileRuns runs;
    struct AwakeTile {
        int tx, ty, slot;
    };
    std::vector<AwakeTile> awake;
    region.for_each_tile([&](int tx, int ty) {
        const Tile* tile = s.tiles[s.tile_index(tx, ty)].get();
        if (!tile) return;
        if (tile->slot >= 0) {
            awake.push_back({tx, ty, tile->slot});
            return;
        }
        if (tile->top <= region.lowest_layer()) return;
        if (!s.tiles.read_asleep(s.tile_index(tx, ty), runs)) return;
        runs.for_each([&](int c, int z, const ColumnRun& run) {
            if (run.values[kKeptVolume] == 0) return;
            const int count = region.count_inside(tx, ty, c, z, run.length);
            for (int m = 0; m < material_count; ++m) {
                units[static_cast<size_t>(m)] +=
                    int64_t{run.values[static_cast<size_t>(kKeptMaterial + m)]} * count;
            }
        });
    });
    // Of tiles that are awake only what tells, no higher than the region, and all of them at once.
    const auto layer_words = static_cast<size_t>(region.layer_count()) * kTileColumns;
    const auto plane_count = static_cast<size_t>(1 + material_count);
    if (s.region_words.capacity() > kRegionWordsKept) s.region_words = {};
    std::vector<int32_t>& words = s.region_words;
    words.resize(awake.size() * plane_count * layer_words);
    std::vector<device::ReadRange> ranges;
    for (size_t i = 0; i < awake.size() * plane_count; ++i) {
        const auto kept = static_cast<int>(i % plane_count);
        const int plane = state_plane_of(kept == 0 ? kKeptVolume : kKeptMaterial + kept - 1);
        ranges.push_back({Buffer::state,
                          s.tiles.plane_offset(plane, awake[i / plane_count].slot) +
                              region.lowest_layer() * kTileColumns,
                          std::span(words).subspan(i * layer_words, layer_words)});
    }
    s.device->read(ranges);
    for (size_t i = 0; i < awake.size(); ++i) {
        const auto at = [&, first = i * plane_count * layer_words](size_t kept, int z, int c) {
            return words[first + kept * layer_words +
                         static_cast<size_t>((z - region.lowest_layer()) * kTileColumns + c)];
        };
        region.for_each_voxel(
            awake[i].tx, awake[i].ty, [&](int z, int c) { return at(0, z, c) != 0; },
            [&](int z, int c) {
                for (size_t kept = 1; kept < plane_count; ++kept) units[kept - 1] += at(kept, z, c);
            });
    }
    return units;
}

}  // namespace

double Soil::mass_inside_kg(const ConvexShape& shape, const Pose& pose) const {
    const std::vector<int64_t> units = units_inside(*impl_, shape, pose);
    const int64_t all = std::accumulate(units.begin(), units.end(), int64_t{0});
    return static_cast<double>(all) * impl_->kg_per_unit;
}

std::vector<double> Soil::masses_inside_kg(const ConvexShape& shape, const Pose& pose) const {
    std::vector<double> masses_kg;
    for (const int64_t units : units_inside(*impl_, shape, pose)) {
        masses_kg.push_back(static_cast<double>(units) * impl_->kg_per_unit);
    }
    return masses_kg;
}

Result<std::vector<int64_t>> Soil::take_out(const ConvexShape& shape, const Pose& pose) {
    Impl& s = *impl_;
    if (!is_valid_shape(shape)) {
        return Error{"take_out: the region's sizes must be finite and above zero"};
    }
    if (!is_rigid(pose)) return Error{"take_out: the region's pose must be finite, and a rotation"};
    const Region region(shape, pose, s.world_to_grid, s.frame);
    s.finish();
    std::vector<int64_t> units(s.materials.size());
    TileVoxels voxels;
    region.for_each_tile([&](int tx, int ty) {
        const int index = s.tile_index(tx, ty);
        if (!s.tiles[index]) return;
        s.tiles.read_voxels(index, voxels);
        bool changed = false;
        const auto has_soil = [&](int z, int c) { return voxels.at(kKeptVolume, z, c) != 0; };
        region.for_each_voxel(tx, ty, has_soil, [&](int z, int c) {
            for (int m = 0; m < s.params.material_count; ++m) {
                units[m] += voxels.at(kKeptMaterial + m, z, c);
            }
            for (int plane = kKeptVolume; plane < s.kept_planes; ++plane) {
                voxels.at(plane, z, c) = 0;
            }
            changed = true;
        });
        if (!changed) return;
        s.tiles.write_voxels(index, voxels);
        Tile& tile = *s.tiles[index];
        ++tile.revision;
        tile.unchecked = s.tiles.any_unchecked = true;  // soil may have lost what it rested on
    });
    return units;
}

}  // namespace bsoil
