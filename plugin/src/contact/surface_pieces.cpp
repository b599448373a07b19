#include "contact/surface_pieces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

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
/// Clusters of samples that one thread takes. Ours: a thousand samples, some tenth of a
/// millisecond. Larger: threads wait for the last; smaller: more lists of what goes where.
constexpr size_t kLotClusters = 32;
constexpr uint64_t kNoKey = ~uint64_t{0};

/// A record answers parts no more voxels off.
constexpr int kAnswerVoxels = 1;
/// Cells that tell where records are, for each record at most. Ours: a voxel is a cell of what is
/// no larger than a machine. Larger: more memory for a body that few records spread over; smaller:
/// more parts are looked at for nothing.
constexpr size_t kCellsPerRecord = 128;

uint64_t key_of(const int voxel[3], int body) {
    return (static_cast<uint64_t>(body) << 42 ^ static_cast<uint64_t>(voxel[2]) << 28 ^
            static_cast<uint64_t>(voxel[1]) << 14 ^ static_cast<uint64_t>(voxel[0]));
}

size_t scattered(uint64_t key) {
    key *= 0x9e3779b97f4a7c15u;
    return static_cast<size_t>(key >> 24);
}

/// The part of a length that lies in one voxel.
struct Cut {
    double middle = 0, share = 0;
};
/// Samples are shorter than a voxel.
using Cuts = std::array<Cut, 2>;

Cuts cut(double at, double half) {
    const double border = std::floor(at + 0.5), below = border - (at - half);
    const double share = below / (2 * half);
    if (!(share > kSliver) || !(share < 1 - kSliver)) return {Cut{at, 1}};
    return {Cut{border - below / 2, share}, Cut{border + half - below / 2, 1 - share}};
}

/// A flat piece that is looked at along an axis, from above its places along u and v.
struct Slope {
    int axis, u, v;
    const double* n;  ///< its normal

    /// On the piece, over a place from its middle.
    std::array<double, 3> place(double at_u, double at_v) const {
        std::array<double, 3> out{};
        out[u] = at_u;
        out[v] = at_v;
        out[axis] = -(n[u] * at_u + n[v] * at_v) / n[axis];
        return out;
    }
    /// Of a piece that leans along both, a part's middle may lie off it.
    Vec3 bound(std::array<double, 3> at, const double halves[3]) const {
        at[axis] = std::clamp(at[axis], -halves[axis], halves[axis]);
        return {at[0], at[1], at[2]};
    }
    /// SurfacePiece::rise_m2 of a part with these variances of its places; `half`: of the whole
    /// piece's height. Places along u and v go together as those of a square that leans.
    Vec3 rise(double variance_u, double variance_v, double half) const {
        const double level = std::max(0.0, 1 - n[u] * n[u]) * std::max(0.0, 1 - n[v] * n[v]);
        const double covariance =
            level > 0 ? -n[u] * n[v] / std::sqrt(level) * std::sqrt(variance_u * variance_v) : 0;
        const double slope_u = -n[u] / n[axis], slope_v = -n[v] / n[axis];
        std::array<double, 3> out{};
        if (axis == 2) {
            out[u] = slope_u * variance_u + slope_v * covariance;
            out[v] = slope_v * variance_v + slope_u * covariance;
            out[2] = slope_u * out[u] + slope_v * out[v];
        } else {
            out[2] = u == 2 ? variance_u : variance_v;
            out[u == 2 ? v : u] = covariance;
            out[axis] = u == 2 ? slope_u * variance_u + slope_v * covariance
                               : slope_v * variance_v + slope_u * covariance;
        }
        // No part is higher than the piece.
        const double most = half * half / 3;
        const double share = out[2] > most ? most / out[2] : 1;
        return share * Vec3{out[0], out[1], out[2]};
    }
};

double cosine(const ContactRecord& record, Vec3 normal) {
    return -dot(record.gradient, normal) / length(record.gradient);
}

template <typename T>
void make_room(std::vector<T>& v, size_t count) {
    if (v.capacity() < count) v.reserve(2 * count);
}

}  // namespace

