#include "soil/mesh_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace bsoil {
namespace {

/// A face longer than this is cut, so that a thin place in a large plate is not overlooked
/// [voxels].
constexpr double kLongestVoxels = 8;
/// Down to this where the thickness differs between its corners [voxels].
constexpr double kShortestVoxels = 2;
/// Growth of two pieces that differs by less than this is the same [voxels].
constexpr double kSameGrowthVoxels = 0.25;
/// Where thickness is looked up: this share of the distance from a corner to the middle. At the
/// edge itself a ray may meet either face.
constexpr double kFromCorner = 0.05;
/// A ray inwards leaves the wall through a face that looks the other way, not one beside it: the
/// angle between the two normals is larger than this (cosine, 107 deg).
constexpr double kOpposedCosine = -0.3;
/// An edge is sharp where the normals of its faces differ by more than this (cosine, 60 deg).
constexpr double kSharpCosine = 0.5;
/// Beyond this angle of a fold (cosine, 80 deg) its gap is taken to have no end.
constexpr double kOpenFoldCosine = 0.17;
/// Where several folds meet the gap is wider than that of each.
constexpr double kFoldSlack = 2;
/// A face in front of which there is solid in part is cut down to this [voxels].
constexpr double kBuriedVoxels = 1;
/// A point is beyond an edge from this share of the growth on.
constexpr double kOnEdge = 1e-6;
/// A face beside a sharp edge is looked at so far from it [voxels].
constexpr double kBesideVoxels = 0.1;
/// Faces farther than this from the region matter to none of its nodes, besides what they grow by
/// [voxels]: the farthest distance kept of the coarsest lattice.
constexpr double kReachVoxels = 4;
/// Farther than any mesh reaches.
constexpr double kAnywhere_m = 1e6;
/// Growth that is none [voxels].
constexpr double kNoGrowthVoxels = 0.05;

double length_of_longest(const Triangle& t, int& longest) {
    double most = -1;
    for (int k = 0; k < 3; ++k) {
        const double size = length(t.corners[(k + 1) % 3] - t.corners[k]);
        if (size > most) {
            most = size;
            longest = k;
        }
    }
    return most;
}

bool apart(const Triangle& t, const Aabb& box, double reach) {
    const Vec3* c = t.corners;
    return std::max({c[0].x, c[1].x, c[2].x}) < box.min.x - reach ||
           std::max({c[0].y, c[1].y, c[2].y}) < box.min.y - reach ||
           std::max({c[0].z, c[1].z, c[2].z}) < box.min.z - reach ||
           std::min({c[0].x, c[1].x, c[2].x}) > box.max.x + reach ||
           std::min({c[0].y, c[1].y, c[2].y}) > box.max.y + reach ||
           std::min({c[0].z, c[1].z, c[2].z}) > box.max.z + reach;
}

bool overlap(const Aabb& a, const Aabb& b) {
    return a.min.x <= b.max.x && a.max.x >= b.min.x && a.min.y <= b.max.y && a.max.y >= b.min.y &&
           a.min.z <= b.max.z && a.max.z >= b.min.z;
}

class Cutter {
  public:
    Cutter(const MeshTopology& mesh, const LatticeDef& def, double half_growth_m)
        : mesh_(mesh),
          def_(def),
          half_growth_m_(half_growth_m),
          reach_m_(half_growth_m + def.margin_m + kReachVoxels * def.voxel_m) {
        std::vector<Triangle> triangles;
        triangles.reserve(mesh.faces.size());
        for (const MeshTopology::Face& face : mesh.faces) triangles.push_back(triangle_of(face));
        tree_ = TriangleTree(std::move(triangles));
        for (size_t a = 0; a < mesh.parts.size() && !may_be_buried_; ++a) {
            for (size_t b = a + 1; b < mesh.parts.size() && !may_be_buried_; ++b) {
                may_be_buried_ = mesh.parts[a].is_closed && mesh.parts[b].is_closed &&
                                 overlap(mesh.parts[a].box, mesh.parts[b].box);
            }
        }
    }

    Result<std::vector<MeshPiece>> cut() {
        for (size_t f = 0; f < mesh_.faces.size() && !is_too_large(); ++f) {
            face_ = static_cast<int>(f);
            const MeshTopology::Face& face = mesh_.faces[f];
            if (length(face.normal) > 0) {
                const int edges[3] = {0, 1, 2};
                is_solid_ = mesh_.parts[static_cast<size_t>(face.part)].is_closed;
                cut(tree_.triangles()[f], edges);
            }
        }
        if (is_too_large()) {
            return Error{"it has more surface than a lattice of 64 MiB holds at voxels of " +
                         std::to_string(def_.voxel_m) + " m; cut it into parts"};
        }
        return std::move(pieces_);
    }

