/// What tests ask of a mesh.
#pragma once

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "bsoil/surface_mesh.h"

namespace bsoil::test {

inline Vec3 vertex(const Mesh& mesh, size_t v) {
    return {mesh.positions[3 * v], mesh.positions[3 * v + 1], mesh.positions[3 * v + 2]};
}
inline Vec3 normal(const Mesh& mesh, size_t v) {
    return {mesh.normals[3 * v], mesh.normals[3 * v + 1], mesh.normals[3 * v + 2]};
}

/// Edges of which the mesh has one direction more often than the other: none when it is closed.
/// Vertices count as one where `place` puts them together.
template <typename Place>
int open_edge_count(const Mesh& mesh, Place place) {
    struct Corner {
        std::array<float, 3> at;
        int vertex;
    };
    std::vector<Corner> corners(mesh.vertex_count());
    for (size_t v = 0; v < corners.size(); ++v) {
        const float* p = &mesh.positions[3 * v];
        corners[v] = {{place(p[0]), place(p[1]), place(p[2])}, static_cast<int>(v)};
    }
    std::sort(corners.begin(), corners.end(),
              [](const Corner& a, const Corner& b) { return a.at < b.at; });
    std::vector<int> place_of(corners.size());
    for (size_t c = 0, first = 0; c < corners.size(); ++c) {
        if (corners[c].at != corners[first].at) first = c;
        place_of[corners[c].vertex] = static_cast<int>(first);
    }
    struct Edge {
        int low, high, direction;
    };
    std::vector<Edge> edges;
    edges.reserve(mesh.indices.size());
    for (size_t t = 0; t < mesh.triangle_count(); ++t) {
        for (size_t k = 0; k < 3; ++k) {
            const int a = place_of[mesh.indices[3 * t + k]];
            const int b = place_of[mesh.indices[3 * t + (k + 1) % 3]];
            if (a != b) edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
        return std::pair(a.low, a.high) < std::pair(b.low, b.high);
    });
    int open = 0;
    for (size_t e = 0; e < edges.size();) {
        const Edge& first = edges[e];
        int balance = 0;
        for (; e < edges.size() && edges[e].low == first.low && edges[e].high == first.high; ++e) {
            balance += edges[e].direction;
        }
        open += balance != 0;
    }
    return open;
}

/// Vertices count as one where their positions are equal bit for bit.
inline int open_edge_count(const Mesh& mesh) {
    return open_edge_count(mesh, [](float v) { return v; });
}

inline double enclosed_volume(const Mesh& mesh) {
    double six_fold = 0;
    for (size_t t = 0; t < mesh.triangle_count(); ++t) {
        const uint32_t* i = &mesh.indices[3 * t];
        six_fold += dot(vertex(mesh, i[0]), cross(vertex(mesh, i[1]), vertex(mesh, i[2])));
    }
    return six_fold / 6;
}

}  // namespace bsoil::test
