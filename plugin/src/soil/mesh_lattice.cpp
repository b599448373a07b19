// DistanceLattice::from_mesh.

#include <algorithm>
#include <cmath>

#include "bsoil/limits.h"
#include "device/parallel_ranges.h"
#include "soil/lattice_data.h"
#include "soil/mesh_pieces.h"
#include "soil/mesh_topology.h"
#include "soil/mesh_winding.h"

namespace bsoil {

using namespace layout;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct BrickPiece {
    int64_t brick;
    int32_t piece;
    bool operator<(const BrickPiece& other) const {
        return brick != other.brick ? brick < other.brick : piece < other.piece;
    }
};

/// How far from a piece distances are wanted.
double reach_of(const MeshPiece& piece, const LatticeFrame& frame, double margin_m) {
    return frame.far_m + margin_m +
           std::max({piece.growth_m[0], piece.growth_m[1], piece.growth_m[2]});
}

/// Range of nodes (or, with a step of kLatticeCells, of bricks) that [low, high] covers.
void node_range(double low, double high, double origin, double step, int count, int& first,
                int& last) {
    first = static_cast<int>(std::clamp(std::ceil((low - origin) / step), 0.0, 1.0 * count));
    last = static_cast<int>(std::clamp(std::floor((high - origin) / step), -1.0, count - 1.0));
}

struct Box {
    double low[3], high[3];
};

Box box_of(const Triangle& t, double reach) {
    const Vec3* c = t.corners;
    return {{std::min({c[0].x, c[1].x, c[2].x}) - reach, std::min({c[0].y, c[1].y, c[2].y}) - reach,
             std::min({c[0].z, c[1].z, c[2].z}) - reach},
            {std::max({c[0].x, c[1].x, c[2].x}) + reach, std::max({c[0].y, c[1].y, c[2].y}) + reach,
             std::max({c[0].z, c[1].z, c[2].z}) + reach}};
}

class MeshSampler {
  public:
    MeshSampler(const std::vector<MeshPiece>& pieces, double margin_m, double half_growth_m)
        : pieces_(pieces), margin_m_(margin_m), half_growth_m_(half_growth_m) {}

    /// Bricks with a piece within reach; more than `most` of them are not all found.
    std::vector<int64_t> find_bricks(const LatticeFrame& frame, int64_t most) {
        pairs_.clear();
        std::vector<bool> seen(static_cast<size_t>(frame.brick_count()), false);
        std::vector<int64_t> bricks;
        const double edge = frame.spacing_m * kLatticeCells;
        const double half_diagonal = 0.5 * std::sqrt(3.0) * edge;
        const double origin[3] = {frame.origin.x, frame.origin.y, frame.origin.z};
        for (size_t p = 0; p < pieces_.size(); ++p) {
            const double reach = reach_of(pieces_[p], frame, margin_m_);
            const Box box = box_of(pieces_[p].triangle, reach);
            int first[3], last[3];
            for (int axis = 0; axis < 3; ++axis) {
                // A brick spans an edge from its corner on.
                node_range(box.low[axis] - edge, box.high[axis], origin[axis], edge,
                           frame.bricks[axis], first[axis], last[axis]);
            }
            for (int z = first[2]; z <= last[2]; ++z) {
                for (int y = first[1]; y <= last[1]; ++y) {
                    for (int x = first[0]; x <= last[0]; ++x) {
                        const Vec3 middle = frame.origin + edge * Vec3{x + 0.5, y + 0.5, z + 0.5};
                        const Vec3 nearest =
                            nearest_on_triangle(pieces_[p].triangle, middle).position;
                        if (length(middle - nearest) > reach + half_diagonal) continue;
                        const int64_t b =
                            (static_cast<int64_t>(z) * frame.bricks[1] + y) * frame.bricks[0] + x;
                        pairs_.push_back({b, static_cast<int32_t>(p)});
                        if (!seen[static_cast<size_t>(b)]) {
                            seen[static_cast<size_t>(b)] = true;
                            bricks.push_back(b);
                        }
                    }
                }
            }
            if (std::ssize(bricks) > most) break;
        }
        std::sort(bricks.begin(), bricks.end());
        return bricks;
    }

    std::vector<lattice::Brick> sample(const LatticeFrame& frame,
                                       const std::vector<int64_t>& bricks,
                                       const WindingLines& winding) {
        std::sort(pairs_.begin(), pairs_.end());
        std::vector<size_t> first;
        for (size_t i = 0; i < pairs_.size(); ++i) {
            if (i == 0 || pairs_[i].brick != pairs_[i - 1].brick) first.push_back(i);
        }
        first.push_back(pairs_.size());
        std::vector<lattice::Brick> out(bricks.size());
        device::parallel_ranges(bricks.size(), [&](size_t from, size_t to) {
            for (size_t b = from; b != to; ++b) {
                sample_brick(frame, bricks[b], first[b], first[b + 1], winding, out[b]);
            }
        });
        return out;
    }

