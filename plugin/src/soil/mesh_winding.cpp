#include "soil/mesh_winding.h"

#include <algorithm>
#include <cmath>

namespace bsoil {
namespace {

/// A face projected along an axis, in nodes of the lattice.
struct FlatFace {
    double u[3], v[3], along[3];
    int vertex[3];
};

/// Which side of the edge from vertex a to b of a face a point is on: 1 or -1, the opposite for the
/// edge from b to a whatever is rounded.
int side_of(const FlatFace& f, int a, int b, double u, double v) {
    const bool swapped = f.vertex[a] > f.vertex[b];
    if (swapped) std::swap(a, b);
    const double area = (f.u[b] - f.u[a]) * (v - f.v[a]) - (f.v[b] - f.v[a]) * (u - f.u[a]);
    return (area >= 0) != swapped ? 1 : -1;
}

/// Where a line crosses the plane of a face, by the areas opposite to its corners.
double crossing(const FlatFace& f, double u, double v) {
    double area[3], sum = 0;
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        area[k] = (f.u[a] - u) * (f.v[b] - v) - (f.v[a] - v) * (f.u[b] - u);
        sum += area[k];
    }
    const double low = std::min({f.along[0], f.along[1], f.along[2]});
    const double high = std::max({f.along[0], f.along[1], f.along[2]});
    const double at =
        sum != 0 ? (area[0] * f.along[0] + area[1] * f.along[1] + area[2] * f.along[2]) / sum : low;
    return std::clamp(at, low, high);
}

/// Calls visit(i, j, at, sign) for each line of nodes that crosses the face.
template <typename Visit>
void for_each_line(const FlatFace& f, int u_count, int v_count, Visit&& visit) {
    const auto range = [](const double* c, int count, int& low, int& high) {
        low =
            static_cast<int>(std::ceil(std::clamp(std::min({c[0], c[1], c[2]}), 0.0, 1.0 * count)));
        high = static_cast<int>(
            std::floor(std::clamp(std::max({c[0], c[1], c[2]}), -1.0, count - 1.0)));
    };
    int u0, u1, v0, v1;
    range(f.u, u_count, u0, u1);
    range(f.v, v_count, v0, v1);
    for (int j = v0; j <= v1; ++j) {
        for (int i = u0; i <= u1; ++i) {
            const int side = side_of(f, 0, 1, i, j);
            if (side == side_of(f, 1, 2, i, j) && side == side_of(f, 2, 0, i, j)) {
                visit(i, j, crossing(f, i, j), side);
            }
        }
    }
}

}  // namespace

WindingLines::WindingLines(const MeshTopology& mesh, const LatticeFrame& frame) {
    std::vector<std::array<double, 3>> points;
    points.reserve(mesh.vertices.size());
    for (const Vec3 p : mesh.vertices) {
        const Vec3 at = (p - frame.origin) * (1 / frame.spacing_m);
        points.push_back({at.x, at.y, at.z});
    }
    for (int axis = 0; axis < 3; ++axis) nodes_[axis] = frame.nodes_along(axis);
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto for_each_crossing = [&](auto&& visit) {
            for (const MeshTopology::Face& face : mesh.faces) {
                if (!mesh.parts[static_cast<size_t>(face.part)].is_closed) continue;
                FlatFace flat;
                for (int k = 0; k < 3; ++k) {
                    const auto& p = points[static_cast<size_t>(face.vertex[k])];
                    flat.u[k] = p[static_cast<size_t>(u)];
                    flat.v[k] = p[static_cast<size_t>(v)];
                    flat.along[k] = p[static_cast<size_t>(axis)];
                    flat.vertex[k] = face.vertex[k];
                }
                for_each_line(flat, nodes_[u], nodes_[v], [&](int i, int j, double at, int sign) {
                    visit(static_cast<size_t>(j) * static_cast<size_t>(nodes_[u]) +
                              static_cast<size_t>(i),
                          Crossing{at, sign});
                });
            }
        };
        std::vector<size_t>& first = first_[axis];
        first.assign(static_cast<size_t>(nodes_[u]) * static_cast<size_t>(nodes_[v]) + 1, 0);
        for_each_crossing([&](size_t line, const Crossing&) { ++first[line + 1]; });
        for (size_t line = 1; line < first.size(); ++line) first[line] += first[line - 1];
        crossings_[axis].resize(first.back());
        std::vector<size_t> next(first.begin(), first.end() - 1);
        for_each_crossing(
            [&](size_t line, const Crossing& c) { crossings_[axis][next[line]++] = c; });
    }
}

size_t WindingLines::line_of(int axis, const int node[3]) const {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    return static_cast<size_t>(node[v]) * static_cast<size_t>(nodes_[u]) +
           static_cast<size_t>(node[u]);
}

int WindingLines::winding(int axis, size_t line, int node) const {
    int sum = 0;
    for (size_t i = first_[axis][line]; i < first_[axis][line + 1]; ++i) {
        sum += crossings_[axis][i].at > node ? crossings_[axis][i].sign : 0;
    }
    return sum;
}

bool WindingLines::is_inside(int x, int y, int z) const {
    const int node[3] = {x, y, z};
    int votes = 0;
    for (int axis = 0; axis < 3; ++axis) {
        votes += winding(axis, line_of(axis, node), node[axis]) > 0 ? 1 : 0;
    }
    return votes >= 2;
}

void WindingLines::count_inside(int x, int y, int z, std::array<int, 512>& votes) const {
    const int corner[3] = {x, y, z};
    constexpr size_t kStride[3] = {1, 8, 64};
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int j = 0; j < 8; ++j) {
            for (int i = 0; i < 8; ++i) {
                int node[3];
                node[axis] = corner[axis];
                node[u] = corner[u] + i;
                node[v] = corner[v] + j;
                const size_t line = line_of(axis, node);
                if (first_[axis][line] == first_[axis][line + 1]) continue;
                const size_t at =
                    static_cast<size_t>(i) * kStride[u] + static_cast<size_t>(j) * kStride[v];
                for (int n = 0; n < 8; ++n) {
                    votes[at + static_cast<size_t>(n) * kStride[axis]] +=
                        winding(axis, line, corner[axis] + n) > 0 ? 1 : 0;
                }
            }
        }
    }
}

}  // namespace bsoil
