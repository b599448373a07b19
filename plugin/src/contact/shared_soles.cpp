#include "bsoil/contact/shared_soles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace bsoil {
namespace {

/// An element reaches so far from its middle, of its side. Ours: half of it is its own, the rest
/// bridges a gap of half an element between two bodies, as soil does not flow into. Larger: pebbles
/// that lie apart bear as one sole; smaller: the links of a track do not.
constexpr double kReachSides = 0.75;

/// Voxels whose bounds one thread finds. Ours, as a matter of cost: some hundredths of a
/// millisecond. Larger: one thread looks at all of a body; smaller: sharing them out takes longer.
constexpr size_t kBoundVoxels = 2048;

/// A place on two level axes and the up axis.
using Place = std::array<double, 3>;

struct Cell {
    Place at;
    double reach_m = 0;
    int sole = 0;  ///< among all bodies'
    int carrier = 0;
};

bool are_near(const Cell& a, const Cell& b) {
    for (size_t k = 0; k < 3; ++k) {
        if (std::abs(a.at[k] - b.at[k]) > a.reach_m + b.reach_m) return false;
    }
    return a.carrier == b.carrier;
}

/// Of cells with their reach.
struct Bounds {
    Place low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    double reach_most_m = 0;
    void add(const Cell& cell) {
        for (size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], cell.at[k] - cell.reach_m);
            high[k] = std::max(high[k], cell.at[k] + cell.reach_m);
        }
        reach_most_m = std::max(reach_most_m, cell.reach_m);
    }
    void add(const Bounds& other) {
        for (size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], other.low[k]);
            high[k] = std::max(high[k], other.high[k]);
        }
        reach_most_m = std::max(reach_most_m, other.reach_most_m);
    }
    bool meets(const Bounds& other) const {
        for (size_t k = 0; k < 3; ++k) {
            if (low[k] > other.high[k] || other.low[k] > high[k]) return false;
        }
        return true;
    }
};

class Joining {
  public:
    Joining(std::span<const BodySoles> bodies, Vec3 up, const WorkThreads* threads)
        : bodies_(bodies), axes_{level_axes(up)[0], level_axes(up)[1], up}, threads_(threads) {}

    void run() {
        find_bounds();
        std::vector<size_t> by_low(bodies_.size());
        std::iota(by_low.begin(), by_low.end(), size_t{0});
        const auto low_of = [this](size_t b) { return std::pair(bounds_[b].low[along_], b); };
        std::ranges::sort(by_low, {}, low_of);
        for (size_t i = 0; i < by_low.size(); ++i) {
            for (size_t j = i + 1; j < by_low.size(); ++j) {
                if (bounds_[by_low[j]].low[along_] > bounds_[by_low[i]].high[along_]) break;
                join(by_low[i], by_low[j]);
            }
        }
        if (is_one_joined_) share();
    }

  private:
    Cell cell_of(size_t b, size_t voxel) const {
        const ContactVoxel& v = bodies_[b].voxels[voxel];
        return {
            {dot(v.position_m, axes_[0]), dot(v.position_m, axes_[1]), dot(v.position_m, axes_[2])},
            kReachSides * std::sqrt(v.area_m2),
            first_sole_[b] + bodies_[b].faces->sole_of_voxel(voxel),
            v.carrier};
    }
    /// Of a body's voxels from first to before last.
    template <typename Visit>
    void for_each_cell(size_t b, size_t first, size_t last, Visit visit) const {
        for (size_t i = first; i < last; ++i) {
            if (bodies_[b].faces->sole_of_voxel(i) >= 0) visit(cell_of(b, i));
        }
    }
    Bounds bounds_of(size_t b) const {
        const size_t count = bodies_[b].voxels.size();
        std::vector<Bounds> parts((count + kBoundVoxels - 1) / kBoundVoxels);
        for_ranges(threads_, parts.size(), 1, [&](size_t first, size_t last) {
            for (size_t part = first; part < last; ++part) {
                const size_t begin = part * kBoundVoxels;
                for_each_cell(b, begin, std::min(begin + kBoundVoxels, count),
                              [&](const Cell& cell) { parts[part].add(cell); });
            }
        });
        Bounds out;
        for (const Bounds& part : parts) out.add(part);
        return out;
    }

