#include "convex_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>

namespace bsoil::scene {
namespace {

/// Vertices closer than this share of the mesh's size are one, and lie in a plane.
constexpr double kWeld = 1e-6;
/// A piece whose hull holds no more than this above its own volume is convex enough.
constexpr double kExcessFraction = 0.03;
/// A piece smaller than this share of all of them is a splinter of a cut, and left out.
constexpr double kSplinterFraction = 1e-4;
/// A cut has to be better by this share of the hull than one tried before it. Bullet lays the
/// points of a hull on a grid of 1/10216 of its size: below that, rounding would choose among equal
/// cuts.
constexpr double kTieFraction = 1e-4;
/// The planes tried for a cut: those of the largest faces, and evenly spaced ones along each axis.
constexpr size_t kFacePlanes = 10;
constexpr int kAxisPlanes = 3;

struct Face {
    std::array<int, 3> v;
    bool cap;  ///< closes a cut; its signed fan need not lie inside the piece
};

/// A closed piece of the mesh. Volumes are signed sums, so caps may overlap.
struct Piece {
    std::vector<Face> faces;
    double volume_m3 = 0;
    ConvexHull hull;
    double excess_m3() const { return std::max(0.0, hull.volume_m3 - volume_m3); }
};

struct Bounds {
    Vec3 low, high;
};

Bounds bounds_of(const std::vector<Vec3>& points) {
    Bounds b{points.front(), points.front()};
    for (const Vec3 p : points) {
        b.low = {std::min(b.low.x, p.x), std::min(b.low.y, p.y), std::min(b.low.z, p.z)};
        b.high = {std::max(b.high.x, p.x), std::max(b.high.y, p.y), std::max(b.high.z, p.z)};
    }
    return b;
}

/// The vertices of a mesh and of all cuts through it.
class Cutter {
  public:
    explicit Cutter(const TriangleMesh& mesh) {
        const Bounds bounds = bounds_of(mesh.vertices);
        grain_m_ = std::max(1e-12, kWeld * length(bounds.high - bounds.low));
        std::map<std::tuple<long long, long long, long long>, int> known;
        std::vector<int> index;
        for (const Vec3 p : mesh.vertices) {
            const auto cell = [&](double x) { return std::llround(x / grain_m_); };
            const auto [at, is_new] = known.try_emplace({cell(p.x), cell(p.y), cell(p.z)},
                                                        static_cast<int>(vertices_.size()));
            if (is_new) vertices_.push_back(p);
            index.push_back(at->second);
        }
        for (const auto& [a, b, c] : mesh.triangles) {
            const std::array<int, 3> v{index[static_cast<size_t>(a)], index[static_cast<size_t>(b)],
                                       index[static_cast<size_t>(c)]};
            if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0]) faces_.push_back({v, false});
        }
    }

    std::vector<Piece> components() { return components_of(faces_); }

    /// The pieces on both sides of a plane; empty where it does not part the piece.
    std::vector<Piece> cut(const Piece& piece, const Plane& plane) {
        std::vector<Piece> pieces;
        for (const Plane& side : {plane, Plane{-plane.normal, -plane.offset}}) {
            std::vector<Piece> found = components_of(below(piece.faces, side));
            if (found.empty()) return {};
            std::move(found.begin(), found.end(), std::back_inserter(pieces));
        }
        return pieces;
    }

