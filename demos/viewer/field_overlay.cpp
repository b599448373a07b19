#include "field_overlay.h"

#include <algorithm>
#include <cmath>

namespace bsoil::viewer {
namespace {

constexpr double kBareVolume = 0.02;  ///< of a voxel: less soil than this has no colour

Vec3 vertex(const std::vector<float>& list, size_t v) {
    return {list[3 * v], list[3 * v + 1], list[3 * v + 2]};
}

}  // namespace

const char* field_name(Field field) {
    constexpr const char* kNames[kFieldCount] = {"none",     "density",   "velocity", "force",
                                                 "coverage", "disturbed", "activity", "material"};
    return kNames[static_cast<size_t>(field)];
}

std::array<float, 3> ramp_color(double fraction) {
    // Eight colours of matplotlib's viridis (public domain), as on the screen.
    constexpr double kRamp[8][3] = {
        {0.267, 0.005, 0.329}, {0.275, 0.194, 0.496}, {0.212, 0.359, 0.552}, {0.153, 0.497, 0.558},
        {0.122, 0.632, 0.531}, {0.290, 0.759, 0.428}, {0.622, 0.854, 0.226}, {0.993, 0.906, 0.144}};
    const double at = std::clamp(fraction, 0.0, 1.0) * 7;
    const int i = std::min(6, static_cast<int>(at));
    std::array<float, 3> color{};
    for (size_t c = 0; c < 3; ++c) {
        color[c] = static_cast<float>(
            std::pow(kRamp[i][c] + (at - i) * (kRamp[i + 1][c] - kRamp[i][c]), 2.2));
    }
    return color;
}

FieldOverlay::FieldOverlay(const Soil& soil, const OverlayDef& def) : soil_(soil), def_(def) {
    const auto& materials = soil.materials();
    const auto [lightest, heaviest] = std::minmax_element(
        materials.begin(), materials.end(),
        [](const auto& a, const auto& b) { return a.density_kg_m3 < b.density_kg_m3; });
    switch (def.field) {
        case Field::none:
            break;
        case Field::density:
            bar_ = {"bulk density", "kg/m\u00b3", 0.7 * lightest->density_kg_m3,
                    1.25 * heaviest->density_kg_m3};
            break;
        case Field::velocity:
            bar_ = {"speed", "m/s", 0, 1};
            break;
        case Field::force:
            bar_ = {"pushed by bodies", "", 0, 1};
            break;
        case Field::coverage:
            bar_ = {"covered by bodies", "", 0, 1};
            break;
        case Field::disturbed:
            bar_ = {"has been moved", "", 0, 1};
            break;
        case Field::activity:
            bar_ = {"active", "", 0, 1};
            break;
        case Field::material:
            bar_ = {"material", "", 0,
                    static_cast<double>(std::max<size_t>(1, materials.size() - 1))};
            break;
    }
    if (def.low != 0 || def.high != 0) {
        bar_.low = def.low;
        bar_.high = def.high;
    }
}

std::optional<double> FieldOverlay::value(const VoxelSample& s) const {
    if (def_.field == Field::coverage) return s.coverage + s.body_coverage;
    if (s.volume < kBareVolume) return {};
    switch (def_.field) {
        case Field::density:
            return s.density_kg_m3;
        case Field::velocity:
            return length(s.velocity_m_s);
        case Field::force:
            return length(s.push);
        case Field::disturbed:
            return 1 - s.undisturbed;
        case Field::activity:
            return s.is_active ? 1.0 : 0.0;
        case Field::material:
            return s.material;
        default:
            return {};
    }
}

std::array<float, 3> FieldOverlay::color_of(double value, const VoxelSample& sample) const {
    if (def_.field == Field::material) {
        return soil_.materials()[static_cast<size_t>(sample.material)].color;
    }
    return ramp_color((value - bar_.low) / std::max(1e-12, bar_.high - bar_.low));
}

void FieldOverlay::color(Mesh& mesh) const {
    mesh.weights.clear();
    mesh.palette.clear();
    const GridFrame& frame = soil_.frame();
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        // Half a voxel inside is the voxel that has the surface; another half where that is bare.
        for (const double depth : {0.5, 1.0, 1.5}) {
            const Vec3 at =
                vertex(mesh.positions, v) - vertex(mesh.normals, v) * (depth * frame.voxel_m);
            const Vec3 grid = frame.to_grid(at);
            const VoxelSample sample = soil_.sample(static_cast<int>(std::floor(grid.x)),
                                                    static_cast<int>(std::floor(grid.y)),
                                                    static_cast<int>(std::floor(grid.z)));
            const std::optional<double> found = value(sample);
            if (!found) continue;
            const std::array<float, 3> color = color_of(*found, sample);
            std::copy(color.begin(), color.end(), &mesh.colors[3 * v]);
            break;
        }
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
        const std::optional<double> found = value(sample);
        if (!found || (def_.field == Field::coverage && *found <= 0)) return;
        const std::array<float, 3> color = color_of(*found, sample);
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
