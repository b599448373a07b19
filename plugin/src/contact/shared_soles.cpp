#include "bsoil/contact/shared_soles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "bsoil/contact/orientation.h"

namespace bsoil {
namespace {

/// A place on two level axes and the up axis.
using Place = std::array<double, 3>;

struct Bounds {
    Place low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    void add(const Place& at) {
        for (size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], at[k]);
            high[k] = std::max(high[k], at[k]);
        }
    }
    bool is_near(const Bounds& other, double gap_m) const {
        for (size_t k = 0; k < 3; ++k) {
            if (low[k] > other.high[k] + gap_m || other.low[k] > high[k] + gap_m) return false;
        }
        return true;
    }
    bool is_near(const Place& at, double gap_m) const { return is_near({at, at}, gap_m); }
};

struct Cell {
    Place at;
    int sole = 0;  ///< among all bodies'
    int carrier = 0;
};

bool are_near(const Cell& a, const Cell& b, double gap_m) {
    for (size_t k = 0; k < 3; ++k) {
        if (std::abs(a.at[k] - b.at[k]) > gap_m) return false;
    }
    return a.carrier == b.carrier;
}

class Joining {
  public:
    Joining(std::span<const BodySoles> bodies, Vec3 up, double gap_m)
        : bodies_(bodies), axes_{level_axes(up)[0], level_axes(up)[1], up}, gap_m_(gap_m) {}

    void run() {
        find_bounds();
        std::vector<size_t> by_low(bodies_.size());
        std::iota(by_low.begin(), by_low.end(), size_t{0});
        std::ranges::sort(by_low, {}, [this](size_t b) { return std::pair(bounds_[b].low[0], b); });
        for (size_t i = 0; i < by_low.size(); ++i) {
            for (size_t j = i + 1; j < by_low.size(); ++j) {
                if (bounds_[by_low[j]].low[0] > bounds_[by_low[i]].high[0] + gap_m_) break;
                join(by_low[i], by_low[j]);
            }
        }
        if (is_one_joined_) share();
    }

  private:
    Place place_of(const ContactVoxel& v) const {
        return {dot(v.center_m, axes_[0]), dot(v.center_m, axes_[1]), dot(v.center_m, axes_[2])};
    }

    void find_bounds() {
        bounds_.resize(bodies_.size());
        cells_.resize(bodies_.size());
        for (size_t b = 0; b < bodies_.size(); ++b) {
            first_sole_.push_back(static_cast<int>(roots_.size()));
            const BodySoles& body = bodies_[b];
            roots_.resize(roots_.size() + body.faces->soles().size());
            for (size_t i = 0; i < body.voxels.size(); ++i) {
                if (body.faces->sole_of_voxel(i) < 0) continue;
                bounds_[b].add(place_of(body.voxels[i]));
            }
        }
        std::iota(roots_.begin(), roots_.end(), 0);
    }

    /// Of a body's soles, along the first axis; found when they are first asked for.
    const std::vector<Cell>& cells_of(size_t b) {
        std::vector<Cell>& cells = cells_[b];
        if (!cells.empty()) return cells;
        const BodySoles& body = bodies_[b];
        for (size_t i = 0; i < body.voxels.size(); ++i) {
            const int sole = body.faces->sole_of_voxel(i);
            if (sole < 0) continue;
            cells.push_back(
                {place_of(body.voxels[i]), first_sole_[b] + sole, body.voxels[i].carrier});
        }
        std::ranges::stable_sort(cells, {}, [](const Cell& cell) { return cell.at[0]; });
        return cells;
    }

    void join(size_t a, size_t b) {
        if (!bounds_[a].is_near(bounds_[b], gap_m_)) return;
        const std::vector<Cell>&of_a = cells_of(a), &of_b = cells_of(b);
        size_t first = 0;
        for (const Cell& cell : of_a) {
            if (!bounds_[b].is_near(cell.at, gap_m_)) continue;
            while (first < of_b.size() && of_b[first].at[0] < cell.at[0] - gap_m_) ++first;
            for (size_t j = first; j < of_b.size() && of_b[j].at[0] <= cell.at[0] + gap_m_; ++j) {
                const int root_a = root_of(cell.sole), root_b = root_of(of_b[j].sole);
                if (root_a == root_b || !are_near(cell, of_b[j], gap_m_)) continue;
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
    double gap_m_;
    std::vector<Bounds> bounds_;            ///< by body
    std::vector<std::vector<Cell>> cells_;  ///< by body
    std::vector<int> first_sole_;           ///< by body
    std::vector<int> roots_;                ///< by sole: the first of those it is joined with
    bool is_one_joined_ = false;
};

}  // namespace

void join_soles(std::span<const BodySoles> bodies, Vec3 up, double gap_m) {
    if (bodies.size() > 1) Joining(bodies, up, gap_m).run();
}

}  // namespace bsoil
