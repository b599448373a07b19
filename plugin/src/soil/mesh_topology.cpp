#include "soil/mesh_topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace bsoil {
namespace {

/// Beyond it floats no longer resolve a voxel.
constexpr double kLargest_m = 1e5;
/// The largest share of a part's surface that its gaps may have. A sheet is no part with a gap: its
/// rim surrounds as much area as the sheet has.
constexpr double kGapFraction = 0.1;
/// Twice a face's area is a normal's length only above this share of its longest edge's square.
constexpr double kNoAreaFraction = 1e-12;

struct HalfEdge {
    int low = 0, high = 0;  ///< vertices
    int face = 0, side = 0;
    bool is_forward = true;  ///< from low to high
};

/// Vertices in one place become one, the first.
std::vector<int> merged_vertices(const std::vector<Vec3>& points, std::vector<Vec3>& vertices) {
    std::vector<int> order(points.size()), merged(points.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int i) { return points[static_cast<size_t>(i)]; };
    std::sort(order.begin(), order.end(), [&](int a, int b) {
        const Vec3 p = key(a), q = key(b);
        if (p.x != q.x) return p.x < q.x;
        if (p.y != q.y) return p.y < q.y;
        return p.z != q.z ? p.z < q.z : a < b;
    });
    for (size_t i = 0; i < order.size(); ++i) {
        const Vec3 p = key(order[i]);
        const bool is_new = vertices.empty() || vertices.back().x != p.x ||
                            vertices.back().y != p.y || vertices.back().z != p.z;
        if (is_new) vertices.push_back(p);
        merged[static_cast<size_t>(order[i])] = static_cast<int>(vertices.size()) - 1;
    }
    return merged;
}

std::vector<HalfEdge> sorted_edges(const std::vector<MeshTopology::Face>& faces) {
    std::vector<HalfEdge> edges;
    edges.reserve(3 * faces.size());
    for (size_t f = 0; f < faces.size(); ++f) {
        for (int k = 0; k < 3; ++k) {
            const int from = faces[f].vertex[k], to = faces[f].vertex[(k + 1) % 3];
            edges.push_back(
                {std::min(from, to), std::max(from, to), static_cast<int>(f), k, from < to});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
        if (a.low != b.low) return a.low < b.low;
        if (a.high != b.high) return a.high < b.high;
        return a.face < b.face;
    });
    return edges;
}

/// Calls `visit` with each run of half edges between the same two vertices.
template <typename Visit>
void for_each_edge(const std::vector<HalfEdge>& edges, Visit&& visit) {
    for (size_t first = 0; first < edges.size();) {
        size_t last = first + 1;
        while (last < edges.size() && edges[last].low == edges[first].low &&
               edges[last].high == edges[first].high) {
            ++last;
        }
        visit(first, last);
        first = last;
    }
}

void turn_over(MeshTopology::Face& face) {
    std::swap(face.vertex[1], face.vertex[2]);
    // Edges 0-1, 1-2, 2-0 are now the former 0-2, 2-1, 1-0.
    std::swap(face.across[0], face.across[2]);
    face.normal = -face.normal;
}

/// Position among the parts that each face belongs to, and their number; faces of a part are wound
/// one way afterwards as far as that is possible.
void find_parts(MeshTopology& mesh) {
    std::vector<int> to_visit;
    // Faces at an edge of many belong together, but say nothing of each other's side.
    const std::vector<HalfEdge> edges = sorted_edges(mesh.faces);
    std::vector<std::vector<int>> beside_many(mesh.faces.size());
    for_each_edge(edges, [&](size_t first, size_t last) {
        const size_t count = last - first;
        for (size_t i = first; i < last; ++i) {
            MeshTopology::Face& face = mesh.faces[static_cast<size_t>(edges[i].face)];
            face.across[edges[i].side] = count == 1   ? MeshTopology::kOpenEdge
                                         : count == 2 ? edges[first + last - 1 - i].face
                                                      : MeshTopology::kManyFaces;
            if (count > 2) {
                beside_many[static_cast<size_t>(edges[i].face)].push_back(
                    edges[i == first ? last - 1 : i - 1].face);
            }
        }
    });
    for (MeshTopology::Face& face : mesh.faces) face.part = -1;
    const auto visit = [&](int f, int part) {
        MeshTopology::Face& face = mesh.faces[static_cast<size_t>(f)];
        face.part = part;
        to_visit.push_back(f);
    };
    for (size_t start = 0; start < mesh.faces.size(); ++start) {
        if (mesh.faces[start].part >= 0) continue;
        const int part = static_cast<int>(mesh.parts.size());
        mesh.parts.emplace_back();
        visit(static_cast<int>(start), part);
        while (!to_visit.empty()) {
            const MeshTopology::Face face = mesh.faces[static_cast<size_t>(to_visit.back())];
            const int self = to_visit.back();
            to_visit.pop_back();
            for (int k = 0; k < 3; ++k) {
                if (face.across[k] < 0) continue;
                MeshTopology::Face& other = mesh.faces[static_cast<size_t>(face.across[k])];
                if (other.part >= 0) continue;
                const int from = face.vertex[k], to = face.vertex[(k + 1) % 3];
                for (int j = 0; j < 3; ++j) {
                    if (other.vertex[j] == from && other.vertex[(j + 1) % 3] == to) {
                        turn_over(other);
                        break;
                    }
                }
                visit(face.across[k], part);
            }
            for (int f : beside_many[static_cast<size_t>(self)]) {
                if (mesh.faces[static_cast<size_t>(f)].part < 0) visit(f, part);
            }
        }
    }
}

/// Closed is a part whose edges are passed as often one way as the other.
void find_closed(MeshTopology& mesh) {
    for (MeshTopology::Part& part : mesh.parts) part.is_closed = true;
    const std::vector<HalfEdge> edges = sorted_edges(mesh.faces);
    for_each_edge(edges, [&](size_t first, size_t last) {
        int balance = 0;
        for (size_t i = first; i < last; ++i) balance += edges[i].is_forward ? 1 : -1;
        if (balance != 0) {
            mesh.parts[static_cast<size_t>(mesh.faces[static_cast<size_t>(edges[first].face)].part)]
                .is_closed = false;
        }
    });
}

void measure_parts(MeshTopology& mesh) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    for (MeshTopology::Part& part : mesh.parts) {
        part.box = {{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
    }
    const Vec3 origin = mesh.vertices.front();
    for (const MeshTopology::Face& face : mesh.faces) {
        MeshTopology::Part& part = mesh.parts[static_cast<size_t>(face.part)];
        Vec3 corner[3];
        for (int k = 0; k < 3; ++k) {
            const Vec3 p = mesh.vertices[static_cast<size_t>(face.vertex[k])];
            part.box.min = {std::min(part.box.min.x, p.x), std::min(part.box.min.y, p.y),
                            std::min(part.box.min.z, p.z)};
            part.box.max = {std::max(part.box.max.x, p.x), std::max(part.box.max.y, p.y),
                            std::max(part.box.max.z, p.z)};
            corner[k] = p - origin;
        }
        part.volume_m3 += dot(corner[0], cross(corner[1], corner[2])) / 6;
    }
}

bool holds(const Aabb& outer, const Aabb& inner) {
    return outer.min.x <= inner.min.x && outer.min.y <= inner.min.y && outer.min.z <= inner.min.z &&
           outer.max.x >= inner.max.x && outer.max.y >= inner.max.y && outer.max.z >= inner.max.z;
}

/// A closed part that faces inwards is a cavity if it lies in the box of a larger one that faces
/// outwards; else it is turned over.
void turn_parts_outwards(MeshTopology& mesh) {
    std::vector<size_t> by_size(mesh.parts.size());
    std::iota(by_size.begin(), by_size.end(), size_t{0});
    std::stable_sort(by_size.begin(), by_size.end(), [&](size_t a, size_t b) {
        return std::abs(mesh.parts[a].volume_m3) > std::abs(mesh.parts[b].volume_m3);
    });
    std::vector<bool> turned(mesh.parts.size(), false);
    std::vector<size_t> outward;  // parts larger than the present one
    bool any_turned = false;
    for (const size_t p : by_size) {
        MeshTopology::Part& part = mesh.parts[p];
        if (!part.is_closed) continue;
        if (part.volume_m3 < 0) {
            const bool is_cavity = std::any_of(outward.begin(), outward.end(), [&](size_t outer) {
                return holds(mesh.parts[outer].box, part.box);
            });
            if (is_cavity) continue;
            turned[p] = any_turned = true;
            part.volume_m3 = -part.volume_m3;
        }
        outward.push_back(p);
    }
    for (MeshTopology::Face& face : mesh.faces) {
        if (any_turned && turned[static_cast<size_t>(face.part)]) turn_over(face);
    }
}

/// Loops of vertices around the gaps of each part, in the direction that faces in them would have;
/// none of a part whose gaps are no simple loops.
std::vector<std::vector<std::vector<int>>> gaps_of(const MeshTopology& mesh) {
    struct Way {
        int from = 0, to = 0, part = 0;
    };
    std::vector<Way> ways;
    std::vector<bool> is_simple(mesh.parts.size(), true);
    const std::vector<HalfEdge> edges = sorted_edges(mesh.faces);
    for_each_edge(edges, [&](size_t first, size_t last) {
        int balance = 0;
        for (size_t i = first; i < last; ++i) balance += edges[i].is_forward ? 1 : -1;
        const HalfEdge& edge = edges[first];
        const int part = mesh.faces[static_cast<size_t>(edge.face)].part;
        if (balance == 1) {
            ways.push_back({edge.high, edge.low, part});
        } else if (balance == -1) {
            ways.push_back({edge.low, edge.high, part});
        } else if (balance != 0) {
            is_simple[static_cast<size_t>(part)] = false;
        }
    });
    std::sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) {
        return a.part != b.part ? a.part < b.part : a.from < b.from;
    });
    const auto way_from = [&](int part, int vertex) {
        return static_cast<size_t>(std::partition_point(ways.begin(), ways.end(),
                                                        [&](const Way& w) {
                                                            return w.part != part ? w.part < part
                                                                                  : w.from < vertex;
                                                        }) -
                                   ways.begin());
    };
    std::vector<std::vector<std::vector<int>>> gaps(mesh.parts.size());
    std::vector<bool> was_gone(ways.size(), false);
    for (size_t start = 0; start < ways.size(); ++start) {
        if (was_gone[start]) continue;
        const int part = ways[start].part;
        std::vector<int> loop;
        for (size_t at = start; at < ways.size() && !was_gone[at] && ways[at].part == part;
             at = way_from(part, ways[at].to)) {
            was_gone[at] = true;
            loop.push_back(ways[at].from);
            if (ways[at].to == ways[start].from) {
                gaps[static_cast<size_t>(part)].push_back(std::move(loop));
                loop = {};
                break;
            }
        }
        if (!loop.empty()) is_simple[static_cast<size_t>(part)] = false;
    }
    for (size_t part = 0; part < gaps.size(); ++part) {
        if (!is_simple[part]) gaps[part].clear();
    }
    return gaps;
}

