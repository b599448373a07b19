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
constexpr uint64_t kNoKey = ~uint64_t{0};

uint64_t key_of(const int voxel[3], int body) {
    return (static_cast<uint64_t>(body) << 42 ^ static_cast<uint64_t>(voxel[2]) << 28 ^
            static_cast<uint64_t>(voxel[1]) << 14 ^ static_cast<uint64_t>(voxel[0]));
}

size_t scattered(uint64_t key) {
    key *= 0x9e3779b97f4a7c15u;
    return static_cast<size_t>(key >> 24);
}

template <typename T>
void make_room(std::vector<T>& v, size_t count) {
    if (v.capacity() < count) v.reserve(2 * count);
}

}  // namespace

Vec3 square_rise_m2(double area_m2, Vec3 normal, Vec3 up) {
    return area_m2 / 12 * (up - dot(normal, up) * normal);
}

void SurfacePieces::gather(std::span<const ContactRecord> records,
                           std::span<const SampledBody> bodies, double voxel_m,
                           double same_cosine) {
    voxel_m_ = voxel_m;
    same_cosine_ = same_cosine;
    pieces_.clear();
    make_room(heads_, records.size());
    heads_.assign(records.size(), -1);
    const auto is_sampled = [](const SampledBody& body) { return body.surface != nullptr; };
    if (records.empty() || std::ranges::none_of(bodies, is_sampled)) return;
    make_room(pieces_, 2 * records.size());
    fill_table(records);
    boxes_.assign(bodies.size(), {});
    for (const ContactRecord& record : records) {
        Box& box = boxes_[static_cast<size_t>(record.body)];
        for (int k = 0; k < 3; ++k) {
            box.low[k] = std::min(box.low[k], record.voxel[k]);
            box.high[k] = std::max(box.high[k], record.voxel[k]);
        }
    }
    for (size_t b = 0; b < bodies.size(); ++b) {
        const SampledBody& body = bodies[b];
        const Box& box = boxes_[b];
        if (!body.surface || box.high[0] < 0) continue;
        const auto is_near = [&](Vec3 p, double reach) {
            const double at[3] = {p.x, p.y, p.z};
            for (int k = 0; k < 3; ++k) {
                if (at[k] < box.low[k] - reach || at[k] > box.high[k] + 1 + reach) return false;
            }
            return true;
        };
        const double per_voxel = 1 / voxel_m;
        for (const SampleCluster& cluster : body.surface->clusters) {
            if (!is_near(transform(body.to_grid, cluster.center) * per_voxel,
                         cluster.radius_m * per_voxel + 2)) {
                continue;
            }
            for (size_t i = cluster.first; i < cluster.last; ++i) {
                const SurfaceSample& sample = body.surface->samples[i];
                const Vec3 at = transform(body.to_grid, sample.at);
                if (is_near(at * per_voxel, 1.5)) {
                    add_sample(records, static_cast<int>(b), sample, at,
                               rotate(body.to_grid.rotation, sample.normal));
                }
            }
        }
        for (const OverTips& sample : body.surface->over_tips) {
            const Vec3 tip = transform(body.to_grid, sample.tip);
            const double high = length(sample.tip - sample.root) * per_voxel;
            if (is_near(tip * per_voxel, high + 1.5)) {
                add_over_tips(static_cast<int>(b), sample, body.to_grid);
            }
        }
    }
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
    if (voxel[0] < 0 || voxel[1] < 0 || voxel[2] < 0) return -1;
    const uint64_t key = key_of(voxel, body);
    size_t at = scattered(key) & (keys_.size() - 1);
    while (keys_[at] != kNoKey && keys_[at] != key) at = (at + 1) & (keys_.size() - 1);
    return keys_[at] == key ? found_[at] : -1;
}

// In the corner between two parts of a body their coverage hides the voxels across the face. What
// lies lower says nothing: there the face may be in the air.
int SurfacePieces::find_around(std::span<const ContactRecord> records, const int voxel[3], int body,
                               Vec3 normal) const {
    int best = -1;
    double best_cosine = kAgrees;
    for (int i = 0; i < 18; ++i) {
        const int beside[3] = {voxel[0] + i % 3 - 1, voxel[1] + i / 3 % 3 - 1, voxel[2] + i / 9};
        const int record = find(beside, body);
        if (record < 0) continue;
        const Vec3 gradient = records[static_cast<size_t>(record)].gradient;
        const double cosine = -dot(gradient, normal) / length(gradient);
        if (cosine < best_cosine) continue;
        best = record;
        best_cosine = cosine;
    }
    return best;
}

