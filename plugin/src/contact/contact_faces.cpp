#include "bsoil/contact/contact_faces.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "bsoil/contact/orientation.h"

namespace bsoil {
namespace {

constexpr int kWallBinCount = 6;  ///< either way along the axes of the body's frame
/// Voxels that one thread takes at least.
constexpr size_t kFaceRangeVoxels = 256;

/// Two unit vectors across `up` that do not depend on the body.
std::array<Vec3, 2> level_axes(Vec3 up) {
    const Vec3 a = unit_across(up);
    return {a, cross(up, a)};
}

/// What is summed up of a face.
struct FaceSums {
    double area = 0;
    Eigen::Vector2d first = Eigen::Vector2d::Zero();   ///< moments of area of the voxels' places
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();  ///< on the face
    double density = 0, density_area = 0;
    double depth_m = 0, foot_m = 0;
    int count = 0;

    /// upright: sine between the normal and straight down.
    void add(const ContactVoxel& v, const Eigen::Vector2d& at, double upright) {
        // What only brushes the soil, like a wheel's rim above its rut, bears nothing.
        const double w = v.bearing_depth_m > 0 ? v.area_m2 * v.touching : 0;
        if (!(w > 0)) return;
        area += w;
        ++count;
        first += w * at;
        second += w * at * at.transpose();
        depth_m = std::max(depth_m, v.bearing_depth_m);
        foot_m = std::max(foot_m, v.bearing_depth_m + upright / 2 * std::sqrt(v.area_m2));
        if (v.relative_density >= 0) {
            density += w * v.relative_density;
            density_area += w;
        }
    }
    double relative_density() const { return density_area > 0 ? density / density_area : 0; }
    /// Sides of the rectangle with the same second moments, the shorter first.
    std::array<double, 2> sides() const {
        const Eigen::Vector2d mean = first / area;
        Eigen::Matrix2d variance = second / area - mean * mean.transpose();
        variance.diagonal() = variance.diagonal().cwiseMax(0);  // rounding may leave less
        // The eigenvalues, the principal variances.
        const double middle = variance.trace() / 2;
        const double spread = std::hypot((variance(0, 0) - variance(1, 1)) / 2, variance(0, 1));
        const auto side = [square = area / count](double principal) {
            // n points h apart have the variance (n^2 - 1) h^2 / 12.
            return std::sqrt(12 * std::max(0.0, principal) + square);
        };
        return {side(middle - spread), side(middle + spread)};
    }
};

}  // namespace

int dominant_axis_bin(Vec3 n) {
    const std::array<double, 3> c{n.x, n.y, n.z};
    int axis = 0;
    for (int k = 1; k < 3; ++k) {
        if (std::abs(c[k]) > std::abs(c[axis])) axis = k;
    }
    return 2 * axis + (c[axis] < 0 ? 1 : 0);
}

int ContactFaces::root_of(int run) {
    while (runs_[run].root != run) run = runs_[run].root = runs_[runs_[run].root].root;
    return run;
}

// Voxels mostly come row by row already, so that each row is sorted by itself.
void ContactFaces::sort_cells() {
    const auto lies_before = [](const Cell& a, const Cell& b) {
        return a < b || (!(b < a) && a.voxel < b.voxel);
    };
    const auto by_x = [](const Cell& a, const Cell& b) { return a.x < b.x; };
    if (!std::ranges::is_sorted(cells_, by_x)) {
        std::ranges::sort(cells_, lies_before);
        return;
    }
    for (auto row = cells_.begin(); row != cells_.end();) {
        const auto end =
            std::find_if(row, cells_.end(), [&](const Cell& c) { return c.x != row->x; });
        std::sort(row, end, lies_before);
        row = end;
    }
}

void ContactFaces::join_runs(int gap) {
    runs_.clear();
    for (size_t i = 0; i < cells_.size(); ++i) {
        const bool follows =
            i > 0 && cells_[i - 1].x == cells_[i].x && cells_[i].y <= cells_[i - 1].y + gap;
        if (!follows) runs_.push_back({i, i, static_cast<int>(runs_.size())});
        runs_.back().last = i + 1;
    }
    const auto x_of = [this](size_t run) { return cells_[runs_[run].first].x; };
    const auto low = [this](size_t run) { return cells_[runs_[run].first].y; };
    const auto high = [this](size_t run) { return cells_[runs_[run].last - 1].y; };
    const auto join = [this](size_t i, size_t j) {
        const int a = root_of(static_cast<int>(i)), b = root_of(static_cast<int>(j));
        runs_[std::max(a, b)].root = std::min(a, b);
    };
    for (int64_t dx = 1; dx <= gap; ++dx) {
        // What is near the next run begins no earlier than what is near this one. Runs that overlap
        // or end no further apart than the gap have cells that are as near.
        size_t first = 0;
        for (size_t i = 0; i < runs_.size(); ++i) {
            const int64_t x = x_of(i) + dx;
            while (first < runs_.size() &&
                   (x_of(first) < x || (x_of(first) == x && high(first) < low(i) - gap))) {
                ++first;
            }
            for (size_t j = first; j < runs_.size() && x_of(j) == x && low(j) <= high(i) + gap;
                 ++j) {
                join(i, j);
            }
        }
    }
    for (size_t i = 0; i < runs_.size(); ++i) runs_[i].root = root_of(static_cast<int>(i));
}

void ContactFaces::find(std::span<const ContactVoxel> voxels, Quat body_to_world,
                        const ContactLaw& law, double element_m, const WorkThreads* threads) {
    const Vec3 up = law.up();
    faces_.assign(kWallBinCount, {});
    face_of_voxel_.resize(voxels.size());
    const Quat to_body = conjugate(body_to_world);
    const auto [axis_a, axis_b] = level_axes(up);
    // A wall is as wide as it is level: along the up axis and the one across its normal.
    std::array<Vec3, kWallBinCount> across;
    for (int bin = 0; bin < kWallBinCount; ++bin) {
        const Vec3 normal = rotate(body_to_world, {bin / 2 == 0 ? 1.0 : 0, bin / 2 == 1 ? 1.0 : 0,
                                                   bin / 2 == 2 ? 1.0 : 0});
        const Vec3 level = cross(up, normal);
        const double size = length(level);
        across[bin] = size > 1e-9 ? level * (1 / size) : axis_a;
    }

    places_.resize(voxels.size());
    const auto place_of = [&, axis_a = axis_a, axis_b = axis_b](const ContactVoxel& v) {
        if (is_sole(looks_down(v.normal, up))) {
            // Whole voxels apart: rounding does not decide where the grid lies along the axes.
            const Vec3 place = (v.center_m - voxels.front().center_m) * (1 / element_m);
            return Place{.x = std::llround(dot(place, axis_a)),
                         .y = std::llround(dot(place, axis_b))};
        }
        const int bin = dominant_axis_bin(rotate(to_body, v.normal));
        return Place{.wall = bin, .across_m = dot(v.position_m, across[bin])};
    };
    for_ranges(threads, voxels.size(), kFaceRangeVoxels, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) places_[i] = place_of(voxels[i]);
    });

    std::array<FaceSums, kWallBinCount> walls;
    cells_.clear();
    for (size_t i = 0; i < voxels.size(); ++i) {
        const Place& place = places_[i];
        if (place.wall < 0) {
            cells_.push_back({place.x, place.y, static_cast<int>(i)});
            continue;
        }
        face_of_voxel_[i] = place.wall;
        const double rise = dot(voxels[i].normal, up);
        walls[place.wall].add(voxels[i], {place.across_m, 0},
                              std::sqrt(std::max(0.0, 1 - rise * rise)));
    }
    for (int bin = 0; bin < kWallBinCount; ++bin) {
        if (!(walls[bin].area > 0)) continue;
        const double width_m = walls[bin].sides()[1];
        faces_[bin] = {width_m, width_m, walls[bin].depth_m, walls[bin].relative_density(),
                       walls[bin].foot_m};
    }

    sort_cells();
    join_runs(law.def().sole_gap_voxels);
    face_of_root_.assign(runs_.size(), -1);
    std::vector<FaceSums> soles;
    for (const Run& run : runs_) {
        int& face = face_of_root_[run.root];
        if (face < 0) {
            face = static_cast<int>(soles.size());
            soles.emplace_back();
        }
        for (size_t i = run.first; i < run.last; ++i) {
            const ContactVoxel& v = voxels[cells_[i].voxel];
            soles[face].add(v, {dot(v.position_m, axis_a), dot(v.position_m, axis_b)}, 0);
            face_of_voxel_[cells_[i].voxel] = kWallBinCount + face;
        }
    }
    for (const FaceSums& sole : soles) {
        const auto [side_m, length_m] = sole.area > 0 ? sole.sides() : std::array{0.0, 0.0};
        // A ring or a frame has less area than the rectangle.
        const double width_m = length_m > 0 ? std::min(side_m, sole.area / length_m) : 0;
        faces_.push_back({width_m, length_m, sole.depth_m, sole.relative_density(), 0});
    }
}

}  // namespace bsoil