void SurfacePieces::gather(std::span<const ContactRecord> records,
                           std::span<const SampledBody> bodies, const GridFrame& frame,
                           double same_cosine, const WorkThreads* threads) {
    voxel_m_ = frame.voxel_m;
    records_ = records;
    std::ranges::copy(frame.size, size_);
    same_cosine_ = same_cosine;
    pieces_.clear();
    make_room(heads_, records.size());
    heads_.assign(records.size(), -1);
    const auto is_sampled = [](const SampledBody& body) { return body.surface != nullptr; };
    if (records.empty() || std::ranges::none_of(bodies, is_sampled)) return;
    make_room(pieces_, 2 * records.size());
    fill_table(records);
    find_boxes(records, bodies.size());
    mark_near(records);
    make_lots(bodies);
    for_ranges(threads, lot_count_, 1, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            share_out(bodies[static_cast<size_t>(lots_[i].body)], lots_[i]);
        }
    });
    // Sums in order, whatever thread found them.
    for (const Lot& lot : std::span(lots_).first(lot_count_)) {
        for (const Given& given : lot.given) add(given);
    }
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
        lot.given.clear();
    };
    for (size_t b = 0; b < bodies.size(); ++b) {
        const SurfaceSamples* surface = bodies[b].surface;
        if (!surface || boxes_[b].high[0] < 0) continue;
        const size_t count = surface->clusters.size();
        for (size_t first = 0; first < count; first += kLotClusters) {
            add_lot(b, first, std::min(first + kLotClusters, count), false);
        }
        if (!surface->over_tips.empty()) add_lot(b, 0, 0, true);
    }
}

void SurfacePieces::share_out(const SampledBody& body, Lot& lot) const {
    const Box& box = boxes_[static_cast<size_t>(lot.body)];
    const double per_voxel = 1 / voxel_m_;
    const auto is_near = [&](Vec3 p, double reach) {
        const double at[3] = {p.x, p.y, p.z};
        for (int k = 0; k < 3; ++k) {
            if (at[k] < box.low[k] - reach || at[k] > box.high[k] + 1 + reach) return false;
        }
        return true;
    };
    for (size_t c = lot.first; c < lot.last; ++c) {
        const SampleCluster& cluster = body.surface->clusters[c];
        if (!is_near(transform(body.to_grid, cluster.center) * per_voxel,
                     cluster.radius_m * per_voxel + 2)) {
            continue;
        }
        for (size_t i = cluster.first; i < cluster.last; ++i) {
            const SurfaceSample& sample = body.surface->samples[i];
            const Vec3 at = transform(body.to_grid, sample.at);
            if (!is_near(at * per_voxel, 1.5)) continue;
            const Vec3 normal = rotate(body.to_grid.rotation, sample.normal);
            share_sample(sample, at, normal, lot);
        }
    }
    if (!lot.is_over_tips) return;
    for (const OverTips& sample : body.surface->over_tips) {
        const Vec3 tip = transform(body.to_grid, sample.tip);
        const double high = length(sample.tip - sample.root) * per_voxel;
        if (is_near(tip * per_voxel, high + 1.5)) share_over_tips(sample, body.to_grid, lot);
    }
}

void SurfacePieces::find_boxes(std::span<const ContactRecord> records, size_t body_count) {
    boxes_.assign(body_count, {});
    for (const ContactRecord& record : records) {
        Box& box = boxes_[static_cast<size_t>(record.body)];
        for (int k = 0; k < 3; ++k) {
            box.low[k] = std::min(box.low[k], record.voxel[k]);
            box.high[k] = std::max(box.high[k], record.voxel[k]);
        }
        ++box.record_count;
    }
}

void SurfacePieces::mark_near(std::span<const ContactRecord> records) {
    size_t cell_count = 0;
    for (Box& box : boxes_) {
        if (box.high[0] < 0) continue;
        box.cells = cell_count;
        size_t own = 0;
        for (box.cell_shift = 0; own == 0 || own > kCellsPerRecord * box.record_count;
             ++box.cell_shift) {
            own = 1;
            for (int k = 0; k < 3; ++k) {
                const int wide = box.high[k] - box.low[k] + 2 * kAnswerVoxels;
                box.cell_count[k] = (wide >> box.cell_shift) + 1;
                own *= static_cast<size_t>(box.cell_count[k]);
            }
        }
        --box.cell_shift;
        cell_count += own;
    }
    near_.assign(cell_count, 0);
    for (const ContactRecord& record : records) {
        const Box& box = boxes_[static_cast<size_t>(record.body)];
        int low[3], high[3];
        for (int k = 0; k < 3; ++k) {
            low[k] = (record.voxel[k] - box.low[k]) >> box.cell_shift;
            high[k] = (record.voxel[k] - box.low[k] + 2 * kAnswerVoxels) >> box.cell_shift;
        }
        for (int z = low[2]; z <= high[2]; ++z) {
            for (int y = low[1]; y <= high[1]; ++y) {
                std::fill_n(&near_[box.cell(low[0], y, z)], high[0] - low[0] + 1, uint8_t{1});
            }
        }
    }
}