// A piece that leans may reach into soil where its middle does not.
void SurfacePieces::add_sample(std::span<const ContactRecord> records, int body,
                               const SurfaceSample& sample, Vec3 at_m, Vec3 normal) {
    const Vec3 seen_m = at_m + sample.out_m * normal;
    const double per_voxel = 1 / voxel_m_;
    if (add_by(records, body, sample, at_m, normal, seen_m * per_voxel)) return;
    const Vec3 rise_m2 = square_rise_m2(sample.area_m2, normal, {0, 0, 1});
    if (!(rise_m2.z > 0)) return;
    const Vec3 lower_end_m = seen_m - std::sqrt(3 / rise_m2.z) * rise_m2;
    add_by(records, body, sample, at_m, normal, lower_end_m * per_voxel);
}

bool SurfacePieces::add_by(std::span<const ContactRecord> records, int body,
                           const SurfaceSample& sample, Vec3 at_m, Vec3 normal, Vec3 place) {
    const std::array<double, 3> at{place.x, place.y, place.z}, n{normal.x, normal.y, normal.z};
    int axis = 2;
    for (int k = 0; k < 2; ++k) {
        if (std::abs(n[k]) > std::abs(n[axis])) axis = k;
    }
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
        record[step] = find(beside, body);
        if (record[step] < 0) continue;
        const Vec3 gradient = records[static_cast<size_t>(record[step])].gradient;
        if (-dot(gradient, normal) < kAgrees * length(gradient)) {
            // Beside a lug the gradient may be all of what carries the lug.
            if (!sample.is_thin || step == 0) record[step] = -1;
        }
        if (!(shares[step] > 0)) record[step] = -1;  // the face lies on the voxel's border
        if (record[step] >= 0) sum += shares[step];
    }
    if (!(sum > 0)) {
        const int corner = find_around(records, voxel, body, normal);
        if (corner >= 0) add_to(corner, sample, at_m, normal, sample.area_m2);
        return corner >= 0;
    }
    for (int step = 0; step < 3; ++step) {
        if (record[step] >= 0) {
            add_to(record[step], sample, at_m, normal, sample.area_m2 * shares[step] / sum);
        }
    }
    return true;
}

// What soil is there the body's own surface near it knows: the voxel that the piece is in, or those
// on the way down to the root, or that of the nearest tip.
void SurfacePieces::add_over_tips(int body, const OverTips& sample, const Pose& to_grid) {
    const Vec3 at = transform(to_grid, sample.piece.at) * (1 / voxel_m_);
    const Vec3 down = transform(to_grid, sample.root) * (1 / voxel_m_) - at;
    const int steps = 1 + static_cast<int>(std::ceil(length(down)));
    const auto record_at = [&](Vec3 p) {
        const int voxel[3] = {static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)),
                              static_cast<int>(std::floor(p.z))};
        return find(voxel, body);
    };
    int record = -1;
    for (int i = 0; i <= steps && record < 0; ++i) {
        record = record_at(at + (static_cast<double>(i) / steps) * down);
    }
    if (record < 0) record = record_at(transform(to_grid, sample.tip) * (1 / voxel_m_));
    if (record < 0) return;
    add_to(record, sample.piece, transform(to_grid, sample.piece.at),
           rotate(to_grid.rotation, sample.piece.normal), sample.piece.area_m2);
}

void SurfacePieces::add_to(int record, const SurfaceSample& sample, Vec3 at_m, Vec3 normal,
                           double area_m2) {
    const auto add = [&](SurfacePiece& piece) {
        piece.area += area_m2 * normal;
        piece.moment += area_m2 * at_m;
        const Vec3 off = at_m - piece.origin;
        piece.spread += area_m2 * (square_rise_m2(sample.area_m2, normal, {0, 0, 1}) + off.z * off);
        piece.area_m2 += area_m2;
    };
    int* link = &heads_[static_cast<size_t>(record)];
    while (*link >= 0) {
        SurfacePiece& piece = pieces_[static_cast<size_t>(*link)];
        if (piece.row == sample.row && piece.part == sample.part &&
            dot(piece.area, normal) >= same_cosine_ * length(piece.area)) {
            add(piece);
            return;
        }
        link = &piece.next;
    }
    // The link may lie in a piece, and pieces may move as they get more.
    const int made = static_cast<int>(pieces_.size());
    *link = made;
    SurfacePiece& piece = pieces_.emplace_back();
    piece.origin = at_m;
    piece.row = sample.row;
    piece.part = sample.part;
    add(piece);
}

}  // namespace bsoil
