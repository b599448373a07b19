// Fixed terrain in the coverage field, from a density function or a closed mesh (thesis
// section 4.1.3).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

namespace {

// Vertical lines through 2 x 2 points of each column cross the surface at heights; between an entry
// and an exit is rock. Winding decides, so that overlapping closed parts unite.
constexpr int kLines = 2;
constexpr int kTileLines = kLines * kTileSide;

/// A closed mesh as rock, tile by tile: takes memory for the mesh and one tile, whatever the grid.
class MeshCoverage {
  public:
    /// Fractions of a tile's voxels.
    struct Tile {
        int height = 0;
        std::vector<float> fractions;
        double at(int x, int y, int z) const {
            return fractions[static_cast<size_t>(
                (y % kTileSide * kTileSide + x % kTileSide) * height + z)];
        }
    };

    /// `points`: the vertices in grid voxels.
    MeshCoverage(const Soil::Impl& soil, std::vector<Vec3> points,
                 const std::vector<std::array<int, 3>>& triangles)
        : soil_(soil), points_(std::move(points)), triangles_(triangles) {
        double top = 0;
        for (const Vec3 p : points_) top = std::max(top, p.z);
        z_end_ = static_cast<int>(std::ceil(std::min(top, static_cast<double>(soil.height))));
        rows_.resize(static_cast<size_t>(soil.tiles_y));
        for (size_t t = 0; t < triangles.size(); ++t) {
            const Box box = tiles_of(t);
            test_count_ +=
                int64_t{box.x1 - box.x0 + 1} * (box.y1 - box.y0 + 1) * kTileLines * kTileLines;
            rows_[static_cast<size_t>(box.y0)].push_back(t);
        }
    }

    /// No rock at or above it.
    int z_end() const { return z_end_; }

    Status check_cost() const {
        const int64_t voxel_count =
            int64_t{soil_.frame.size[0]} * soil_.frame.size[1] * std::max(1, z_end_);
        if (voxel_count > limits::kTerrainVoxelsMax) {
            return Error{fmt::format(
                "terrain.mesh goes through {:.3g} voxels, at most {:.3g} are possible: take "
                "larger voxels or a smaller box",
                static_cast<double>(voxel_count), static_cast<double>(limits::kTerrainVoxelsMax))};
        }
        if (test_count_ > limits::kTerrainTestsMax) {
            return Error{fmt::format(
                "terrain.mesh has too many triangles over each other: {} triangles, which touch "
                "{:.3g} tiles each; take fewer, or larger voxels",
                triangles_.size(),
                static_cast<double>(test_count_) / (kTileLines * kTileLines) /
                    static_cast<double>(triangles_.size()))};
        }
        return Done{};
    }

    /// The rock of a tile. Tiles of a row are asked for from left to right, rows upwards.
    void cover(int index, Tile& tile) {
        const int tx = index % soil_.tiles_x, ty = index / soil_.tiles_x;
        if (ty != row_) start_row(ty);
        tile.height = soil_.height;
        tile.fractions.assign(static_cast<size_t>(kTileColumns) * soil_.height, 0.0f);
        for (; column_ < tx + 1; ++column_) {
            std::erase_if(in_tile_, [&](size_t t) { return tiles_of(t).x1 < column_; });
            const auto& fresh = columns_[static_cast<size_t>(column_)];
            in_tile_.insert(in_tile_.end(), fresh.begin(), fresh.end());
        }
        if (in_tile_.empty()) return;
        for (int line = 0; line < kTileLines * kTileLines; ++line) {
            const int i = line % kTileLines, j = line / kTileLines;
            find_crossings(tx * kTileLines + i, ty * kTileLines + j);
            add_line(&tile.fractions[static_cast<size_t>((j / kLines * kTileSide + i / kLines) *
                                                         soil_.height)]);
        }
    }

  private:
    struct Box {
        int x0, x1, y0, y1;
    };
    struct Crossing {
        float z;
        int winding;
    };

