// Fixed terrain in the coverage field, from a density function or a closed mesh (thesis
// section 4.1.3).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "soil/soil_impl.h"

namespace bsoil {

using namespace layout;

Status Soil::Impl::terrain_with(const VoxelFraction& fraction) {
    // All tiles first, then all writes: an error leaves nothing half done.
    std::vector<std::pair<int, std::shared_ptr<const PackedTile>>> changed;
    TileVoxels voxels, ground, buried;
    for (int index = 0; index < tiles_x * tiles_y; ++index) {
        const int x0 = index % tiles_x * kTileSide, y0 = index / tiles_x * kTileSide;
        tile_for(index);
        read_voxels(index, voxels);
        read_ground(index, ground);
        const bool any_ground = !ground.words.empty();
        const bool any_buried = read_buried(index, buried);
        bool any = false;
        for (int c = 0; c < kTileColumns; ++c) {
            const int x = x0 + c % kTileSide, y = y0 + c / kTileSide;
            if (x >= frame.size[0] || y >= frame.size[1]) {
                continue;
            }
            for (int z = 0; z < height; ++z) {
                const int units = static_cast<int>(
                    std::lround(std::clamp(fraction(x, y, z), 0.0, 1.0) * kVoxelFull));
                int32_t& terrain = voxels.at(kKeptTerrain, z, c);
                const int of_bodies = any_ground ? ground.at(0, z, c) : 0;
                const int below = any_buried ? buried.at(kKeptVolume, z, c) : 0;
                if (units <= terrain - of_bodies) {
                    continue;
                }
                if (units + voxels.at(kKeptVolume, z, c) + below > kVoxelFull) {
                    const Vec3 at = frame.to_world({x + 0.5, y + 0.5, z + 0.5});
                    return Error{
                        fmt::format("terrain would bury soil at ({:.3g}, {:.3g}, {:.3g}) m: add "
                                    "terrain before soil",
                                    at.x, at.y, at.z)};
                }
                terrain = units + of_bodies;  // put_ground() takes what is too much
                any = true;
            }
        }
        if (any) {
            changed.emplace_back(index, make_packed(voxels));
        }
    }
    if (changed.empty()) {
        return Error{"the terrain lies outside of the grid"};
    }
    for (const auto& [index, packed] : changed) {
        write_packed(index, packed);
        read_ground(index, ground);
        if (!ground.words.empty()) {
            put_ground(index, ground.words, true);
        }
        ++tiles[index]->revision;
    }
    return Done{};
}

Status Soil::add_terrain(const TriangleMesh& mesh) {
    Impl& s = *impl_;
    if (mesh.triangles.empty()) {
        return Error{"terrain.mesh has no triangles"};
    }
    const int vertex_count = static_cast<int>(mesh.vertices.size());
    std::vector<Vec3> points;
    for (Vec3 vertex : mesh.vertices) {
        if (!is_finite(vertex)) {
            return Error{"terrain.mesh has a NaN or infinite vertex"};
        }
        points.push_back(s.to_grid(vertex));
    }
    std::map<std::pair<int, int>, int> edges;
    for (const auto& triangle : mesh.triangles) {
        for (int i = 0; i < 3; ++i) {
            const int a = triangle[i], b = triangle[(i + 1) % 3];
            if (a < 0 || b < 0 || a >= vertex_count || b >= vertex_count) {
                return Error{fmt::format("terrain.mesh names vertex {}, it has {}", std::max(a, b),
                                         vertex_count)};
            }
            edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
    }
    for (const auto& [edge, balance] : edges) {
        if (balance != 0) {
            return Error{fmt::format(
                "terrain.mesh is not closed: edge {}-{} does not have a triangle on each side",
                edge.first, edge.second)};
        }
    }
    // Vertical lines through 2 x 2 points of each column cross the surface at heights; between an
    // entry and an exit is rock. Winding decides, so that overlapping closed parts unite.
    constexpr int kLines = 2;
    struct Crossing {
        float z;
        int winding;
    };
    const int columns_x = s.frame.size[0] * kLines, columns_y = s.frame.size[1] * kLines;
    std::vector<std::vector<Crossing>> crossings(static_cast<size_t>(columns_x) * columns_y);
    for (const auto& triangle : mesh.triangles) {
        const Vec3 a = points[triangle[0]], b = points[triangle[1]], c = points[triangle[2]];
        const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if (area == 0) {
            continue;  // vertical: no line crosses it
        }
        const auto bound = [&](double v, int count) {
            return static_cast<int>(std::clamp(std::floor(v * kLines), 0.0, count - 1.0));
        };
        const int i0 = bound(std::min({a.x, b.x, c.x}) - 1, columns_x),
                  i1 = bound(std::max({a.x, b.x, c.x}) + 1, columns_x);
        const int j0 = bound(std::min({a.y, b.y, c.y}) - 1, columns_y),
                  j1 = bound(std::max({a.y, b.y, c.y}) + 1, columns_y);
        for (int j = j0; j <= j1; ++j) {
            for (int i = i0; i <= i1; ++i) {
                const double px = (i + 0.5) / kLines, py = (j + 0.5) / kLines;
                // A point on an edge belongs to exactly one of the two triangles: compare with a
                // fixed order of the ends.
                const auto side = [&](Vec3 p, Vec3 q) {
                    const bool swap = p.x > q.x || (p.x == q.x && p.y > q.y);
                    const Vec3 u = swap ? q : p, v = swap ? p : q;
                    const bool left = (v.x - u.x) * (py - u.y) - (v.y - u.y) * (px - u.x) >= 0;
                    return left != swap;
                };
                const bool ab = side(a, b), bc = side(b, c), ca = side(c, a);
                if (ab != bc || bc != ca) {
                    continue;
                }
                const double u = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) / area;
                const double v = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area;
                crossings[static_cast<size_t>(j) * columns_x + i].push_back(
                    {static_cast<float>(a.z + u * (b.z - a.z) + v * (c.z - a.z)),
                     area > 0 ? 1 : -1});
            }
        }
    }
    std::vector<float> covered(static_cast<size_t>(s.frame.size[0]) * s.frame.size[1] * s.height,
                               0.0f);
    for (int j = 0; j < columns_y; ++j) {
        for (int i = 0; i < columns_x; ++i) {
            auto& line = crossings[static_cast<size_t>(j) * columns_x + i];
            std::sort(line.begin(), line.end(),
                      [](const Crossing& a, const Crossing& b) { return a.z < b.z; });
            int inside = 0;
            for (size_t k = 0; k + 1 < line.size(); ++k) {
                inside += line[k].winding;
                if (inside == 0) {
                    continue;
                }
                const double low =
                    std::clamp(static_cast<double>(line[k].z), 0.0, static_cast<double>(s.height));
                const double high = std::clamp(static_cast<double>(line[k + 1].z), 0.0,
                                               static_cast<double>(s.height));
                for (int z = static_cast<int>(low); z < s.height && z < high; ++z) {
                    const double share =
                        std::min(high, z + 1.0) - std::max(low, static_cast<double>(z));
                    covered[(static_cast<size_t>(j / kLines) * s.frame.size[0] + i / kLines) *
                                s.height +
                            z] += static_cast<float>(share / (kLines * kLines));
                }
            }
        }
    }
    return s.terrain_with([&](int x, int y, int z) {
        return covered[(static_cast<size_t>(y) * s.frame.size[0] + x) * s.height + z];
    });
}

}  // namespace bsoil
