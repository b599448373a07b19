#include "bsoil/distance_lattice.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "soil/lattice_data.h"

namespace bsoil {

using namespace layout;

namespace lattice {
namespace {

/// Spacing of the nodes [voxels]: flat faces are exact at any, edges and curved faces need it fine.
constexpr double kSpacingVoxels = 0.5;
/// A lattice too large is tried with twice the spacing, so often.
constexpr int kCoarserCount = 2;
/// Distances have to be known to a voxel from the surface (voxelize_shapes looks no farther), and
/// at every corner of a cell that it passes through.
constexpr double kFarVoxels = 1.25;
constexpr double kFarSpacings = 1.75;
constexpr double kFarSpareVoxels = 0.25;
constexpr int64_t kWordsMost = (int64_t{64} << 20) / 4;
/// The origin lies off the solid's box by an uneven share of a node, so that faces along the axes
/// do not lie in planes of nodes.
constexpr double kUneven[3] = {0.381966, 0.276393, 0.414214};

}  // namespace

Status validate(const LatticeDef& def) {
    if (!(def.voxel_m >= 0.001 && def.voxel_m <= 1)) {
        return Error{"voxel_m is " + std::to_string(def.voxel_m) + ", must be 0.001 to 1"};
    }
    if (!(def.margin_m >= 0 && def.margin_m <= 1e5)) {
        return Error{"margin_m is " + std::to_string(def.margin_m) + ", must be 0 to 1e5"};
    }
    const Aabb& r = def.region;
    if (!(r.min.x <= r.max.x && r.min.y <= r.max.y && r.min.z <= r.max.z)) {
        return Error{"region must have a size, and be finite"};
    }
    return Done{};
}

Result<LatticeFrame> choose_frame(const Aabb& box, const LatticeDef& def,
                                  const FindBricks& find_bricks, std::vector<int64_t>& bricks) {
    int64_t words = 0;
    for (int coarser = 0; coarser <= kCoarserCount; ++coarser) {
        LatticeFrame frame;
        frame.spacing_m = kSpacingVoxels * def.voxel_m * (1 << coarser);
        frame.far_m = std::max(kFarVoxels * def.voxel_m,
                               kFarSpacings * frame.spacing_m + kFarSpareVoxels * def.voxel_m);
        const double lows[3] = {box.min.x, box.min.y, box.min.z},
                     highs[3] = {box.max.x, box.max.y, box.max.z};
        double origin[3];
        double count = 1;
        const double edge = frame.spacing_m * kLatticeCells;
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = lows[axis] - frame.far_m - kUneven[axis] * frame.spacing_m;
            const double bricks_along =
                std::ceil((highs[axis] + frame.far_m - origin[axis]) / edge);
            count *= bricks_along;
            frame.bricks[axis] = static_cast<int>(std::min(bricks_along, 1e9));
        }
        frame.origin = {origin[0], origin[1], origin[2]};
        if (count > static_cast<double>(kWordsMost)) {
            words = static_cast<int64_t>(std::min(count, 1e15));
            continue;
        }
        const int64_t rest = kWordsMost - kLatticeIndex - frame.brick_count();
        bricks = find_bricks(frame, rest / kLatticeBrickWords);
        words = kLatticeIndex + frame.brick_count() +
                static_cast<int64_t>(bricks.size()) * kLatticeBrickWords;
        if (words <= kWordsMost) return frame;
    }
    return Error{"its lattice would take more than " + std::to_string(words * 4 >> 20) +
                 " MiB at a spacing of " +
                 std::to_string(kSpacingVoxels * def.voxel_m * (1 << kCoarserCount)) +
                 " m; the limit is " + std::to_string(kWordsMost * 4 >> 20) +
                 " MiB. Cut the mesh into parts, or take a coarser soil"};
}

std::vector<int32_t> pack(const LatticeFrame& frame, const std::vector<int64_t>& bricks,
                          const std::vector<Brick>& distances,
                          const std::function<bool(int64_t)>& is_inside) {
    const size_t samples = static_cast<size_t>(kLatticeIndex + frame.brick_count());
    std::vector<int32_t> words(samples + bricks.size() * kLatticeBrickWords);
    for (int axis = 0; axis < 3; ++axis) {
        words[static_cast<size_t>(kLatticeBricks + axis)] = frame.bricks[axis];
    }
    size_t next = 0;
    for (int64_t b = 0; b < frame.brick_count(); ++b) {
        int32_t& entry = words[static_cast<size_t>(kLatticeIndex + b)];
        if (next < bricks.size() && bricks[next] == b) {
            entry = static_cast<int32_t>(samples + next * kLatticeBrickWords);
            ++next;
        } else {
            entry = is_inside(b) ? kLatticeInside : kLatticeOutside;
        }
    }
    const double per_m = kLatticeFar / frame.far_m;
    const auto sample = [&](double distance) {
        return static_cast<uint32_t>(std::lround(
                   std::clamp(distance * per_m, -1.0 * kLatticeFar, 1.0 * kLatticeFar))) &
               0xffffu;
    };
    for (size_t b = 0; b < bricks.size(); ++b) {
        for (size_t w = 0; w < static_cast<size_t>(kLatticeBrickWords); ++w) {
            words[samples + b * kLatticeBrickWords + w] = static_cast<int32_t>(
                sample(distances[b][2 * w]) | sample(distances[b][2 * w + 1]) << 16);
        }
    }
    return words;
}

}  // namespace lattice

