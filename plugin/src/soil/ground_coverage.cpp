#include "soil/ground_coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/layout.h"
#include "bsoil/distance_lattice.h"
#include "soil/shape_bounds.h"

namespace bsoil {

using namespace layout;

namespace {

constexpr int kVoxelCells = 4;  ///< along each axis of a voxel
/// All sub-cells of a voxel are in or out where the surface is this far from its middle [voxels]:
/// the outermost one's middle is 0.65 away, and it ends 1/8 further on.
constexpr double kClearVoxels = 0.8125;

/// Signed distance [m] of a point in the shape's frame, no more than the true one.
double distance_m(const ConvexShape& s, Vec3 p) {
    const double r = s.radius_m, h = s.half_height_m;
    double distance = 0;
    switch (s.kind) {
        case ConvexShape::Kind::box:
            distance =
                std::max({std::abs(p.x) - s.half_extents_m.x, std::abs(p.y) - s.half_extents_m.y,
                          std::abs(p.z) - s.half_extents_m.z});
            break;
        case ConvexShape::Kind::sphere:
            distance = length(p) - r;
            break;
        case ConvexShape::Kind::capsule:
            distance = length({p.x, p.y, p.z - std::clamp(p.z, -h, h)}) - r;
            break;
        case ConvexShape::Kind::cylinder:
            distance = std::max(length({p.x, p.y, 0}) - r, std::abs(p.z) - h);
            break;
        case ConvexShape::Kind::cone: {
            const double slant = length({r, 2 * h, 0});
            distance = std::max((length({p.x, p.y, 0}) * 2 * h + (p.z - h) * r) / slant, -h - p.z);
            break;
        }
        case ConvexShape::Kind::hull:
            distance = -std::numeric_limits<double>::infinity();
            for (const Plane& plane : s.planes) {
                distance = std::max(distance, dot(plane.normal, p) - plane.offset);
            }
            break;
        case ConvexShape::Kind::lattice:
            distance = s.lattice->distance_m(p);
            break;
    }
    return distance - s.rounding_m;
}

/// Cubes of voxels, halved until the surface is clear of them.
class CubeFiller {
  public:
    CubeFiller(const ConvexShape& shape, const Pose& from_grid, double voxel_m,
               const TilePlace& tile, std::span<int32_t> units)
        : shape_(shape), from_grid_(from_grid), voxel_m_(voxel_m), tile_(tile), units_(units) {}

    /// The cube of `side` voxels from (x, y, z) of the tile on.
    void fill(int x, int y, int z, int side) {
        const double half = side / 2.0;
        const double clear = (half - 0.5) * std::numbers::sqrt3 + kClearVoxels;
        const double middle = distance_at(x + half, y + half, z + half);
        if (middle >= clear) return;
        if (middle <= -clear) {
            add(x, y, z, side, kVoxelFull);
        } else if (side == 1) {
            add(x, y, z, 1, units_of(x, y, z));
        } else {
            for (int i = 0; i < 8; ++i) {
                fill(x + (i & 1) * side / 2, y + (i >> 1 & 1) * side / 2, z + (i >> 2) * side / 2,
                     side / 2);
            }
        }
    }

    /// The tile's voxels at that height, where all of them are covered alike.
    void fill_layer(int z) {
        const double middle = distance_at(0.5, 0.5, z + 0.5);
        if (middle >= kClearVoxels) return;
        const int units = middle <= -kClearVoxels ? kVoxelFull : units_of(0, 0, z);
        const auto first = units_.begin() + static_cast<std::ptrdiff_t>(z) * kTileColumns;
        std::for_each(first, first + kTileColumns, [units](int32_t& word) { word += units; });
    }

  private:
    /// Of a place in the tile, all in voxels.
    double distance_at(double x, double y, double z) const {
        const Vec3 at{tile_.x0 + x, tile_.y0 + y, z};
        return distance_m(shape_, transform(from_grid_, at * voxel_m_)) / voxel_m_;
    }
    int units_of(int x, int y, int z) const {
        double sum = 0;
        for (int i = 0; i < kVoxelCells * kVoxelCells * kVoxelCells; ++i) {
            const auto middle = [](int cell) { return (cell + 0.5) / kVoxelCells; };
            const double inside =
                distance_at(x + middle(i % kVoxelCells), y + middle(i / kVoxelCells % kVoxelCells),
                            z + middle(i / (kVoxelCells * kVoxelCells)));
            sum += std::clamp(0.5 - inside * kVoxelCells, 0.0, 1.0);
        }
        constexpr double kUnits = kVoxelFull / (kVoxelCells * kVoxelCells * kVoxelCells);
        return static_cast<int>(sum * kUnits + 0.5);
    }
    void add(int x, int y, int z, int side, int units) {
        for (int k = z; k < z + side; ++k) {
            for (int j = y; j < y + side; ++j) {
                for (int i = x; i < x + side; ++i) {
                    units_[static_cast<size_t>((k * kTileSide + j) * kTileSide + i)] += units;
                }
            }
        }
    }

    const ConvexShape& shape_;
    const Pose& from_grid_;
    double voxel_m_;
    TilePlace tile_;
    std::span<int32_t> units_;
};

/// Whether only the upper and lower faces of a box that lies level reach into the tile.
bool is_level_over(const ConvexShape& shape, const Pose& from_grid, double voxel_m,
                   const TilePlace& tile) {
    if (shape.kind != ConvexShape::Kind::box) return false;
    constexpr double kUpright = 1 - 1e-12;
    const Vec3 up = rotate(from_grid.rotation, {0, 0, 1});
    const double along[3] = {std::abs(up.x), std::abs(up.y), std::abs(up.z)};
    const double half[3] = {shape.half_extents_m.x, shape.half_extents_m.y, shape.half_extents_m.z};
    for (int corner = 0; corner < 4; ++corner) {
        const Vec3 at = transform(
            from_grid,
            Vec3{tile.x0 + 8.0 * (corner & 1), tile.y0 + 8.0 * (corner >> 1), 0} * voxel_m);
        const double place[3] = {at.x, at.y, at.z};
        int across = 0;
        for (int axis = 0; axis < 3; ++axis) {
            across += along[axis] < kUpright && std::abs(place[axis]) < half[axis] - voxel_m;
        }
        if (across != 2) return false;
    }
    return true;
}

}  // namespace

void add_coverage(const ConvexShape& shape, const Pose& body_to_grid, double voxel_m,
                  const TilePlace& tile, std::span<int32_t> units) {
    const Aabb box = shape_bounds(shape, body_to_grid, voxel_m);
    const auto first = static_cast<int>(std::floor(std::clamp(box.min.z, 0.0, 1e6)));
    const auto last = static_cast<int>(std::floor(std::clamp(box.max.z, -1.0, 1e6)));
    const Pose from_grid = inverse(body_to_grid * shape.local);
    CubeFiller filler(shape, from_grid, voxel_m, tile, units);
    if (is_level_over(shape, from_grid, voxel_m, tile)) {
        for (int z = first; z <= last && z < tile.height; ++z) filler.fill_layer(z);
        return;
    }
    for (int z = first / kTileSide * kTileSide; z <= last && z < tile.height; z += kTileSide) {
        filler.fill(0, 0, z, kTileSide);
    }
}

}  // namespace bsoil
