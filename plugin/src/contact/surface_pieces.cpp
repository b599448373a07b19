#include "contact/surface_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/make_room.h"

namespace bsoil {
namespace {

/// The gradient of a record that a face belongs to is no further off its normal than this cosine:
/// at an edge it points between two faces, in a corner between three. Ours: 78 deg; in a corner of
/// a box it is 55 deg off each face, and coverage errs by some 20 more. Larger: corners lose faces;
/// smaller: faces take gradients that are not theirs.
constexpr double kAgrees = 0.2;
/// A share of a sample below this is none. Ours: for the rounding. Larger: area is left out;
/// smaller: voxels get elements of nothing from faces that end on their border.
constexpr double kSliver = 1e-6;
/// A sample has nothing to do with records further from where the soil sees it. A record answers
/// what is a voxel off, and a sample is half a voxel wide to either side.
constexpr double kReachVoxels = 1.5;
/// Clusters of samples that one thread takes. Ours: a thousand samples, some tenth of a
/// millisecond. Larger: threads wait for the last; smaller: more lists of what goes where.
constexpr size_t kLotClusters = 32;

/// What looks along an axis by less than this is taken off the squares of a normal's parts. Ours:
/// 1.8 deg, of a machine that stands on level ground. Larger: parts go to the voxels along fewer
/// axes; smaller: level soles are looked at along three axes.
constexpr double kHardlyLooks = 1e-3;

/// Cosines of normals that are the same are no less, whatever rounding makes of their sums. Ours,
/// as a matter of cost: far beyond any rounding. Larger: rounding could tell such normals apart;
/// smaller: with a law that asks for as much they are compared in vain.
constexpr double kSurelySame = 1 - 1e-6;

/// The part of a length that lies in one voxel.
struct Cut {
    double middle = 0, share = 1;
};
/// Samples are no longer than a voxel.
struct Cuts {
    std::array<Cut, 2> parts;
    size_t count = 1;
    const Cut* begin() const { return parts.data(); }
    const Cut* end() const { return parts.data() + count; }
};

Cuts cut(double at, double half) {
    const double border = voxel_of(at + 0.5), below = border - (at - half);
    const double share = below / (2 * half);
    if (!(share > kSliver) || !(share < 1 - kSliver)) return {{Cut{at, 1}}, 1};
    return {{Cut{border - below / 2, share}, Cut{border + half - below / 2, 1 - share}}, 2};
}

}  // namespace

void SurfacePieces::gather(std::span<const ContactRecord> records,
                           std::span<const SampledBody> bodies, const GridFrame& frame,
                           double same_cosine, const WorkThreads* threads) {
    voxel_m_ = frame.voxel_m;
    same_cosine_ = same_cosine;
    records_ = records;
    own_lots_.assign(bodies.size(), -1);
    for (Bin& bin : bins_) bin.pieces.clear();
    make_room(heads_, records.size());
    heads_.assign(records.size(), -1);
    const auto is_sampled = [](const SampledBody& body) { return body.surface != nullptr; };
    if (records.empty() || std::ranges::none_of(bodies, is_sampled)) return;
    places_.fill(records, bodies.size(), frame.size, threads);
    make_lots(bodies);
    for_ranges(threads, lot_count_, 1, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            share_out(bodies[static_cast<size_t>(lots_[i].body)], lots_[i]);
        }
    });
    const std::span lots = std::span(lots_).first(lot_count_);
    if (std::ranges::all_of(lots, &Lot::is_whole_body)) return;
    for_ranges(threads, kBins, 1, [&](size_t first, size_t last) {
        for (size_t bin = first; bin < last; ++bin) add_all(bin);
    });
}

void SurfacePieces::make_lots(std::span<const SampledBody> bodies) {
    lot_count_ = 0;
    const auto add_lot = [&](size_t body, size_t first, size_t last, bool is_over_tips) {
        if (lot_count_ == lots_.size()) lots_.emplace_back();
        Lot& lot = lots_[lot_count_++];
        lot.body = static_cast<int>(body);
        lot.first = first;
        lot.last = last;
        lot.is_over_tips = is_over_tips;
        lot.is_whole_body = false;
        lot.parts.clear();
        lot.pieces.clear();
        for (std::vector<Given>& given : lot.given) given.clear();
    };
    for (size_t b = 0; b < bodies.size(); ++b) {
        const SurfaceSamples* surface = bodies[b].surface;
        if (!surface || !places_.has_any(static_cast<int>(b))) continue;
        const size_t count = surface->clusters.size(), before = lot_count_;
        for (size_t first = 0; first < count; first += kLotClusters) {
            add_lot(b, first, std::min(first + kLotClusters, count), false);
        }
        if (!surface->over_tips.empty()) add_lot(b, 0, 0, true);
        if (lot_count_ != before + 1) continue;
        lots_[before].is_whole_body = true;
        own_lots_[b] = static_cast<int>(before);
    }
}