    /// The planes that may part a piece well.
    std::vector<Plane> planes_for(const Piece& piece) const {
        std::map<std::tuple<long, long, long, long>, std::pair<double, Plane>> by_face;
        for (const Face& face : piece.faces) {
            if (face.cap) continue;
            const Vec3 a = at(face.v[0]);
            const Vec3 normal = cross(at(face.v[1]) - a, at(face.v[2]) - a);
            const double twice_area = length(normal);
            if (twice_area < grain_m_ * grain_m_) continue;
            const Vec3 n = normal * (1 / twice_area);
            const auto key = std::tuple{std::lround(n.x * 20), std::lround(n.y * 20),
                                        std::lround(n.z * 20), std::lround(dot(n, a) * 100)};
            auto& entry = by_face.try_emplace(key, 0.0, Plane{n, dot(n, a)}).first->second;
            entry.first += twice_area;
        }
        std::vector<std::pair<double, Plane>> faces;
        for (const auto& [key, entry] : by_face) faces.push_back(entry);
        std::stable_sort(faces.begin(), faces.end(),
                         [](const auto& a, const auto& b) { return a.first > b.first; });
        std::vector<Plane> planes;
        for (size_t i = 0; i < std::min(faces.size(), kFacePlanes); ++i) {
            planes.push_back(faces[i].second);
        }
        const Bounds box = bounds_of(piece.hull.surface.vertices);
        for (const Vec3 axis : {Vec3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
            for (int i = 1; i <= kAxisPlanes; ++i) {
                planes.push_back(
                    {axis, dot(axis, box.low + (box.high - box.low) * (i / (kAxisPlanes + 1.0)))});
            }
        }
        return planes;
    }

  private:
    Vec3 at(int vertex) const { return vertices_[static_cast<size_t>(vertex)]; }

    /// The part of a closed surface below a plane, closed again.
    std::vector<Face> below(const std::vector<Face>& faces, const Plane& plane) {
        const auto side = [&](int v) {
            const double d = dot(plane.normal, at(v)) - plane.offset;
            return d > grain_m_ ? 1 : d < -grain_m_ ? -1 : 0;
        };
        std::map<std::pair<int, int>, int> cut_at;  // the new vertex of an edge
        std::vector<int> cut_vertices;
        std::vector<Face> kept;
        for (const Face& face : faces) {
            std::array<int, 3> s{side(face.v[0]), side(face.v[1]), side(face.v[2])};
            if (s[0] == 0 && s[1] == 0 && s[2] == 0) {
                const Vec3 a = at(face.v[0]);
                const Vec3 normal = cross(at(face.v[1]) - a, at(face.v[2]) - a);
                if (dot(normal, plane.normal) > 0) kept.push_back(face);
                continue;
            }
            std::array<int, 4> polygon{};
            size_t count = 0;
            for (size_t i = 0; i < 3; ++i) {
                const size_t j = (i + 1) % 3;
                if (s[i] <= 0) polygon[count++] = face.v[i];
                if (s[i] * s[j] < 0) {
                    polygon[count++] = cut_edge(face.v[i], face.v[j], plane, cut_at);
                }
            }
            for (size_t i = 2; i < count; ++i) {
                kept.push_back({{polygon[0], polygon[i - 1], polygon[i]}, face.cap});
            }
        }
        close(kept, plane);
        return kept;
    }

    int cut_edge(int a, int b, const Plane& plane, std::map<std::pair<int, int>, int>& cut_at) {
        if (a > b) std::swap(a, b);  // both faces of an edge get the same point
        const auto [found, is_new] = cut_at.try_emplace({a, b}, static_cast<int>(vertices_.size()));
        if (is_new) {
            const Vec3 p = at(a), q = at(b);
            const double d = dot(plane.normal, p) - plane.offset;
            const double e = dot(plane.normal, q) - plane.offset;
            vertices_.push_back(p + (q - p) * (d / (d - e)));
        }
        return found->second;
    }

    /// Adds a fan over each loop of open edges that lies in the plane.
    void close(std::vector<Face>& faces, const Plane& plane) const {
        std::map<std::pair<int, int>, int> open;  // how often an edge is used more than its reverse
        for (const Face& face : faces) {
            for (size_t i = 0; i < 3; ++i) {
                const int a = face.v[i], b = face.v[(i + 1) % 3];
                if (a < b) {
                    ++open[{a, b}];
                } else {
                    --open[{b, a}];
                }
            }
        }
        const auto in_plane = [&](int v) {
            return std::abs(dot(plane.normal, at(v)) - plane.offset) <= 2 * grain_m_;
        };
        std::multimap<int, int> next;  // of the cap: the other way round
        for (const auto& [edge, count] : open) {
            const auto [a, b] = edge;
            if (count == 0 || !in_plane(a) || !in_plane(b)) continue;
            for (int i = 0; i < std::abs(count); ++i) {
                count > 0 ? next.emplace(b, a) : next.emplace(a, b);
            }
        }
        while (!next.empty()) {
            const int first = next.begin()->first;
            int a = next.begin()->second;
            next.erase(next.begin());
            while (a != first) {
                const auto edge = next.find(a);
                if (edge == next.end()) break;  // a hole of the mesh
                const int b = edge->second;
                next.erase(edge);
                if (b != first) faces.push_back({{first, a, b}, true});
                a = b;
            }
        }
    }

    std::vector<Piece> components_of(const std::vector<Face>& faces) const {
        std::map<int, int> parent;
        for (const Face& face : faces) {
            for (const int v : face.v) parent.try_emplace(v, v);
        }
        const auto root = [&](int v) {
            while (parent[v] != v) v = parent[v] = parent[parent[v]];
            return v;
        };
        for (const Face& face : faces) {
            parent[root(face.v[1])] = root(face.v[0]);
            parent[root(face.v[2])] = root(face.v[0]);
        }
        std::map<int, Piece> by_root;
        for (const Face& face : faces) by_root[root(face.v[0])].faces.push_back(face);
        std::vector<Piece> pieces;
        for (auto& [vertex, piece] : by_root) {
            std::vector<Vec3> points;
            const Vec3 origin = at(piece.faces.front().v[0]);
            for (const Face& face : piece.faces) {
                const Vec3 a = at(face.v[0]) - origin, b = at(face.v[1]) - origin,
                           c = at(face.v[2]) - origin;
                piece.volume_m3 += dot(a, cross(b, c)) / 6;
                if (!face.cap) {
                    for (const int v : face.v) points.push_back(at(v));
                }
            }
            piece.hull = convex_hull(points);
            if (piece.hull.volume_m3 > 0) pieces.push_back(std::move(piece));
        }
        return pieces;
    }

    double grain_m_ = 0;
    std::vector<Vec3> vertices_;
    std::vector<Face> faces_;
};

bool lies_inside(const std::vector<Vec3>& points, const TriangleMesh& convex) {
    return std::all_of(convex.triangles.begin(), convex.triangles.end(), [&](const auto& triangle) {
        const Vec3 a = convex.vertices[static_cast<size_t>(triangle[0])];
        const Vec3 normal = cross(convex.vertices[static_cast<size_t>(triangle[1])] - a,
                                  convex.vertices[static_cast<size_t>(triangle[2])] - a);
        const double slack = 1e-4 * length(normal);  // a tenth of a millimetre
        return std::all_of(points.begin(), points.end(),
                           [&](Vec3 p) { return dot(normal, p - a) <= slack; });
    });
}

/// Largest first, without those inside another.
std::vector<ConvexHull> without_nested(std::vector<ConvexHull> hulls) {
    std::stable_sort(hulls.begin(), hulls.end(), [](const ConvexHull& a, const ConvexHull& b) {
        return a.volume_m3 > b.volume_m3;
    });
    std::vector<ConvexHull> kept;
    for (ConvexHull& hull : hulls) {
        if (std::none_of(kept.begin(), kept.end(), [&](const ConvexHull& larger) {
                return lies_inside(hull.surface.vertices, larger.surface);
            })) {
            kept.push_back(std::move(hull));
        }
    }
    return kept;
}

/// How much more the hulls of some pieces hold than the pieces.
double excess_m3(const std::vector<Piece>& pieces) {
    double sum_m3 = 0;
    for (const Piece& piece : pieces) sum_m3 += piece.excess_m3();
    return sum_m3;
}

}  // namespace