  private:
    bool is_too_large() const { return pieces_.size() > mesh_.faces.size() + kMorePieces; }

    Triangle triangle_of(const MeshTopology::Face& face) const {
        return {{mesh_.vertices[static_cast<size_t>(face.vertex[0])],
                 mesh_.vertices[static_cast<size_t>(face.vertex[1])],
                 mesh_.vertices[static_cast<size_t>(face.vertex[2])]}};
    }

    /// By how much the wall behind a point of a closed part's face is to be thickened on this side.
    double growth_at(Vec3 point, int face) {
        const Vec3 inward = -mesh_.faces[static_cast<size_t>(face)].normal;
        const double reach = 2 * half_growth_m_;
        if (reach <= 0) return 0;
        hits_.clear();
        tree_.cast(point, inward, reach, hits_);
        std::sort(hits_.begin(), hits_.end(), [](const auto& a, const auto& b) {
            return a.along != b.along ? a.along < b.along : a.triangle < b.triangle;
        });
        int depth = 1;  // how many parts the ray is inside of
        for (const TriangleTree::Hit& hit : hits_) {
            const MeshTopology::Face& other = mesh_.faces[static_cast<size_t>(hit.triangle)];
            if (hit.triangle == face || !mesh_.parts[static_cast<size_t>(other.part)].is_closed) {
                continue;
            }
            const double turn = -dot(other.normal, inward);
            if (turn < kOpposedCosine && --depth <= 0) {
                return std::max(0.0, half_growth_m_ - std::max(0.0, hit.along) / 2);
            }
            if (turn > -kOpposedCosine && hit.along > 1e-6 * reach) ++depth;
        }
        return 0;
    }

    /// Whether a point on a closed part's face has solid in front of it.
    bool is_buried(Vec3 point) {
        hits_.clear();
        const Vec3 outward = mesh_.faces[static_cast<size_t>(face_)].normal;
        tree_.cast(point, outward, kAnywhere_m, hits_);
        int winding = 0;
        for (const TriangleTree::Hit& hit : hits_) {
            const MeshTopology::Face& other = mesh_.faces[static_cast<size_t>(hit.triangle)];
            if (hit.triangle == face_ || hit.along < 1e-6 * def_.voxel_m ||
                !mesh_.parts[static_cast<size_t>(other.part)].is_closed) {
                continue;
            }
            winding += dot(other.normal, outward) > 0 ? 1 : -1;
        }
        return winding > 0;
    }

    void cut(const Triangle& t, const int edges[3]) {
        if (apart(t, def_.region, reach_m_) || is_too_large()) return;
        const Vec3 middle = (t.corners[0] + t.corners[1] + t.corners[2]) * (1.0 / 3);
        double growth[3], low = half_growth_m_, high = half_growth_m_;
        for (int k = 0; k < 3; ++k) {
            growth[k] = is_solid_
                            ? growth_at(t.corners[k] + kFromCorner * (middle - t.corners[k]), face_)
                            : half_growth_m_;
        }
        if (is_solid_) {
            const double at_middle = growth_at(middle, face_);
            low = std::min({growth[0], growth[1], growth[2], at_middle});
            high = std::max({growth[0], growth[1], growth[2], at_middle});
        }
        int longest = 0;
        const double size = length_of_longest(t, longest);
        int buried_count = 0;
        if (is_solid_ && may_be_buried_) {
            buried_count = is_buried(middle) ? 1 : 0;
            for (const Vec3 corner : t.corners) {
                buried_count += is_buried(corner + kFromCorner * (middle - corner)) ? 1 : 0;
            }
            if (buried_count == 4 && size <= kLongestVoxels * def_.voxel_m) return;
        }
        const bool differs = high - low > kSameGrowthVoxels * def_.voxel_m;
        if (size > kLongestVoxels * def_.voxel_m ||
            (differs && size > kShortestVoxels * def_.voxel_m) ||
            (buried_count > 0 && size > kBuriedVoxels * def_.voxel_m)) {
            const int a = longest, b = (longest + 1) % 3, c = (longest + 2) % 3;
            const Vec3 half = 0.5 * (t.corners[a] + t.corners[b]);
            const int first[3] = {edges[a], kInnerEdge, edges[c]};
            const int second[3] = {edges[a], edges[b], kInnerEdge};
            cut({{t.corners[a], half, t.corners[c]}}, first);
            cut({{half, t.corners[b], t.corners[c]}}, second);
            return;
        }
        MeshPiece piece;
        piece.triangle = t;
        piece.normal = mesh_.faces[static_cast<size_t>(face_)].normal;
        piece.is_solid = is_solid_;
        for (int k = 0; k < 3; ++k) {
            piece.growth_m[k] = growth[k];
            const Vec3 along = t.corners[(k + 1) % 3] - t.corners[k];
            const Vec3 out = cross(along, piece.normal);
            const double norm = length(out);
            piece.edge_out[k] = norm > 0 ? out * (1 / norm) : Vec3{};
            piece.is_rim[k] = norm > 0 && high > 0 && edges[k] != kInnerEdge &&
                              is_rim(edges[k], 0.5 * (t.corners[(k + 1) % 3] + t.corners[k]));
            piece.fold_slope[k] = edges[k] == kInnerEdge ? 0 : fold_slope(edges[k]);
        }
        pieces_.push_back(piece);
    }

