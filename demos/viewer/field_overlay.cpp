#include "field_overlay.h"

#include <algorithm>
#include <cmath>

namespace bsoil::viewer {
namespace {

Vec3 vertex(const std::vector<float>& list, size_t v) {
    return {list[3 * v], list[3 * v + 1], list[3 * v + 2]};
}

}  // namespace

FieldOverlay::FieldOverlay(const Soil& soil, const OverlayDef& def)
    : soil_(soil), def_(def), field_(soil, def.field, def.low, def.high) {}

/// The value at a voxel; none: no soil, or not in the grid.
std::optional<double> FieldOverlay::value_at(const int voxel[3], VoxelSample& sample) const {
    for (int axis = 0; axis < 3; ++axis) {
        if (voxel[axis] < 0 || voxel[axis] >= soil_.frame().size[axis]) return {};
    }
    sample = soil_.sample(voxel[0], voxel[1], voxel[2]);
    const std::optional<double> value = field_.value(sample);
    if (!value || def_.field != Field::velocity) return value;
    const GroundMotion top = soil_.ground_motion(voxel[0], voxel[1]);
    return std::max({*value, top.slip_m_s, length(top.velocity_m_s)});
}

/// Of the voxels around a place the nearest that has a value.
std::optional<double> FieldOverlay::value_around(Vec3 grid, VoxelSample& sample) const {
    const int middle[3] = {static_cast<int>(std::floor(grid.x)),
                           static_cast<int>(std::floor(grid.y)),
                           static_cast<int>(std::floor(grid.z))};
    std::optional<double> nearest;
    double nearest_away = 0;
    for (int n = 0; n < 27; ++n) {
        const int voxel[3] = {middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1,
                              middle[2] + n / 9 - 1};
        const double away = length(Vec3{voxel[0] + 0.5, voxel[1] + 0.5, voxel[2] + 0.5} - grid);
        if (nearest && away >= nearest_away) continue;
        VoxelSample candidate;
        const std::optional<double> found = value_at(voxel, candidate);
        if (!found) continue;
        nearest = found;
        nearest_away = away;
        sample = candidate;
    }
    return nearest;
}

void FieldOverlay::color(Mesh& mesh) const {
    mesh.weights.clear();
    mesh.palette.clear();
    mesh.wetness.clear();
    const GridFrame& frame = soil_.frame();
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        // Half a voxel inside is the voxel that has the surface; another half where that is bare.
        VoxelSample sample;
        std::optional<double> found;
        const Vec3 at = vertex(mesh.positions, v), normal = vertex(mesh.normals, v);
        for (const double depth : {0.5, 1.0, 1.5}) {
            const Vec3 grid = frame.to_grid(at - normal * (depth * frame.voxel_m));
            const int voxel[3] = {static_cast<int>(std::floor(grid.x)),
                                  static_cast<int>(std::floor(grid.y)),
                                  static_cast<int>(std::floor(grid.z))};
            found = value_at(voxel, sample);
            if (found) break;
        }
        // On the rim of the grid, and at the toe of a heap, which is thinner than what has a value.
        if (!found) found = value_around(frame.to_grid(at), sample);
        if (!found) continue;
        const std::array<float, 3> color = field_.color(*found, sample);
        std::copy(color.begin(), color.end(), &mesh.colors[3 * v]);
    }
}

int FieldOverlay::slice_layer() const {
    const int size = soil_.frame().size[def_.slice_axis];
    return std::clamp(static_cast<int>(def_.slice_at * size), 0, size - 1);
}

Plane FieldOverlay::slice_plane() const {
    const GridFrame& frame = soil_.frame();
    double along[3] = {0, 0, 0};
    along[def_.slice_axis] = 1;
    const Vec3 axis{along[0], along[1], along[2]};
    const Vec3 normal = rotate(frame.grid_to_world.rotation, axis);
    return {normal, dot(normal, frame.to_world((slice_layer() + 0.5) * axis))};
}

Mesh FieldOverlay::slice() const {
    Mesh mesh;
    const GridFrame& frame = soil_.frame();
    const int axis = def_.slice_axis;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int layer = slice_layer();
    const auto corner = [&](int i, int j) {
        double at[3];
        at[axis] = layer + 0.5;
        at[u] = i;
        at[v] = j;
        return frame.to_world({at[0], at[1], at[2]});
    };
    const Vec3 normal = slice_plane().normal;
    const auto add_voxel = [&](int i, int j) {
        int at[3];
        at[axis] = layer;
        at[u] = i;
        at[v] = j;
        const VoxelSample sample = soil_.sample(at[0], at[1], at[2]);
        const std::optional<double> found = field_.value(sample);
        if (!found || (def_.field == Field::coverage && *found <= 0)) return;
        const std::array<float, 3> color = field_.color(*found, sample);
        const auto first = static_cast<uint32_t>(mesh.vertex_count());
        for (const Vec3 p :
             {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)}) {
            for (const double x : {p.x, p.y, p.z}) mesh.positions.push_back(static_cast<float>(x));
            for (const double x : {normal.x, normal.y, normal.z}) {
                mesh.normals.push_back(static_cast<float>(x));
            }
            mesh.colors.insert(mesh.colors.end(), color.begin(), color.end());
        }
        for (const uint32_t c : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + c);
    };
    // Tile by tile: that is how the soil's cache reads. Tiles are as high as the grid.
    constexpr int kTileSide = 8;
    const int step_u = u == 2 ? frame.size[u] : kTileSide;
    const int step_v = v == 2 ? frame.size[v] : kTileSide;
    for (int j0 = 0; j0 < frame.size[v]; j0 += step_v) {
        for (int i0 = 0; i0 < frame.size[u]; i0 += step_u) {
            for (int j = j0; j < std::min(frame.size[v], j0 + step_v); ++j) {
                for (int i = i0; i < std::min(frame.size[u], i0 + step_u); ++i) add_voxel(i, j);
            }
        }
    }
    return mesh;
}

}  // namespace bsoil::viewer