std::vector<ConvexHull> component_hulls(const TriangleMesh& mesh) {
    std::vector<ConvexHull> hulls;
    if (mesh.vertices.empty()) return hulls;
    for (Piece& piece : Cutter(mesh).components()) hulls.push_back(std::move(piece.hull));
    return without_nested(std::move(hulls));
}

std::vector<ConvexHull> convex_parts(const TriangleMesh& mesh, int part_capacity) {
    if (mesh.vertices.empty()) return {};
    Cutter cutter(mesh);
    std::vector<Piece> pieces = cutter.components(), done;
    while (!pieces.empty()) {
        const auto worst = std::max_element(
            pieces.begin(), pieces.end(),
            [](const Piece& a, const Piece& b) { return a.excess_m3() < b.excess_m3(); });
        const Piece piece = std::move(*worst);
        pieces.erase(worst);
        const size_t room =
            static_cast<size_t>(part_capacity) -
            std::min(static_cast<size_t>(part_capacity), pieces.size() + done.size());
        std::vector<Piece> best;
        if (room > 1 && piece.excess_m3() > kExcessFraction * piece.hull.volume_m3) {
            for (const Plane& plane : cutter.planes_for(piece)) {
                std::vector<Piece> parted = cutter.cut(piece, plane);
                if (parted.empty() || parted.size() > room) continue;
                const double least_m3 = kTieFraction * piece.hull.volume_m3;
                if (best.empty() || excess_m3(parted) < excess_m3(best) - least_m3) {
                    best = std::move(parted);
                }
            }
        }
        if (best.empty()) {
            done.push_back(piece);
        } else {
            std::move(best.begin(), best.end(), std::back_inserter(pieces));
        }
    }
    std::vector<ConvexHull> hulls;
    double total_m3 = 0;
    for (Piece& piece : done) {
        total_m3 += piece.hull.volume_m3;
        hulls.push_back(std::move(piece.hull));
    }
    std::erase_if(hulls, [&](const ConvexHull& hull) {
        return hull.volume_m3 < kSplinterFraction * total_m3;
    });
    return without_nested(std::move(hulls));
}