    /// Tiles that a triangle's box touches, with a line to spare on each side.
    Box tiles_of(size_t t) const {
        const Vec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
        const auto bound = [](double v, int count) {
            return static_cast<int>(std::clamp(std::floor(v / kTileSide), 0.0, count - 1.0));
        };
        return {bound(std::min({a.x, b.x, c.x}) - 1, soil_.tiles_x),
                bound(std::max({a.x, b.x, c.x}) + 1, soil_.tiles_x),
                bound(std::min({a.y, b.y, c.y}) - 1, soil_.tiles_y),
                bound(std::max({a.y, b.y, c.y}) + 1, soil_.tiles_y)};
    }
    Vec3 corner(size_t t, size_t k) const { return points_[static_cast<size_t>(triangles_[t][k])]; }

    /// The triangles that touch a row of tiles, by the first of them.
    void start_row(int ty) {
        for (row_ = std::max(row_, -1); row_ < ty;) {
            ++row_;
            std::erase_if(in_row_, [&](size_t t) { return tiles_of(t).y1 < row_; });
            const auto& fresh = rows_[static_cast<size_t>(row_)];
            in_row_.insert(in_row_.end(), fresh.begin(), fresh.end());
        }
        columns_.resize(static_cast<size_t>(soil_.tiles_x));
        for (auto& column : columns_) column.clear();
        for (const size_t t : in_row_) columns_[static_cast<size_t>(tiles_of(t).x0)].push_back(t);
        in_tile_.clear();
        column_ = 0;
    }

    /// Where line (i, j) of the grid crosses the mesh, from below.
    void find_crossings(int i, int j) {
        const double px = (i + 0.5) / kLines, py = (j + 0.5) / kLines;
        line_.clear();
        for (const size_t t : in_tile_) {
            const Vec3 a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
            const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
            if (area == 0) {
                continue;  // vertical: no line crosses it
            }
            // A point on an edge belongs to exactly one of the two triangles: compare with a
            // fixed order of the ends.
            const auto side = [&](Vec3 p, Vec3 q) {
                const bool swap = p.x > q.x || (p.x == q.x && p.y > q.y);
                const Vec3 u = swap ? q : p, v = swap ? p : q;
                const bool left = (v.x - u.x) * (py - u.y) - (v.y - u.y) * (px - u.x) >= 0;
                return left != swap;
            };
            const bool ab = side(a, b), bc = side(b, c), ca = side(c, a);
            if (ab != bc || bc != ca) continue;
            const double u = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) / area;
            const double v = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area;
            line_.push_back(
                {static_cast<float>(a.z + u * (b.z - a.z) + v * (c.z - a.z)), area > 0 ? 1 : -1});
        }
        std::sort(line_.begin(), line_.end(),
                  [](const Crossing& a, const Crossing& b) { return a.z < b.z; });
    }

    /// Adds the rock along the line at hand to its column.
    void add_line(float* column) const {
        int inside = 0;
        for (size_t k = 0; k + 1 < line_.size(); ++k) {
            inside += line_[k].winding;
            if (inside == 0) continue;
            const auto within = [&](float z) {
                return std::clamp(static_cast<double>(z), 0.0, static_cast<double>(soil_.height));
            };
            const double low = within(line_[k].z), high = within(line_[k + 1].z);
            for (int z = static_cast<int>(low); z < soil_.height && z < high; ++z) {
                const double share =
                    std::min(high, z + 1.0) - std::max(low, static_cast<double>(z));
                column[z] += static_cast<float>(share / (kLines * kLines));
            }
        }
    }

    const Soil::Impl& soil_;
    std::vector<Vec3> points_;
    const std::vector<std::array<int, 3>>& triangles_;
    int z_end_ = 0;
    int64_t test_count_ = 0;
    std::vector<std::vector<size_t>> rows_;  ///< triangles by the first row they touch
    // Of the row and the tile at hand.
    int row_ = -1, column_ = 0;
    std::vector<size_t> in_row_, in_tile_;
    std::vector<std::vector<size_t>> columns_;
    std::vector<Crossing> line_;
};

}  // namespace

