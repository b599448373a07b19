#include "bsoil/host/ground_surface.h"

#include <algorithm>
#include <cmath>

namespace bsoil {
namespace {

/// A column that moves by less has not changed [voxels]. Ours: the grid cannot tell it from one at
/// rest. Larger: a body beside soil that creeps keeps its old contact points.
constexpr double kChangedVoxels = 0.01;
/// Vertices nearer than this to a plane lie in it [voxels]. Ours: fixed point leaves a thousandth.
/// Larger: a gentle slope is met as level; smaller: level ground costs two triangles a column.
constexpr double kPlaneVoxels = 0.001;

}  // namespace

GroundSurface::GroundSurface(const Soil& soil)
    : soil_(soil),
      voxel_m_(soil.frame().voxel_m),
      size_{soil.frame().size[0], soil.frame().size[1]} {}

double GroundSurface::vertex_m(int axis, int vertex) const {
    return std::clamp(vertex - 0.5, 0.0, static_cast<double>(size_[axis])) * voxel_m_;
}

GroundSurface::Cell GroundSurface::cell_at(double x_m, double y_m) const {
    const auto index = [this](double at_m, int axis) {
        const double vertex = std::max(0.0, std::floor(at_m / voxel_m_ + 0.5));  // NaN: 0
        return static_cast<int>(std::min(vertex, static_cast<double>(size_[axis])));
    };
    return {index(x_m, 0), index(y_m, 1)};
}

/// Null: nothing has ever been there.
const GroundSurface::Tile* GroundSurface::tile_at(int column_x, int column_y) const {
    const int tx = column_x / kTileSide, ty = column_y / kTileSide;
    const uint64_t revision = soil_.tile_revision(tx, ty);
    if (revision == 0) return nullptr;
    Tile& tile = tiles_[ty * tiles_x() + tx];
    if (tile.revision == revision) return &tile;
    tile.revision = revision;
    for (int c = 0; c < kTileColumns; ++c) {
        tile.height_m[c] = static_cast<float>(
            soil_.surface_height_m(tx * kTileSide + c % kTileSide, ty * kTileSide + c / kTileSide));
    }
    return &tile;
}

double GroundSurface::height_m(int vertex_x, int vertex_y) const {
    const int x = std::clamp(vertex_x - 1, 0, size_[0] - 1);
    const int y = std::clamp(vertex_y - 1, 0, size_[1] - 1);
    const Tile* tile = tile_at(x, y);
    return tile ? static_cast<double>(tile->height_m[y % kTileSide * kTileSide + x % kTileSide])
                : 0.0;
}

int GroundSurface::triangles(Cell cell, double z_low_m, double z_high_m,
                             std::array<Triangle, 2>& triangles) const {
    const auto vertex = [this, cell](int dx, int dy) {
        return Vec3{vertex_m(0, cell.x + dx), vertex_m(1, cell.y + dy),
                    height_m(cell.x + dx, cell.y + dy)};
    };
    const Vec3 a = vertex(0, 0), b = vertex(1, 0), c = vertex(1, 1), d = vertex(0, 1);
    int count = 0;
    const auto add = [&](Vec3 p, Vec3 q, Vec3 r) {
        const double high = std::max({p.z, q.z, r.z}), low = std::min({p.z, q.z, r.z});
        if (high > 0 && high >= z_low_m && low <= z_high_m) triangles[count++] = {{p, q, r}};
    };
    add(a, b, c);
    add(a, c, d);
    return count;
}

bool GroundSurface::plane_triangles(Cell low, Cell high, std::array<Triangle, 2>& triangles) const {
    const auto vertex = [this](int x, int y) {
        return Vec3{vertex_m(0, x), vertex_m(1, y), height_m(x, y)};
    };
    const int x1 = high.x + 1, y1 = high.y + 1;
    const Vec3 a = vertex(low.x, low.y), b = vertex(x1, low.y), d = vertex(low.x, y1);
    const Vec3 normal = cross(b - a, d - a);
    for (int y = low.y; y <= y1; ++y) {
        for (int x = low.x; x <= x1; ++x) {
            const Vec3 v = vertex(x, y);
            if (!(v.z > 0) ||
                std::abs(dot(v - a, normal)) > kPlaneVoxels * voxel_m_ * std::abs(normal.z)) {
                return false;
            }
        }
    }
    const Vec3 c = vertex(x1, y1);
    triangles = {Triangle{{a, b, c}}, Triangle{{a, c, d}}};
    return true;
}

std::optional<SurfacePoint> GroundSurface::at(double x_m, double y_m) const {
    const double voxels_x = x_m / voxel_m_, voxels_y = y_m / voxel_m_;
    if (!(voxels_x >= 0 && voxels_y >= 0 && voxels_x <= size_[0] && voxels_y <= size_[1])) {
        return {};
    }
    const Cell cell = cell_at(x_m, y_m);
    const double x0 = vertex_m(0, cell.x), y0 = vertex_m(1, cell.y);
    const double u = (x_m - x0) / (vertex_m(0, cell.x + 1) - x0);
    const double v = (y_m - y0) / (vertex_m(1, cell.y + 1) - y0);
    std::array<Triangle, 2> both;
    const int count = triangles(cell, 0, HUGE_VAL, both);
    for (int i = 0; i < count; ++i) {
        const auto& [p, q, r] = both[i].corners_m;
        // The first triangle lies where u > v; its second corner is the one off the diagonal.
        const bool is_first = q.x > p.x && q.y == p.y;
        if (is_first != (u >= v)) continue;
        const Vec3 normal = cross(q - p, r - p);
        const double z = p.z - (normal.x * (x_m - p.x) + normal.y * (y_m - p.y)) / normal.z;
        return SurfacePoint{{x_m, y_m, z}, normal * (1 / length(normal))};
    }
    return {};
}

/// Vertex v belongs to column v - 1; a cell to its four vertices.
GroundSurface::Columns GroundSurface::columns_of(Cell low, Cell high) const {
    return {std::clamp(low.x - 1, 0, size_[0] - 1), std::clamp(low.y - 1, 0, size_[1] - 1),
            std::clamp(high.x, 0, size_[0] - 1), std::clamp(high.y, 0, size_[1] - 1)};
}

void GroundSurface::compare(Met& met, const Tile& tile, bool is_new) const {
    if (met.generation != generation_) {
        met.generation = generation_;
        met.heights.changed = 0;
    }
    if (is_new) met.heights.settled_m = tile.height_m;
    if (met.revision == tile.revision) return;
    met.revision = tile.revision;
    for (int c = 0; c < kTileColumns; ++c) {
        const float height_m = tile.height_m[c];
        if (std::abs(static_cast<double>(height_m - met.heights.settled_m[c])) <=
            kChangedVoxels * voxel_m_) {
            continue;
        }
        met.heights.before_m[c] = met.heights.settled_m[c];
        met.heights.settled_m[c] = height_m;
        met.heights.changed |= uint64_t{1} << c;
    }
}

void GroundSurface::meet(Cell low, Cell high) {
    const Columns columns = columns_of(low, high);
    for (int ty = columns.y0 / kTileSide; ty <= columns.y1 / kTileSide; ++ty) {
        for (int tx = columns.x0 / kTileSide; tx <= columns.x1 / kTileSide; ++tx) {
            const Tile* tile = tile_at(tx * kTileSide, ty * kTileSide);
            if (!tile) continue;
            const auto [met, is_new] = met_.try_emplace(ty * tiles_x() + tx);
            compare(met->second, *tile, is_new);
        }
    }
}

bool GroundSurface::has_changed(Cell low, Cell high, double z_low_m, double z_high_m) {
    meet(low, high);
    const auto [x0, y0, x1, y1] = columns_of(low, high);
    for (int ty = y0 / kTileSide; ty <= y1 / kTileSide; ++ty) {
        for (int tx = x0 / kTileSide; tx <= x1 / kTileSide; ++tx) {
            const auto found = met_.find(ty * tiles_x() + tx);
            if (found == met_.end() || found->second.heights.changed == 0) continue;
            const Met& met = found->second;
            for (int c = 0; c < kTileColumns; ++c) {
                const int x = tx * kTileSide + c % kTileSide, y = ty * kTileSide + c / kTileSide;
                const bool has_changed = (met.heights.changed >> c & 1) != 0;
                if (!has_changed || x < x0 || x > x1 || y < y0 || y > y1) continue;
                const auto now = static_cast<double>(met.heights.settled_m[c]);
                const auto before = static_cast<double>(met.heights.before_m[c]);
                if (std::max(now, before) >= z_low_m && std::min(now, before) <= z_high_m) {
                    return true;
                }
            }
        }
    }
    return false;
}

std::vector<GroundSurface::MetTile> GroundSurface::met_tiles() const {
    std::vector<MetTile> out;
    for (const auto& [tile, met] : met_) {
        out.push_back({tile, met.heights});
        if (met.generation != generation_) out.back().heights.changed = 0;
    }
    std::ranges::sort(out, {}, &MetTile::tile);
    return out;
}

void GroundSurface::set_met_tiles(std::span<const MetTile> tiles) {
    // What stands for a tile that is not there is never asked for.
    met_.clear();
    // Revision 0: compared again with what is there when it is next met.
    for (const MetTile& tile : tiles) met_[tile.tile] = {0, generation_, tile.heights};
}

}  // namespace bsoil