void SurfacePieces::share_out(const SampledBody& body, Lot& lot) {
    const double per_voxel = 1 / voxel_m_;
    Facing facing;
    for (size_t c = lot.first; c < lot.last; ++c) {
        const SampleCluster& cluster = body.surface->clusters[c];
        if (!places_.is_near_box(lot.body, transform(body.to_grid, cluster.center) * per_voxel,
                                 cluster.radius_m * per_voxel + 1 + kReachVoxels)) {
            continue;
        }
        for (size_t i = cluster.first; i < cluster.last; ++i) {
            const SurfaceSample& sample = body.surface->samples[i];
            const Vec3 at = transform(body.to_grid, sample.at);
            if (!places_.is_near_box(lot.body, at * per_voxel,
                                     sample.out_m * per_voxel + kReachVoxels)) {
                continue;
            }
            if (sample.normal != facing.in_body) {
                facing = Facing(sample.normal, body.to_grid);
                lot.facing = static_cast<int>(i);
            }
            share_sample(sample, at, facing, lot);
            if (lot.is_whole_body) add_given(lot);
        }
    }
    if (!lot.is_over_tips) return;
    const int sample_count = static_cast<int>(body.surface->samples.size());
    for (const OverTips& sample : body.surface->over_tips) {
        const Vec3 tip = transform(body.to_grid, sample.tip);
        const double high = length(sample.tip - sample.root) * per_voxel;
        if (places_.is_near_box(lot.body, tip * per_voxel, high + kReachVoxels)) {
            lot.facing = sample_count + static_cast<int>(&sample - body.surface->over_tips.data());
            share_over_tips(sample, body.to_grid, lot);
            if (lot.is_whole_body) add_given(lot);
        }
    }
}

// Places along two axes go together as those of a square that leans.
SurfacePieces::Facing::Facing(Vec3 sample_normal, const Pose& to_grid)
    : in_body(sample_normal), normal(rotate(to_grid.rotation, sample_normal)) {
    const double n[3] = {normal.x, normal.y, normal.z};
    double level[3], weight = 0;
    for (int k = 0; k < 3; ++k) {
        level[k] = std::max(0.0, 1 - n[k] * n[k]);
        across[k] = std::sqrt(level[k]);
        along[k].weight = std::max(0.0, n[k] * n[k] - kHardlyLooks);
        weight += along[k].weight;
    }
    for (int axis = 0; axis < 3; ++axis) {
        Along& look = along[axis];
        if (!(look.weight > 0)) continue;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        look.weight /= weight;
        look.is_towards = n[axis] > 0;
        look.slope_u = -n[u] / n[axis];
        look.slope_v = -n[v] / n[axis];
        const double both = level[u] * level[v];
        look.turn = both > 0 ? -n[u] * n[v] / std::sqrt(both) : 0;
    }
}

// A part has the variances of its own width along u and v, and no part is higher than the piece.
Vec3 SurfacePieces::Facing::rise(int axis, double wide_u, double wide_v, double half) const {
    const Along& look = along[axis];
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const double variance_u = wide_u * wide_u / 12, variance_v = wide_v * wide_v / 12;
    const double covariance = look.turn * wide_u * wide_v / 12;
    const double up_u = look.slope_u * variance_u + look.slope_v * covariance;
    const double up_v = look.slope_v * variance_v + look.slope_u * covariance;
    double out[3];
    if (axis == 2) {
        out[u] = up_u;
        out[v] = up_v;
        out[2] = look.slope_u * up_u + look.slope_v * up_v;
    } else {
        out[2] = u == 2 ? variance_u : variance_v;
        out[u == 2 ? v : u] = covariance;
        out[axis] = u == 2 ? up_u : up_v;
    }
    const double most = half * half / 3;
    const double share = out[2] > most ? most / out[2] : 1;
    return share * Vec3{out[0], out[1], out[2]};
}