Status Soil::Impl::terrain_with(const VoxelFraction& fraction, int z_end) {
    finish();
    // All tiles first, then all writes: an error leaves nothing half done.
    std::vector<std::pair<int, std::shared_ptr<const PackedTile>>> changed;
    TileVoxels voxels, of_ground, buried;
    for (int index = 0; index < tiles_x * tiles_y; ++index) {
        const int x0 = index % tiles_x * kTileSide, y0 = index / tiles_x * kTileSide;
        bool is_read = false, any = false, any_ground = false, any_buried = false;
        for (int c = 0; c < kTileColumns; ++c) {
            const int x = x0 + c % kTileSide, y = y0 + c / kTileSide;
            if (x >= frame.size[0] || y >= frame.size[1]) continue;
            for (int z = 0; z < z_end; ++z) {
                const int units = static_cast<int>(
                    std::lround(std::clamp(fraction(x, y, z), 0.0, 1.0) * kVoxelFull));
                if (units == 0) continue;
                if (!is_read) {
                    tiles.make(index);
                    tiles.read_voxels(index, voxels);
                    tiles.read_ground(index, of_ground);
                    any_ground = !of_ground.words.empty();
                    any_buried = tiles.read_buried(index, buried);
                    is_read = true;
                }
                int32_t& terrain = voxels.at(kKeptTerrain, z, c);
                const int of_bodies = any_ground ? of_ground.at(0, z, c) : 0;
                const int below = any_buried ? buried.at(kKeptVolume, z, c) : 0;
                if (units <= terrain - of_bodies) continue;
                if (units + voxels.at(kKeptVolume, z, c) + below > kVoxelFull) {
                    const Vec3 at = frame.to_world({x + 0.5, y + 0.5, z + 0.5});
                    return Error{
                        fmt::format("terrain would bury soil at ({:.3g}, {:.3g}, {:.3g}) m; add "
                                    "terrain before soil",
                                    at.x, at.y, at.z)};
                }
                terrain = units + of_bodies;  // GroundBodies::put() takes what is too much
                any = true;
            }
        }
        if (any) changed.emplace_back(index, make_packed(voxels));
    }
    if (changed.empty()) {
        return Error{"the terrain lies outside of the grid; move it, or enlarge size_m"};
    }
    for (const auto& [index, packed] : changed) {
        tiles.write_packed(index, packed);
        tiles.read_ground(index, of_ground);
        if (!of_ground.words.empty()) ground.put(index, of_ground.words, true);
        ++tiles[index]->revision;
    }
    return Done{};
}

Status Soil::add_terrain(const TriangleMesh& mesh) {
    Impl& s = *impl_;
    if (mesh.triangles.empty()) return Error{"terrain.mesh has no triangles; fill it first"};
    const int vertex_count = static_cast<int>(mesh.vertices.size());
    std::vector<Vec3> points;
    for (Vec3 vertex : mesh.vertices) {
        if (!is_finite(vertex)) return Error{"terrain.mesh must be finite at each vertex"};
        points.push_back(s.to_grid(vertex));
        if (!is_finite(points.back())) {
            return Error{
                "terrain.mesh has a vertex too far away to be computed with; cut it to the grid"};
        }
    }
    std::map<std::pair<int, int>, int> edges;
    for (const auto& triangle : mesh.triangles) {
        for (int i = 0; i < 3; ++i) {
            const int a = triangle[i], b = triangle[(i + 1) % 3];
            if (a < 0 || b < 0 || a >= vertex_count || b >= vertex_count) {
                return Error{fmt::format("terrain.mesh names vertex {}, must be below {}",
                                         std::max(a, b), vertex_count)};
            }
            edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
    }
    for (const auto& [edge, balance] : edges) {
        if (balance != 0) {
            return Error{fmt::format(
                "terrain.mesh is not closed: edge {}-{} does not have a triangle on each side; "
                "close it",
                edge.first, edge.second)};
        }
    }
    MeshCoverage coverage(s, std::move(points), mesh.triangles);
    if (Status small = coverage.check_cost(); !small) return small;
    MeshCoverage::Tile tile;
    int covered_tile = -1;
    return s.terrain_with(
        [&](int x, int y, int z) {
            if (const int index = s.tile_index(x / kTileSide, y / kTileSide);
                index != covered_tile) {
                coverage.cover(index, tile);
                covered_tile = index;
            }
            return tile.at(x, y, z);
        },
        coverage.z_end());
}

}  // namespace bsoil