bool SurfacePieces::may_have_record(const Box& box, Vec3 seen) const {
    const double place[3] = {seen.x, seen.y, seen.z};
    int at[3];
    for (int k = 0; k < 3; ++k) {
        const int voxel = static_cast<int>(std::floor(place[k])) - box.low[k] + kAnswerVoxels;
        at[k] = voxel >> box.cell_shift;
        if (voxel < 0 || at[k] >= box.cell_count[k]) return false;
    }
    return near_[box.cell(at[0], at[1], at[2])] != 0;
}

void SurfacePieces::fill_table(std::span<const ContactRecord> records) {
    const size_t size = std::bit_ceil(2 * records.size());
    make_room(keys_, size);
    make_room(found_, size);
    keys_.assign(size, kNoKey);
    found_.assign(size, -1);
    for (size_t i = 0; i < records.size(); ++i) {
        const uint64_t key = key_of(records[i].voxel, records[i].body);
        size_t at = scattered(key) & (size - 1);
        while (keys_[at] != kNoKey) at = (at + 1) & (size - 1);
        keys_[at] = key;
        found_[at] = static_cast<int>(i);
    }
}

int SurfacePieces::find(const int voxel[3], int body) const {
    for (int k = 0; k < 3; ++k) {
        if (voxel[k] < 0 || voxel[k] >= size_[k]) return -1;
    }
    const uint64_t key = key_of(voxel, body);
    size_t at = scattered(key) & (keys_.size() - 1);
    while (keys_[at] != kNoKey && keys_[at] != key) at = (at + 1) & (keys_.size() - 1);
    return keys_[at] == key ? found_[at] : -1;
}

// In the corner between two parts of a body their coverage hides the voxels across the face. What
// lies lower says nothing: there the face may be in the air. Those within a voxel share the part,
// by how near they are and how well they agree: no order of the voxels picks one.
void SurfacePieces::share_around(const SurfaceSample& sample, const Part& part, Lot& lot) const {
    const double at[3] = {part.seen.x, part.seen.y, part.seen.z};
    int voxel[3];
    double near[3][3];
    for (int k = 0; k < 3; ++k) {
        voxel[k] = static_cast<int>(std::floor(at[k]));
        if (voxel[k] < 0 || voxel[k] >= size_[k]) return;  // beyond the grid there is no soil
        const double into = at[k] - voxel[k];
        near[k][0] = k < 2 ? 1 - into : 0;
        near[k][1] = k < 2 ? 1 : 1 - into;
        near[k][2] = into;
    }
    constexpr int kAround = 27;  ///< voxels round one, and that one
    int record[kAround] = {};
    double share[kAround] = {};
    double sum = 0;
    for (int i = 0; i < kAround; ++i) {
        const int step[3] = {i % 3, i / 3 % 3, i / 9};
        share[i] = near[0][step[0]] * near[1][step[1]] * near[2][step[2]];
        if (!(share[i] > 0)) continue;
        const int beside[3] = {voxel[0] + step[0] - 1, voxel[1] + step[1] - 1,
                               voxel[2] + step[2] - 1};
        record[i] = find(beside, lot.body);
        const double agrees =
            record[i] < 0 ? 0 : cosine(records_[static_cast<size_t>(record[i])], part.normal);
        share[i] *= std::max(0.0, agrees - kAgrees);
        sum += share[i];
    }
    if (!(sum > 0)) return;
    for (int i = 0; i < kAround; ++i) {
        if (share[i] > kSliver * sum) {
            lot.given.push_back({record[i], &sample, part, share[i] / sum});
        }
    }
}