  private:
    void sample_brick(const LatticeFrame& frame, int64_t brick, size_t first, size_t last,
                      const WindingLines& winding, lattice::Brick& out) const {
        const int corner[3] = {
            static_cast<int>(brick % frame.bricks[0]) * kLatticeCells,
            static_cast<int>(brick / frame.bricks[0] % frame.bricks[1]) * kLatticeCells,
            static_cast<int>(brick / frame.bricks[0] / frame.bricks[1]) * kLatticeCells};
        const Vec3 at = frame.node(corner[0], corner[1], corner[2]);
        const double origin[3] = {at.x, at.y, at.z};
        std::array<int, 512> votes{};
        winding.count_inside(corner[0], corner[1], corner[2], votes);
        lattice::Brick solid, grown;
        solid.fill(kInfinity);
        grown.fill(kInfinity);
        for (size_t i = first; i < last; ++i) {
            const MeshPiece& piece = pieces_[static_cast<size_t>(pairs_[i].piece)];
            const double reach = reach_of(piece, frame, margin_m_);
            const Box box = box_of(piece.triangle, reach);
            int low[3], high[3];
            for (int axis = 0; axis < 3; ++axis) {
                node_range(box.low[axis], box.high[axis], origin[axis], frame.spacing_m, 8,
                           low[axis], high[axis]);
            }
            for (int z = low[2]; z <= high[2]; ++z) {
                for (int y = low[1]; y <= high[1]; ++y) {
                    for (int x = low[0]; x <= high[0]; ++x) {
                        const Vec3 p = at + frame.spacing_m * Vec3{1.0 * x, 1.0 * y, 1.0 * z};
                        const double above =
                            std::abs(dot(piece.normal, p - piece.triangle.corners[0]));
                        const size_t n = static_cast<size_t>((z * 8 + y) * 8 + x);
                        if (above > reach) continue;
                        const PieceDistance d =
                            piece_distance(piece, p, votes[n] >= 2, half_growth_m_);
                        if (piece.is_solid) solid[n] = std::min(solid[n], d.to_triangle_m);
                        grown[n] = std::min(grown[n], d.to_grown_m);
                    }
                }
            }
        }
        for (size_t n = 0; n < out.size(); ++n) {
            const double core = votes[n] >= 2 ? -solid[n] : solid[n];
            out[n] = std::min(core, grown[n]) - margin_m_;
        }
    }

    const std::vector<MeshPiece>& pieces_;
    double margin_m_ = 0, half_growth_m_ = 0;
    std::vector<BrickPiece> pairs_;
};

/// Box around what the pieces make solid, within the region. Where they leave a region inside of a
/// solid free, that is solid too.
Aabb bounds_of(const MeshTopology& mesh, const LatticeDef& def, double half_growth_m) {
    Aabb box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (const MeshTopology::Part& part : mesh.parts) {
        box.min = {std::min(box.min.x, part.box.min.x), std::min(box.min.y, part.box.min.y),
                   std::min(box.min.z, part.box.min.z)};
        box.max = {std::max(box.max.x, part.box.max.x), std::max(box.max.y, part.box.max.y),
                   std::max(box.max.z, part.box.max.z)};
    }
    const double more = def.margin_m + half_growth_m;
    const Aabb& region = def.region;
    return {{std::max(box.min.x - more, region.min.x), std::max(box.min.y - more, region.min.y),
             std::max(box.min.z - more, region.min.z)},
            {std::min(box.max.x + more, region.max.x), std::min(box.max.y + more, region.max.y),
             std::min(box.max.z + more, region.max.z)}};
}

}  // namespace

DistanceLattice::LatticeResult DistanceLattice::from_mesh(const TriangleMesh& mesh,
                                                          const LatticeDef& def) {
    if (const Status valid = lattice::validate(def); !valid) return Error{valid.error()};
    Result<MeshTopology> topology = mesh_topology(mesh);
    if (!topology) return Error{topology.error()};
    const double wall_m = limits::kThinnestWallVoxels * def.voxel_m;
    if (const TriangleMesh closed = with_gaps_closed(*topology, wall_m);
        closed.triangles.size() > topology->faces.size()) {
        topology = mesh_topology(closed);
    }
    const double half_growth = std::max(0.0, 0.5 * wall_m - def.margin_m);
    auto data = std::make_unique<Data>();
    data->def = def;
    data->bounds = bounds_of(*topology, def, half_growth);
    if (data->bounds.min.x > data->bounds.max.x || data->bounds.min.y > data->bounds.max.y ||
        data->bounds.min.z > data->bounds.max.z) {
        return Error{"nothing of it lies in the region; move it, or ignore the body"};
    }
    Result<std::vector<MeshPiece>> pieces = mesh_pieces(*topology, def, half_growth);
    if (!pieces) return Error{pieces.error()};
    data->pieces = std::move(*pieces);
    MeshSampler sampler(data->pieces, def.margin_m, half_growth);
    std::vector<int64_t> bricks;
    const Result<LatticeFrame> frame = lattice::choose_frame(
        data->bounds, def,
        [&](const LatticeFrame& f, int64_t most) { return sampler.find_bricks(f, most); }, bricks);
    if (!frame) return Error{frame.error()};
    data->frame = *frame;
    const WindingLines winding(*topology, *frame);
    const std::vector<lattice::Brick> distances = sampler.sample(*frame, bricks, winding);
    data->words = lattice::pack(*frame, bricks, distances, [&](int64_t b) {
        return winding.is_inside(
            static_cast<int>(b % frame->bricks[0]) * kLatticeCells,
            static_cast<int>(b / frame->bricks[0] % frame->bricks[1]) * kLatticeCells,
            static_cast<int>(b / frame->bricks[0] / frame->bricks[1]) * kLatticeCells);
    });
    std::vector<Triangle> triangles;
    triangles.reserve(data->pieces.size());
    for (const MeshPiece& piece : data->pieces) triangles.push_back(piece.triangle);
    data->tree = TriangleTree(std::move(triangles));
    data->mesh.vertices = topology->vertices;
    for (const MeshTopology::Face& face : topology->faces) {
        data->mesh.triangles.push_back({face.vertex[0], face.vertex[1], face.vertex[2]});
    }
    return std::shared_ptr<const DistanceLattice>(new DistanceLattice(std::move(data)));
}

}  // namespace bsoil