DistanceLattice::DistanceLattice(std::unique_ptr<const Data> data) : data_(std::move(data)) {}
DistanceLattice::~DistanceLattice() = default;

DistanceLattice::LatticeResult DistanceLattice::from_distance(
    const std::function<double(Vec3)>& distance_m, const Aabb& bounds, const LatticeDef& def) {
    if (const Status valid = lattice::validate(def); !valid) return Error{valid.error()};
    if (!is_finite(bounds.min) || !is_finite(bounds.max) || bounds.min.x > bounds.max.x ||
        bounds.min.y > bounds.max.y || bounds.min.z > bounds.max.z) {
        return Error{"bounds must have a size, and be finite"};
    }
    auto data = std::make_unique<Data>();
    data->def = def;
    const Vec3 more{def.margin_m, def.margin_m, def.margin_m};
    const Aabb& region = def.region;
    data->bounds = {{std::max(bounds.min.x - more.x, region.min.x),
                     std::max(bounds.min.y - more.y, region.min.y),
                     std::max(bounds.min.z - more.z, region.min.z)},
                    {std::min(bounds.max.x + more.x, region.max.x),
                     std::min(bounds.max.y + more.y, region.max.y),
                     std::min(bounds.max.z + more.z, region.max.z)}};
    if (data->bounds.min.x > data->bounds.max.x || data->bounds.min.y > data->bounds.max.y ||
        data->bounds.min.z > data->bounds.max.z) {
        return Error{"nothing of it lies in the region; move it, or ignore the body"};
    }
    const auto value = [&](Vec3 p) { return distance_m(p) - def.margin_m; };
    const auto corner = [](const LatticeFrame& frame, int64_t brick, int out[3]) {
        out[0] = static_cast<int>(brick % frame.bricks[0]) * kLatticeCells;
        out[1] = static_cast<int>(brick / frame.bricks[0] % frame.bricks[1]) * kLatticeCells;
        out[2] = static_cast<int>(brick / frame.bricks[0] / frame.bricks[1]) * kLatticeCells;
    };
    const auto middle = [&](const LatticeFrame& frame, int64_t brick) {
        int node[3];
        corner(frame, brick, node);
        const double half = 0.5 * kLatticeCells * frame.spacing_m;
        return frame.node(node[0], node[1], node[2]) + Vec3{half, half, half};
    };
    bool is_sound = true;
    const lattice::FindBricks find = [&](const LatticeFrame& frame, int64_t most) {
        std::vector<int64_t> bricks;
        const double reach = frame.far_m + 0.5 * std::sqrt(3.0) * kLatticeCells * frame.spacing_m;
        for (int64_t b = 0; b < frame.brick_count() && std::ssize(bricks) <= most; ++b) {
            const double d = value(middle(frame, b));
            is_sound = is_sound && !std::isnan(d);
            if (std::abs(d) <= reach) bricks.push_back(b);
        }
        return bricks;
    };
    std::vector<int64_t> bricks;
    const Result<LatticeFrame> frame = lattice::choose_frame(data->bounds, def, find, bricks);
    if (!frame) return Error{frame.error()};
    data->frame = *frame;
    std::vector<lattice::Brick> distances(bricks.size());
    for (size_t b = 0; b < bricks.size(); ++b) {
        int node[3];
        corner(*frame, bricks[b], node);
        for (int i = 0; i < 512; ++i) {
            double& d = distances[b][static_cast<size_t>(i)];
            d = value(frame->node(node[0] + i % 8, node[1] + i / 8 % 8, node[2] + i / 64));
            is_sound = is_sound && !std::isnan(d);
        }
    }
    if (!is_sound) {
        return Error{
            "its distance is not a number somewhere; look for a division by zero where it was "
            "made"};
    }
    data->words = lattice::pack(*frame, bricks, distances,
                                [&](int64_t b) { return value(middle(*frame, b)) < 0; });
    return std::shared_ptr<const DistanceLattice>(new DistanceLattice(std::move(data)));
}