    /// And the level axis along which the bodies lie further apart.
    void find_bounds() {
        bounds_.resize(bodies_.size());
        cells_.resize(bodies_.size());
        for (size_t b = 0; b < bodies_.size(); ++b) {
            first_sole_.push_back(static_cast<int>(roots_.size()));
            roots_.resize(roots_.size() + bodies_[b].faces->soles().size());
        }
        for_ranges(threads_, bodies_.size(), 1, [&](size_t first, size_t last) {
            for (size_t b = first; b < last; ++b) bounds_[b] = bounds_of(b);
        });
        Bounds all;
        for (const Bounds& bounds : bounds_) all.add(bounds);
        std::iota(roots_.begin(), roots_.end(), 0);
        along_ = all.high[1] - all.low[1] > all.high[0] - all.low[0] ? 1 : 0;
    }

    /// Of a body's soles, in order along the axis; found when they are first asked for.
    std::span<const Cell> cells_of(size_t b) {
        std::vector<Cell>& cells = cells_[b];
        if (cells.empty()) {
            for_each_cell(b, 0, bodies_[b].voxels.size(),
                          [&](const Cell& cell) { cells.push_back(cell); });
            std::ranges::stable_sort(cells, {}, [this](const Cell& c) { return c.at[along_]; });
        }
        return cells;
    }
    /// Those from `low` to `high` along the axis.
    std::span<const Cell> between(std::span<const Cell> cells, double low, double high) const {
        const auto at = [this](const Cell& cell) { return cell.at[along_]; };
        const auto first = std::ranges::lower_bound(cells, low, {}, at);
        return {first, std::ranges::upper_bound(first, cells.end(), high, {}, at)};
    }

    void join(size_t a, size_t b) {
        const Bounds &of_a = bounds_[a], &of_b = bounds_[b];
        if (!of_a.meets(of_b)) return;
        const std::span<const Cell> cells_b = cells_of(b);
        for (const Cell& cell : between(cells_of(a), of_b.low[along_] - of_a.reach_most_m,
                                        of_b.high[along_] + of_a.reach_most_m)) {
            Bounds own;
            own.add(cell);
            if (!own.meets(of_b)) continue;
            const double reach_m = cell.reach_m + of_b.reach_most_m;
            for (const Cell& other :
                 between(cells_b, cell.at[along_] - reach_m, cell.at[along_] + reach_m)) {
                const int root_a = root_of(cell.sole), root_b = root_of(other.sole);
                if (root_a == root_b || !are_near(cell, other)) continue;
                roots_[std::max(root_a, root_b)] = std::min(root_a, root_b);
                is_one_joined_ = true;
            }
        }
    }

    int root_of(int sole) {
        while (roots_[sole] != sole) sole = roots_[sole] = roots_[roots_[sole]];
        return sole;
    }

    void share() {
        std::vector<FaceMoments> sums(roots_.size());
        std::vector<int> counts(roots_.size());
        const auto for_each_sole = [this](auto visit) {
            for (size_t b = 0; b < bodies_.size(); ++b) {
                for (size_t s = 0; s < bodies_[b].faces->soles().size(); ++s) {
                    const int sole = first_sole_[b] + static_cast<int>(s);
                    visit(*bodies_[b].faces, s, static_cast<size_t>(root_of(sole)));
                }
            }
        };
        for_each_sole([&](const ContactFaces& faces, size_t sole, size_t root) {
            sums[root].add(faces.soles()[sole]);
            ++counts[root];
        });
        for_each_sole([&](ContactFaces& faces, size_t sole, size_t root) {
            if (counts[root] > 1) faces.set_sole(sole, sums[root].as_sole());
        });
    }

    std::span<const BodySoles> bodies_;
    std::array<Vec3, 3> axes_;
    const WorkThreads* threads_;
    size_t along_ = 0;
    std::vector<Bounds> bounds_;            ///< by body
    std::vector<std::vector<Cell>> cells_;  ///< by body
    std::vector<int> first_sole_;           ///< by body
    std::vector<int> roots_;                ///< by sole: the first of those it is joined with
    bool is_one_joined_ = false;
};

}  // namespace

void join_soles(std::span<const BodySoles> bodies, Vec3 up, const WorkThreads* threads) {
    if (bodies.size() > 1) Joining(bodies, up, threads).run();
}

}  // namespace bsoil