    /// Whether growth ends at an edge of the face: a plate's own rim, or a sharp edge beyond which
    /// the solid is thick.
    bool is_rim(int edge, Vec3 at) {
        const MeshTopology::Face& face = mesh_.faces[static_cast<size_t>(face_)];
        const int across = face.across[edge];
        if (across == MeshTopology::kOpenEdge) return true;
        if (across == MeshTopology::kManyFaces || !is_solid_) return false;
        const MeshTopology::Face& other = mesh_.faces[static_cast<size_t>(across)];
        if (dot(face.normal, other.normal) > kSharpCosine || length(other.normal) == 0) {
            return false;
        }
        const Triangle& t = tree_.triangles()[static_cast<size_t>(across)];
        const Vec3 middle = (t.corners[0] + t.corners[1] + t.corners[2]) * (1.0 / 3);
        const Vec3 way = middle - at;
        const double far = length(way);
        const double share = std::min(0.3, kBesideVoxels * def_.voxel_m / std::max(far, 1e-12));
        return growth_at(at + share * way, across) < kNoGrowthVoxels * def_.voxel_m;
    }

    double fold_slope(int edge) const {
        const MeshTopology::Face& face = mesh_.faces[static_cast<size_t>(face_)];
        constexpr double kNoEnd = std::numeric_limits<double>::infinity();
        if (face.across[edge] < 0) return kNoEnd;
        const Vec3 other = mesh_.faces[static_cast<size_t>(face.across[edge])].normal;
        const double cosine = dot(face.normal, other);
        return cosine < kOpenFoldCosine ? kNoEnd
                                        : kFoldSlack * length(cross(face.normal, other)) / cosine;
    }

    static constexpr int kInnerEdge = -1;
    /// The most pieces that the surface of the largest lattice has at its coarsest.
    static constexpr size_t kMorePieces = 200'000;
    const MeshTopology& mesh_;
    const LatticeDef& def_;
    double half_growth_m_ = 0, reach_m_ = 0;
    TriangleTree tree_;
    bool may_be_buried_ = false;
    bool is_solid_ = true;
    int face_ = 0;
    std::vector<TriangleTree::Hit> hits_;
    std::vector<MeshPiece> pieces_;
};

}  // namespace

Result<std::vector<MeshPiece>> mesh_pieces(const MeshTopology& mesh, const LatticeDef& def,
                                           double half_growth_m) {
    return Cutter(mesh, def, half_growth_m).cut();
}

PieceDistance piece_distance(const MeshPiece& piece, Vec3 p, bool is_inside, double half_growth_m) {
    const TrianglePoint nearest = nearest_on_triangle(piece.triangle, p);
    const Vec3 off = p - nearest.position;
    const double distance = length(off);
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const double growth = nearest.weights[0] * piece.growth_m[0] +
                          nearest.weights[1] * piece.growth_m[1] +
                          nearest.weights[2] * piece.growth_m[2];
    if (growth <= 0) {  // thick, or as thick as its margin makes it
        return {distance, piece.is_solid ? kNone : distance};
    }
    // A rim ends the grown piece with a flat face.
    const double above = std::abs(dot(piece.normal, off));
    double beyond_rim = -kNone;
    Vec3 beside = off;
    for (int k = 0; k < 3; ++k) {
        const double beyond = dot(piece.edge_out[k], p - piece.triangle.corners[k]);
        if (piece.is_rim[k]) {
            beyond_rim = std::max(beyond_rim, beyond);
            if (beyond > 0) beside = beside - dot(beside, piece.edge_out[k]) * piece.edge_out[k];
        } else if (std::isfinite(piece.fold_slope[k]) &&
                   beyond > kOnEdge * growth + piece.fold_slope[k] * above) {
            return {distance, kNone};
        }
    }
    if (is_inside && piece.is_solid) {
        const bool is_above =
            nearest.weights[0] > 0 && nearest.weights[1] > 0 && nearest.weights[2] > 0;
        const bool is_near = distance <= half_growth_m - growth;
        return {distance, is_above && is_near ? std::max(-distance - growth, beyond_rim) : kNone};
    }
    return {distance, std::max(length(beside) - growth, beyond_rim)};
}

}  // namespace bsoil