// In the corner between two parts of a body their coverage hides the voxels across the face. What
// lies lower says nothing: there the face may be in the air. Those within a voxel share the part,
// by how near they are and how well they agree: no order of the voxels picks one.
bool SurfacePieces::share_around(Vec3 seen, const int voxel[3], Vec3 normal, Lot& lot) const {
    if (!places_.is_in_grid(voxel)) return false;  // beyond the grid there is no soil
    const double at[3] = {seen.x, seen.y, seen.z};
    const double up = at[2] - voxel[2], by_height[2] = {1 - up, up};
    double near[2][3];
    for (int k = 0; k < 2; ++k) {
        const double into = at[k] - voxel[k];
        near[k][0] = 1 - into;
        near[k][1] = 1;
        near[k][2] = into;
    }
    constexpr int kMost = 18;  // voxels in two layers
    int record[kMost], count = 0;
    double share[kMost], sum = 0;
    places_.visit_around(voxel, lot.body, [&](int dx, int dy, int dz, int found) {
        if (!places_.looks_along(found, normal)) return;
        const double agrees = std::max(0.0, places_.cosine(found, normal) - kAgrees);
        record[count] = found;
        share[count] = near[0][dx] * near[1][dy] * by_height[dz] * agrees;
        sum += share[count++];
    });
    if (!(sum > 0)) return false;
    for (int i = 0; i < count; ++i) {
        if (share[i] > kSliver * sum) lot.give(record[i], share[i] / sum);
    }
    return true;
}

// Along each axis goes what of the area looks that way, as in the coverage's gradient; across it
// the sample is as wide as it is, so that no rounding picks a voxel for all of it.
void SurfacePieces::share_sample(const SurfaceSample& sample, Vec3 at_m, const Facing& facing,
                                 Lot& lot) const {
    const Vec3 seen = (at_m + sample.out_m * facing.normal) * (1 / voxel_m_);
    const double half = std::sqrt(sample.area_m2) / voxel_m_ / 2;
    const double at[3] = {seen.x, seen.y, seen.z};
    double halves[3];
    int low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        halves[k] = half * facing.across[k];
        low[k] = voxel_of(at[k] - halves[k]);
        high[k] = voxel_of(at[k] + halves[k]);
    }
    if (!places_.may_be_beside(lot.body, low, high)) return;
    const Cuts cuts[3] = {cut(at[0], halves[0]), cut(at[1], halves[1]), cut(at[2], halves[2])};
    for (int axis = 0; axis < 3; ++axis) {
        const Facing::Along& look = facing.along[axis];
        if (!(look.weight > 0)) continue;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto share = [&](const Cut& cut_u, const Cut& cut_v) {
            const double off_u = cut_u.middle - at[u], off_v = cut_v.middle - at[v];
            // Of a piece that leans along both, a part's middle may lie off it.
            const double off = std::clamp(look.slope_u * off_u + look.slope_v * off_v,
                                          -halves[axis], halves[axis]);
            double place[3];
            place[u] = cut_u.middle;
            place[v] = cut_v.middle;
            place[axis] = at[axis] + off;
            const int voxel[3] = {voxel_of(place[0]), voxel_of(place[1]), voxel_of(place[2])};
            const Vec3 part_seen{place[0], place[1], place[2]};
            if (!share_part(sample, axis, part_seen, voxel, facing, lot)) return;
            const Vec3 rise = facing.rise(axis, 2 * halves[u] * cut_u.share,
                                          2 * halves[v] * cut_v.share, halves[2]);
            lot.parts.push_back({at_m + voxel_m_ * (part_seen - seen), facing.normal,
                                 look.weight * cut_u.share * cut_v.share * sample.area_m2,
                                 voxel_m_ * voxel_m_ * rise, sample.row, lot.facing, sample.part});
        };
        for (const Cut& cut_v : cuts[v]) {
            for (const Cut& cut_u : cuts[u]) share(cut_u, cut_v);
        }
    }
}

