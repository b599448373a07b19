#include "bsoil/contact/contact_faces.h"

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

}  // namespace

std::array<Vec3, 2> level_axes(Vec3 up) {
    const Vec3 a = unit_across(up);
    return {a, cross(up, a)};
}

// What only brushes the soil, like a wheel's rim above its rut, bears nothing.
FaceElement::FaceElement(const ContactVoxel& v, double place_a, double place_b, double upright)
    : area_m2(v.bearing_depth_m > 0 ? v.area_m2 * v.touching : 0),
      a(place_a),
      b(place_b),
      depth_m(v.bearing_depth_m),
      foot_m(v.bearing_depth_m + upright / 2 * std::sqrt(v.area_m2)),
      relative_density(v.relative_density) {}

void FaceMoments::add(const FaceElement& element) {
    const double w = element.area_m2, a = element.a, b = element.b;
    if (!(w > 0)) return;
    area_m2 += w;
    square_m4 += w * w;
    first_a += w * a;
    first_b += w * b;
    second_aa += w * a * a;
    second_ab += w * a * b;
    second_bb += w * b * b;
    depth_m = std::max(depth_m, element.depth_m);
    foot_m = std::max(foot_m, element.foot_m);
    if (element.relative_density >= 0) {
        density_m2 += w * element.relative_density;
        of_known_density_m2 += w;
    }
}

void FaceMoments::add(const FaceMoments& other) {
    area_m2 += other.area_m2;
    square_m4 += other.square_m4;
    first_a += other.first_a;
    first_b += other.first_b;
    second_aa += other.second_aa;
    second_ab += other.second_ab;
    second_bb += other.second_bb;
    density_m2 += other.density_m2;
    of_known_density_m2 += other.of_known_density_m2;
    depth_m = std::max(depth_m, other.depth_m);
    foot_m = std::max(foot_m, other.foot_m);
}

std::array<double, 2> FaceMoments::sides_m() const {
    const double a = first_a / area_m2, b = first_b / area_m2;
    // Rounding may leave less.
    const double aa = std::max(0.0, second_aa / area_m2 - a * a);
    const double bb = std::max(0.0, second_bb / area_m2 - b * b);
    const double ab = second_ab / area_m2 - a * b;
    // The eigenvalues, the principal variances.
    const double middle = (aa + bb) / 2;
    const double spread = std::hypot((aa - bb) / 2, ab);
    const auto side = [square = square_m4 / area_m2](double principal) {
        // Of a side s it is s^2 / 12: that of the elements' middles, and within each.
        return std::sqrt(12 * std::max(0.0, principal) + square);
    };
    return {side(middle - spread), side(middle + spread)};
}

FaceExtent FaceMoments::as_sole() const {
    if (!(area_m2 > 0)) return {0, 0, depth_m, relative_density(), 0};
    const auto [side_m, length_m] = sides_m();
    // A ring or a frame has less area than the rectangle.
    return {std::min(side_m, area_m2 / length_m), length_m, depth_m, relative_density(), 0};
}

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
        if (!std::is_sorted(row, end, lies_before)) std::sort(row, end, lies_before);
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
                         .y = std::llround(dot(place, axis_b)),
                         .element = {v, dot(v.position_m, axis_a), dot(v.position_m, axis_b), 0}};
        }
        const int bin = dominant_axis_bin(rotate(to_body, v.normal));
        const double rise = dot(v.normal, up), upright = std::sqrt(std::max(0.0, 1 - rise * rise));
        return Place{.wall = bin, .element = {v, dot(v.position_m, across[bin]), 0, upright}};
    };
    for_ranges(threads, voxels.size(), kFaceRangeVoxels, [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) places_[i] = place_of(voxels[i]);
    });

    std::array<FaceMoments, kWallBinCount> walls;
    cells_.clear();
    for (size_t i = 0; i < voxels.size(); ++i) {
        const Place& place = places_[i];
        if (place.wall < 0) {
            cells_.push_back({place.x, place.y, static_cast<int>(i)});
            continue;
        }
        face_of_voxel_[i] = place.wall;
        walls[place.wall].add(place.element);
    }
    for (int bin = 0; bin < kWallBinCount; ++bin) {
        if (!(walls[bin].area_m2 > 0)) continue;
        const double width_m = walls[bin].sides_m()[1];
        faces_[bin] = {width_m, width_m, walls[bin].depth_m, walls[bin].relative_density(),
                       walls[bin].foot_m};
    }

    sort_cells();
    join_runs(law.def().sole_gap_voxels);
    face_of_root_.assign(runs_.size(), -1);
    soles_.clear();
    for (const Run& run : runs_) {
        int& face = face_of_root_[run.root];
        if (face < 0) {
            face = static_cast<int>(soles_.size());
            soles_.emplace_back();
        }
        for (size_t i = run.first; i < run.last; ++i) {
            const int voxel = cells_[i].voxel;
            soles_[face].add(places_[voxel].element);
            face_of_voxel_[voxel] = kWallBinCount + face;
        }
    }
    for (const FaceMoments& sole : soles_) faces_.push_back(sole.as_sole());
}

int ContactFaces::sole_of_voxel(size_t voxel) const {
    return std::max(-1, face_of_voxel_[voxel] - kWallBinCount);
}

void ContactFaces::set_sole(size_t sole, const FaceExtent& extent) {
    faces_[kWallBinCount + sole] = extent;
}

}  // namespace bsoil