double DistanceLattice::distance_m(Vec3 point) const {
    const LatticeFrame& frame = data_->frame;
    const Vec3 at = (point - frame.origin) * (1 / frame.spacing_m);
    const double p[3] = {at.x, at.y, at.z};
    int64_t brick = 0, node = 0;
    constexpr int64_t kStride[3] = {1, 8, 64};
    double t[3];
    for (int axis = 2; axis >= 0; --axis) {
        if (!(p[axis] >= 0 && p[axis] < frame.bricks[axis] * kLatticeCells)) return frame.far_m;
        const int cell = static_cast<int>(p[axis]);
        t[axis] = p[axis] - cell;
        brick = brick * frame.bricks[axis] + cell / kLatticeCells;
        node += kStride[axis] * (cell % kLatticeCells);
    }
    const int32_t samples = data_->words[static_cast<size_t>(kLatticeIndex + brick)];
    if (samples < 0) return samples == kLatticeInside ? -frame.far_m : frame.far_m;
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        int64_t n = node;
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const bool upper = (corner >> axis & 1) != 0;
            n += upper ? kStride[axis] : 0;
            weight *= upper ? t[axis] : 1 - t[axis];
        }
        const int32_t word = data_->words[static_cast<size_t>(samples + n / 2)];
        sum += weight * static_cast<int16_t>(n % 2 == 0 ? word & 0xffff : word >> 16);
    }
    return sum * quantum_m();
}

DistanceLattice::Face DistanceLattice::nearest_face(Vec3 p) const {
    const std::vector<MeshPiece>& pieces = data_->pieces;
    if (pieces.empty()) {
        const double h = spacing_m();
        const Vec3 slope{distance_m(p + Vec3{h, 0, 0}) - distance_m(p - Vec3{h, 0, 0}),
                         distance_m(p + Vec3{0, h, 0}) - distance_m(p - Vec3{0, h, 0}),
                         distance_m(p + Vec3{0, 0, h}) - distance_m(p - Vec3{0, 0, h})};
        const double steep = length(slope);
        return {distance_m(p), steep > 0 ? slope * (1 / steep) : Vec3{0, 0, 1}};
    }
    const auto height = [&](int piece) {
        const MeshPiece& of = pieces[static_cast<size_t>(piece)];
        const double above = dot(of.normal, p - of.triangle.corners[0]);
        return of.is_solid ? above : std::abs(above);
    };
    // Of faces that share the nearest edge the one that the point is highest above: as for a box.
    const TriangleTree::Nearest found =
        data_->tree.nearest(p, [&](int a, int b) { return height(a) > height(b); });
    const MeshPiece& piece = pieces[static_cast<size_t>(found.triangle)];
    const TrianglePoint at = nearest_on_triangle(piece.triangle, p);
    const double growth = at.weights[0] * piece.growth_m[0] + at.weights[1] * piece.growth_m[1] +
                          at.weights[2] * piece.growth_m[2];
    const double above = dot(piece.normal, p - at.position);
    Face face{above, piece.normal};
    if (!piece.is_solid && above < 0) face = {-above, -piece.normal};
    face.distance_m -= growth;
    if (!piece.is_solid) {
        for (int k = 0; k < 3; ++k) {
            const double beyond = dot(piece.edge_out[k], p - piece.triangle.corners[k]);
            if (piece.is_rim[k] && beyond > std::max(0.0, face.distance_m)) {
                face = {beyond, piece.edge_out[k]};
            }
        }
    }
    face.distance_m -= data_->def.margin_m;
    return face;
}

const Aabb& DistanceLattice::bounds() const { return data_->bounds; }
double DistanceLattice::spacing_m() const { return data_->frame.spacing_m; }
double DistanceLattice::far_m() const { return data_->frame.far_m; }
int64_t DistanceLattice::memory_bytes() const { return std::ssize(data_->words) * 4; }
const TriangleMesh& DistanceLattice::mesh() const { return data_->mesh; }
std::span<const int32_t> DistanceLattice::words() const { return data_->words; }
Vec3 DistanceLattice::origin() const { return data_->frame.origin; }
double DistanceLattice::quantum_m() const { return data_->frame.far_m / kLatticeFar; }

}  // namespace bsoil