bool SurfacePieces::share_part(const SurfaceSample& sample, int axis, Vec3 seen, const int voxel[3],
                               const Facing& facing, Lot& lot) const {
    const int outwards = facing.along[axis].is_towards ? 1 : -1;
    int record[3];
    if (!places_.find_along(voxel, axis, outwards, lot.body, record)) return false;
    const double at[3] = {seen.x, seen.y, seen.z};
    const double into = at[axis] - voxel[axis];
    const double through = outwards > 0 ? into : 1 - into;
    const double shares[3] = {(1 - through) / 2, 0.5, through / 2};
    double sum = 0;
    for (int step = 0; step < 3; ++step) {
        if (record[step] < 0) continue;
        if (places_.cosine(record[step], facing.normal) < kAgrees) {
            // Beside a lug the gradient may be all of what carries the lug.
            if (!sample.is_thin || step == 0) record[step] = -1;
        }
        if (!(shares[step] > kSliver)) record[step] = -1;  // the face lies on the voxel's border
        if (record[step] >= 0) sum += shares[step];
    }
    if (!(sum > 0)) return share_around(seen, voxel, facing.normal, lot);
    for (int step = 0; step < 3; ++step) {
        if (record[step] >= 0) lot.give(record[step], shares[step] / sum);
    }
    return true;
}

// What soil is there the body's own surface near it knows: the voxel that the piece is in, or those
// on the way down to the root, or that of the nearest tip.
void SurfacePieces::share_over_tips(const OverTips& sample, const Pose& to_grid, Lot& lot) const {
    const Vec3 at = transform(to_grid, sample.piece.at) * (1 / voxel_m_);
    const Vec3 down = transform(to_grid, sample.root) * (1 / voxel_m_) - at;
    const int steps = 1 + static_cast<int>(std::ceil(length(down)));
    const auto record_at = [&](Vec3 p) {
        const int voxel[3] = {static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)),
                              static_cast<int>(std::floor(p.z))};
        return places_.find(voxel, lot.body);
    };
    int record = -1;
    for (int i = 0; i <= steps && record < 0; ++i) {
        record = record_at(at + (static_cast<double>(i) / steps) * down);
    }
    if (record < 0) record = record_at(transform(to_grid, sample.tip) * (1 / voxel_m_));
    if (record < 0) return;
    lot.give(record, 1);
    lot.parts.push_back({transform(to_grid, sample.piece.at),
                         rotate(to_grid.rotation, sample.piece.normal),
                         sample.piece.area_m2,
                         {},
                         sample.piece.row,
                         lot.facing,
                         sample.piece.part});
}

// Lots in their order: sums do not depend on which thread found them.
void SurfacePieces::add_all(size_t bin) {
    for (const Lot& lot : std::span(lots_).first(lot_count_)) {
        for (const Given& given : lot.given[bin]) {
            add(given, lot.parts[static_cast<size_t>(given.part)], bins_[bin].pieces);
        }
    }
}

void SurfacePieces::add_given(Lot& lot) {
    for (const Given& given : lot.given[0]) {
        add(given, lot.parts[static_cast<size_t>(given.part)], lot.pieces);
    }
    lot.given[0].clear();
    lot.parts.clear();
}

void SurfacePieces::add(const Given& given, const Part& part, std::vector<SurfacePiece>& pieces) {
    const double area_m2 = given.share * part.area_m2;
    const auto add_to = [&](SurfacePiece& piece) {
        const Vec3 off = part.at_m - piece.origin;
        piece.area += area_m2 * part.normal;
        piece.moment += area_m2 * part.at_m;
        piece.spread += area_m2 * (part.rise_m2 + off.z * off);
        piece.area_m2 += area_m2;
    };
    int* link = &heads_[static_cast<size_t>(given.record)];
    while (*link >= 0) {
        SurfacePiece& piece = pieces[static_cast<size_t>(*link)];
        const bool is_same = piece.row == part.row && piece.part == part.part &&
                             ((piece.facing == part.facing && same_cosine_ < kSurelySame) ||
                              dot(piece.area, part.normal) >= same_cosine_ * length(piece.area));
        if (is_same) {
            if (piece.facing != part.facing) piece.facing = -1;
            add_to(piece);
            return;
        }
        link = &piece.next;
    }
    // The link may lie in a piece, and pieces may move as they get more.
    *link = static_cast<int>(pieces.size());
    SurfacePiece& piece = pieces.emplace_back();
    piece.origin = part.at_m;
    piece.row = part.row;
    piece.facing = part.facing;
    piece.part = part.part;
    add_to(piece);
}

}  // namespace bsoil
