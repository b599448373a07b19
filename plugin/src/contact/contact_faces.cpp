#include "bsoil/contact/contact_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace bsoil {
namespace {

constexpr int kWallBinCount = 6;
/// Two unit vectors across `up` that do not depend on the body.
std::array<Vec3, 2> level_axes(Vec3 up) {
    const Vec3 first = std::abs(up.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 a = first - dot(first, up) * up;
    const Vec3 unit = a * (1 / length(a));
    return {unit, cross(up, unit)};
}

struct Cell {
    int64_t x = 0, y = 0;
    int voxel = 0;
    bool operator<(const Cell& o) const { return x != o.x ? x < o.x : y < o.y; }
};

int root_of(std::vector<int>& parent, int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

/// Joins cells that are near each other; returns each cell's root.
std::vector<int> join_cells(const std::vector<Cell>& cells, int gap) {
    std::vector<int> parent(cells.size());
    std::iota(parent.begin(), parent.end(), 0);
    for (int64_t dx = 0; dx <= gap; ++dx) {
        // What is near the next cell begins no earlier than what is near this one.
        size_t first = 0;
        for (size_t i = 0; i < cells.size(); ++i) {
            const Cell low{cells[i].x + dx, cells[i].y - gap, 0};
            while (first < cells.size() && cells[first] < low) ++first;
            for (size_t j = std::max(first, i);
                 j < cells.size() && cells[j].x == low.x && cells[j].y <= cells[i].y + gap; ++j) {
                const int a = root_of(parent, static_cast<int>(i));
                const int b = root_of(parent, static_cast<int>(j));
                parent[std::max(a, b)] = std::min(a, b);
            }
        }
    }
    for (size_t i = 0; i < cells.size(); ++i) parent[i] = root_of(parent, static_cast<int>(i));
    return parent;
}

/// What is summed up of a face.
struct FaceSums {
    double area = 0, a = 0, b = 0, aa = 0, ab = 0, bb = 0;  ///< area and its moments
    double density = 0, density_area = 0;
    double depth_m = 0;
    int count = 0;

    void add(const ContactVoxel& v, const ContactLaw& law, double at_a, double at_b) {
        // What only brushes the soil, like a wheel's rim above its rut, bears nothing.
        const double w = bearing_depth_m(v) > 0 ? v.area_m2 * law.touching_share(v) : 0;
        if (!(w > 0)) return;
        area += w;
        ++count;
        a += w * at_a;
        b += w * at_b;
        aa += w * at_a * at_a;
        ab += w * at_a * at_b;
        bb += w * at_b * at_b;
        depth_m = std::max(depth_m, bearing_depth_m(v));
        if (v.relative_density >= 0) {
            density += w * v.relative_density;
            density_area += w;
        }
    }
    double relative_density() const { return density_area > 0 ? density / density_area : -1; }
    /// Sides of the rectangle with the same second moments, the shorter first.
    std::array<double, 2> sides() const {
        const double ma = a / area, mb = b / area;
        const double vaa = std::max(0.0, aa / area - ma * ma);
        const double vbb = std::max(0.0, bb / area - mb * mb);
        const double vab = ab / area - ma * mb;
        const double middle = (vaa + vbb) / 2;
        const double spread = std::hypot((vaa - vbb) / 2, vab);
        const auto side = [square = area / count](double variance) {
            // n points h apart have the variance (n^2 - 1) h^2 / 12.
            return std::sqrt(12 * std::max(0.0, variance) + square);
        };
        return {side(middle - spread), side(middle + spread)};
    }
};

}  // namespace

int dominant_axis_bin(Vec3 n) {
    const std::array<double, 3> c{n.x, n.y, n.z};
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (std::abs(c[k]) > std::abs(c[axis])) axis = k;
    return 2 * axis + (c[axis] < 0 ? 1 : 0);
}

void find_contact_faces(std::span<const ContactVoxel> voxels, Quat body_to_world,
                        const ContactLaw& law, double element_m, ContactFaces& out) {
    const Vec3 up = law.up();
    out.faces.assign(kWallBinCount, {});
    out.of_voxel.resize(voxels.size());
    const Quat to_body = conjugate(body_to_world);
    const auto [axis_a, axis_b] = level_axes(up);

    std::array<FaceSums, kWallBinCount> walls;
    std::vector<Cell> cells;
    for (size_t i = 0; i < voxels.size(); ++i) {
        const ContactVoxel& v = voxels[i];
        if (-dot(v.normal, up) > kSoleCosine) {
            // Whole voxels apart: rounding does not decide where the grid lies along the axes.
            const Vec3 place = (v.center_m - voxels.front().center_m) * (1 / element_m);
            cells.push_back({std::llround(dot(place, axis_a)), std::llround(dot(place, axis_b)),
                             static_cast<int>(i)});
            continue;
        }
        const int bin = dominant_axis_bin(rotate(to_body, v.normal));
        out.of_voxel[i] = bin;
        // A wall is as wide as it is level: along the up axis and the one across its normal.
        const Vec3 normal = rotate(body_to_world, {bin / 2 == 0 ? 1.0 : 0, bin / 2 == 1 ? 1.0 : 0,
                                                   bin / 2 == 2 ? 1.0 : 0});
        const Vec3 level = cross(up, normal);
        const double size = length(level);
        const Vec3 across = size > 1e-9 ? level * (1 / size) : axis_a;
        walls[bin].add(v, law, dot(v.position_m, across), 0);
    }
    for (int bin = 0; bin < kWallBinCount; ++bin) {
        if (!(walls[bin].area > 0)) continue;
        const double width_m = walls[bin].sides()[1];
        out.faces[bin] = {width_m, width_m, walls[bin].depth_m, walls[bin].relative_density()};
    }

    std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
        return a < b || (!(b < a) && a.voxel < b.voxel);
    });
    const std::vector<int> roots = join_cells(cells, law.def().sole_gap_voxels);
    std::vector<int> face_of(cells.size(), -1);
    std::vector<FaceSums> soles;
    for (size_t i = 0; i < cells.size(); ++i) {
        int& face = face_of[roots[i]];
        if (face < 0) {
            face = static_cast<int>(soles.size());
            soles.emplace_back();
        }
        const ContactVoxel& v = voxels[cells[i].voxel];
        soles[face].add(v, law, dot(v.position_m, axis_a), dot(v.position_m, axis_b));
        out.of_voxel[cells[i].voxel] = kWallBinCount + face;
    }
    for (const FaceSums& sole : soles) {
        const auto [side_m, length_m] = sole.area > 0 ? sole.sides() : std::array{0.0, 0.0};
        // A ring or a frame has less area than the rectangle.
        const double width_m = length_m > 0 ? std::min(side_m, sole.area / length_m) : 0;
        out.faces.push_back({width_m, length_m, sole.depth_m, sole.relative_density()});
    }
}

}  // namespace bsoil