/// Faces from the middle of a gap to its edges.
void add_cap(const std::vector<int>& loop, std::vector<Vec3>& vertices,
             std::vector<std::array<int, 3>>& triangles) {
    Vec3 middle;
    for (const int v : loop) {
        middle += vertices[static_cast<size_t>(v)] * (1.0 / static_cast<double>(loop.size()));
    }
    const int center = static_cast<int>(vertices.size());
    vertices.push_back(middle);
    for (size_t i = 0; i < loop.size(); ++i) {
        triangles.push_back({loop[i], loop[(i + 1) % loop.size()], center});
    }
}

}  // namespace

TriangleMesh with_gaps_closed(const MeshTopology& mesh, double wall_m) {
    TriangleMesh out;
    out.vertices = mesh.vertices;
    std::vector<double> area_m2(mesh.parts.size()), volume_m3(mesh.parts.size());
    const auto measure = [&](const std::array<int, 3>& triangle, size_t part) {
        const auto at = [&](size_t k) {
            return out.vertices[static_cast<size_t>(triangle[k])] - out.vertices.front();
        };
        area_m2[part] += 0.5 * length(cross(at(1) - at(0), at(2) - at(0)));
        volume_m3[part] += dot(at(0), cross(at(1), at(2))) / 6;
    };
    for (const MeshTopology::Face& face : mesh.faces) {
        out.triangles.push_back({face.vertex[0], face.vertex[1], face.vertex[2]});
        measure(out.triangles.back(), static_cast<size_t>(face.part));
    }
    const auto gaps = gaps_of(mesh);
    for (size_t part = 0; part < gaps.size(); ++part) {
        const size_t vertex_count = out.vertices.size(), triangle_count = out.triangles.size();
        const double own_m2 = area_m2[part];
        for (const std::vector<int>& loop : gaps[part]) add_cap(loop, out.vertices, out.triangles);
        for (size_t t = triangle_count; t < out.triangles.size(); ++t) {
            measure(out.triangles[t], part);
        }
        // The mean thickness of plates is twice their volume over all of their surface.
        if (area_m2[part] - own_m2 > kGapFraction * own_m2 ||
            2 * std::abs(volume_m3[part]) >= wall_m * area_m2[part]) {
            out.vertices.resize(vertex_count);
            out.triangles.resize(triangle_count);
        }
    }
    return out;
}