ConvexHull thickened(const ConvexHull& hull, double thickness_m, Vec3 middle_m) {
    const std::vector<Vec3>& points = hull.surface.vertices;
    double thinnest_m = thickness_m;
    std::optional<Vec3> across;
    for (const auto& [a, b, c] : hull.surface.triangles) {
        const Vec3 origin = points[static_cast<size_t>(a)];
        Vec3 n =
            cross(points[static_cast<size_t>(b)] - origin, points[static_cast<size_t>(c)] - origin);
        if (length(n) < 1e-12) continue;
        n = n * (1 / length(n));
        double low = 0;
        for (const Vec3 p : points) low = std::min(low, dot(n, p - origin));
        if (-low < thinnest_m) {
            thinnest_m = -low;
            across = n;
        }
    }
    if (!across) return hull;
    Vec3 center;
    for (const Vec3 p : points) center += p * (1.0 / static_cast<double>(points.size()));
    const double outward = dot(center - middle_m, *across) < 0 ? -1 : 1;
    std::vector<Vec3> swept = points;
    for (const Vec3 p : points) {
        swept.push_back(p + *across * (outward * (thickness_m - thinnest_m)));
    }
    return convex_hull(swept);
}

double mesh_volume_m3(const TriangleMesh& mesh) {
    double volume_m3 = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        volume_m3 += dot(mesh.vertices[static_cast<size_t>(a)],
                         cross(mesh.vertices[static_cast<size_t>(b)],
                               mesh.vertices[static_cast<size_t>(c)])) /
                     6;
    }
    return volume_m3;
}

}  // namespace bsoil::scene