// Along each axis goes what of the area looks that way, as in the coverage's gradient; across it
// the sample is as wide as it is, so that no rounding picks a voxel for all of it.
void SurfacePieces::share_sample(const SurfaceSample& sample, Vec3 at_m, Vec3 normal,
                                 Lot& lot) const {
    const Box& box = boxes_[static_cast<size_t>(lot.body)];
    const Vec3 seen = (at_m + sample.out_m * normal) * (1 / voxel_m_);
    const double at[3] = {seen.x, seen.y, seen.z}, n[3] = {normal.x, normal.y, normal.z};
    const double half = std::sqrt(sample.area_m2) / voxel_m_ / 2;
    double halves[3];
    Cuts cuts[3];
    for (int k = 0; k < 3; ++k) {
        halves[k] = half * std::sqrt(std::max(0.0, 1 - n[k] * n[k]));
        cuts[k] = cut(at[k], halves[k]);
    }
    const auto variance = [&halves](int k, const Cut& part) {
        const double wide = 2 * halves[k] * part.share;
        return wide * wide / 12;
    };
    for (int axis = 0; axis < 3; ++axis) {
        if (n[axis] * n[axis] < kSliver) continue;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (const Cut& cut_u : cuts[u]) {
            for (const Cut& cut_v : cuts[v]) {
                const double share = n[axis] * n[axis] * cut_u.share * cut_v.share;
                if (!(share > 0)) continue;
                const Slope slope{axis, u, v, n};
                const Vec3 from_middle =
                    slope.bound(slope.place(cut_u.middle - at[u], cut_v.middle - at[v]), halves);
                if (!may_have_record(box, seen + from_middle)) continue;
                const Vec3 rise = slope.rise(variance(u, cut_u), variance(v, cut_v), halves[2]);
                share_part(sample, axis,
                           {seen + from_middle, at_m + voxel_m_ * from_middle, normal,
                            share * sample.area_m2, voxel_m_ * voxel_m_ * rise},
                           lot);
            }
        }
    }
}

void SurfacePieces::share_part(const SurfaceSample& sample, int axis, const Part& part,
                               Lot& lot) const {
    const double at[3] = {part.seen.x, part.seen.y, part.seen.z};
    const double n[3] = {part.normal.x, part.normal.y, part.normal.z};
    int voxel[3];
    for (int k = 0; k < 3; ++k) voxel[k] = static_cast<int>(std::floor(at[k]));
    const int outwards = n[axis] > 0 ? 1 : -1;
    const double into = at[axis] - voxel[axis];
    const double through = outwards > 0 ? into : 1 - into;
    const double shares[3] = {(1 - through) / 2, 0.5, through / 2};
    int record[3];
    double sum = 0;
    for (int step = 0; step < 3; ++step) {
        int beside[3] = {voxel[0], voxel[1], voxel[2]};
        beside[axis] += (step - 1) * outwards;
        record[step] = find(beside, lot.body);
        if (record[step] < 0) continue;
        if (cosine(records_[static_cast<size_t>(record[step])], part.normal) < kAgrees) {
            // Beside a lug the gradient may be all of what carries the lug.
            if (!sample.is_thin || step == 0) record[step] = -1;
        }
        if (!(shares[step] > kSliver)) record[step] = -1;  // the face lies on the voxel's border
        if (record[step] >= 0) sum += shares[step];
    }
    if (!(sum > 0)) {
        share_around(sample, part, lot);
        return;
    }
    for (int step = 0; step < 3; ++step) {
        if (record[step] >= 0) {
            lot.given.push_back({record[step], &sample, part, shares[step] / sum});
        }
    }
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
        return find(voxel, lot.body);
    };
    int record = -1;
    for (int i = 0; i <= steps && record < 0; ++i) {
        record = record_at(at + (static_cast<double>(i) / steps) * down);
    }
    if (record < 0) record = record_at(transform(to_grid, sample.tip) * (1 / voxel_m_));
    if (record < 0) return;
    const Part part{at,
                    transform(to_grid, sample.piece.at),
                    rotate(to_grid.rotation, sample.piece.normal),
                    sample.piece.area_m2,
                    {}};
    lot.given.push_back({record, &sample.piece, part, 1});
}

void SurfacePieces::add(const Given& given) {
    const SurfaceSample& sample = *given.sample;
    const Part& part = given.part;
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
        SurfacePiece& piece = pieces_[static_cast<size_t>(*link)];
        if (piece.row == sample.row && piece.part == sample.part &&
            dot(piece.area, part.normal) >= same_cosine_ * length(piece.area)) {
            add_to(piece);
            return;
        }
        link = &piece.next;
    }
    // The link may lie in a piece, and pieces may move as they get more.
    *link = static_cast<int>(pieces_.size());
    SurfacePiece& piece = pieces_.emplace_back();
    piece.origin = part.at_m;
    piece.row = sample.row;
    piece.part = sample.part;
    add_to(piece);
}

}  // namespace bsoil