Result<MeshTopology> mesh_topology(const TriangleMesh& mesh) {
    if (mesh.triangles.empty()) {
        return Error{"mesh has no triangles; fill it before the body joins the world"};
    }
    for (size_t v = 0; v < mesh.vertices.size(); ++v) {
        const Vec3 p = mesh.vertices[v];
        if (!is_finite(p) || std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > kLargest_m) {
            return Error{"vertex " + std::to_string(v) + " is (" + std::to_string(p.x) + ", " +
                         std::to_string(p.y) + ", " + std::to_string(p.z) +
                         "), must be finite and within 1e5 m"};
        }
    }
    const int vertex_count = static_cast<int>(mesh.vertices.size());
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (const int index : mesh.triangles[t]) {
            if (index < 0 || index >= vertex_count) {
                return Error{"triangle " + std::to_string(t) + " has vertex index " +
                             std::to_string(index) + ", must be 0 to " +
                             std::to_string(vertex_count - 1)};
            }
        }
    }
    MeshTopology out;
    const std::vector<int> merged = merged_vertices(mesh.vertices, out.vertices);
    bool has_area = false;
    for (const std::array<int, 3>& triangle : mesh.triangles) {
        MeshTopology::Face face;
        for (size_t k = 0; k < 3; ++k) face.vertex[k] = merged[static_cast<size_t>(triangle[k])];
        if (face.vertex[0] == face.vertex[1] || face.vertex[1] == face.vertex[2] ||
            face.vertex[2] == face.vertex[0]) {
            continue;
        }
        const auto at = [&](int k) { return out.vertices[static_cast<size_t>(face.vertex[k])]; };
        const Vec3 a = at(1) - at(0), b = at(2) - at(0);
        const Vec3 area = cross(a, b);
        const double size = length(area);
        if (size > kNoAreaFraction * std::max({dot(a, a), dot(b, b), dot(a - b, a - b)})) {
            face.normal = area * (1 / size);
            has_area = true;
        }
        out.faces.push_back(face);
    }
    if (!has_area) {
        return Error{
            "mesh of " + std::to_string(mesh.triangles.size()) +
            " triangles has no area; its corners coincide or lie in lines, move them apart"};
    }
    find_parts(out);
    find_closed(out);
    measure_parts(out);
    turn_parts_outwards(out);
    return out;
}

}  // namespace bsoil
