#include "oracle/contact_faces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace oracle {
namespace {

double angle_to_down(Vec3 normal, Vec3 up) {
    return std::acos(std::clamp(-dot(normal, up), -1.0, 1.0));
}

/// Two level directions a quarter turn apart; which ones does not matter to a sole's sides.
struct Level {
    Vec3 a, b;
};
Level level_of(Vec3 up) {
    const Vec3 any = std::abs(up.z) > 0.5 ? Vec3{1, 0, 0} : Vec3{0, 0, 1};
    const Vec3 b = cross(up, any) * (1 / length(cross(up, any)));
    return {cross(b, up), b};
}

double weight_of(const ContactVoxel& v) {
    return v.bearing_depth_m > 0 ? v.area_m2 * v.touching : 0;
}

/// Whether two elements of soles are of one: their places on the level differ by no more than the
/// gap, along either direction of the grid of elements.
bool are_near(const ContactVoxel& p, const ContactVoxel& q, Vec3 along_x, Vec3 along_y,
              const FaceRules& rules) {
    const Vec3 apart = p.center_m - q.center_m;
    const double most = (rules.gap + 0.5) * rules.element_m;
    return std::abs(dot(apart, along_x)) < most && std::abs(dot(apart, along_y)) < most;
}

/// Variance of the elements' places along a direction, weighted; and how many weigh something.
struct Spread {
    double area = 0, variance = 0;
    double squares = 0;  ///< sum of squared areas
};
Spread spread_along(std::span<const ContactVoxel> voxels, const std::vector<int>& elements,
                    Vec3 direction) {
    Spread out;
    double mean = 0;
    for (const int i : elements) {
        const double w = weight_of(voxels[static_cast<size_t>(i)]);
        if (!(w > 0)) continue;
        out.area += w;
        out.squares += w * w;
        mean += w * dot(voxels[static_cast<size_t>(i)].position_m, direction);
    }
    if (!(out.area > 0)) return out;
    mean /= out.area;
    for (const int i : elements) {
        const ContactVoxel& v = voxels[static_cast<size_t>(i)];
        const double off = dot(v.position_m, direction) - mean;
        out.variance += weight_of(v) / out.area * off * off;
    }
    return out;
}

/// Side of a row of squares with this variance of their middles. Of a side s it is s^2 / 12; that
/// within the squares adds to it.
double side_of(const Spread& s) { return std::sqrt(12 * s.variance + s.squares / s.area); }

/// The direction with the largest variance, by looking: first round the half circle, then closer
/// and closer.
double longest_direction(std::span<const ContactVoxel> voxels, const std::vector<int>& elements,
                         const Level& level) {
    const auto variance_at = [&](double angle) {
        const Vec3 direction = std::cos(angle) * level.a + std::sin(angle) * level.b;
        return spread_along(voxels, elements, direction).variance;
    };
    constexpr int kLooks = 36;
    double best = 0, step = std::numbers::pi / kLooks;
    for (int i = 1; i < kLooks; ++i) {
        if (variance_at(i * step) > variance_at(best)) best = i * step;
    }
    for (; step > 1e-9; step /= 2) {
        for (const double angle : {best - step, best + step}) {
            if (variance_at(angle) > variance_at(best)) best = angle;
        }
    }
    return best;
}

void measure(Face& face, std::span<const ContactVoxel> voxels, const FaceRules& rules) {
    double density = 0, density_area = 0;
    for (const int i : face.elements) {
        const ContactVoxel& v = voxels[static_cast<size_t>(i)];
        const double w = weight_of(v);
        if (!(w > 0)) continue;
        const double upright = face.is_sole ? 0 : std::sin(angle_to_down(v.normal, rules.up));
        face.depth_m = std::max(face.depth_m, v.bearing_depth_m);
        face.foot_m = std::max(face.foot_m, v.bearing_depth_m + upright * std::sqrt(v.area_m2) / 2);
        if (v.relative_density < 0) continue;
        density += w * v.relative_density;
        density_area += w;
    }
    if (density_area > 0) face.relative_density = density / density_area;
    if (!face.is_sole) {
        // As wide as it is level: across up and the axis that it looks along.
        const int axis = face.axis / 2;
        const Vec3 looks = rotate(rules.body_to_world,
                                  {axis == 0 ? 1.0 : 0, axis == 1 ? 1.0 : 0, axis == 2 ? 1.0 : 0});
        const Vec3 across = cross(rules.up, looks);
        const Spread s = spread_along(voxels, face.elements, across * (1 / length(across)));
        if (s.area > 0) face.width_m = face.length_m = side_of(s);
        return;
    }
    face.foot_m = 0;
    const Level level = level_of(rules.up);
    const double angle = longest_direction(voxels, face.elements, level);
    const Vec3 along = std::cos(angle) * level.a + std::sin(angle) * level.b;
    const Spread longest = spread_along(voxels, face.elements, along);
    const Spread shortest = spread_along(voxels, face.elements, cross(rules.up, along));
    if (!(longest.area > 0)) return;
    face.length_m = side_of(longest);
    // A ring or a frame has less area than the rectangle.
    face.width_m = std::min(side_of(shortest), longest.area / face.length_m);
}

int axis_of(Vec3 normal, const FaceRules& rules) {
    int best = 0;
    double most = -2;
    for (int axis = 0; axis < 6; ++axis) {
        const double sign = axis % 2 == 0 ? 1 : -1;
        const Vec3 looks{axis / 2 == 0 ? sign : 0, axis / 2 == 1 ? sign : 0,
                         axis / 2 == 2 ? sign : 0};
        const double cosine = dot(normal, rotate(rules.body_to_world, looks));
        if (cosine > most) {
            most = cosine;
            best = axis;
        }
    }
    return best;
}

}  // namespace

std::vector<Face> contact_faces(std::span<const ContactVoxel> voxels, const FaceRules& rules) {
    const Level grid = level_of(rules.up);
    std::vector<int> sole_of(voxels.size(), -1);
    const auto is_sole = [&](size_t i) {
        return angle_to_down(voxels[i].normal, rules.up) < std::numbers::pi / 4;
    };
    std::vector<Face> faces;
    for (size_t i = 0; i < voxels.size(); ++i) {
        if (!is_sole(i) || sole_of[i] >= 0) continue;
        Face face;
        face.is_sole = true;
        std::vector<int> edge{static_cast<int>(i)};
        sole_of[i] = static_cast<int>(faces.size());
        while (!edge.empty()) {
            const int from = edge.back();
            edge.pop_back();
            face.elements.push_back(from);
            for (size_t j = 0; j < voxels.size(); ++j) {
                if (sole_of[j] >= 0 || !is_sole(j) ||
                    !are_near(voxels[static_cast<size_t>(from)], voxels[j], grid.a, grid.b,
                              rules)) {
                    continue;
                }
                sole_of[j] = static_cast<int>(faces.size());
                edge.push_back(static_cast<int>(j));
            }
        }
        std::sort(face.elements.begin(), face.elements.end());
        faces.push_back(std::move(face));
    }
    for (int axis = 0; axis < 6; ++axis) {
        Face face;
        face.axis = axis;
        for (size_t i = 0; i < voxels.size(); ++i) {
            if (!is_sole(i) && axis_of(voxels[i].normal, rules) == axis) {
                face.elements.push_back(static_cast<int>(i));
            }
        }
        if (!face.elements.empty()) faces.push_back(std::move(face));
    }
    for (Face& face : faces) measure(face, voxels, rules);
    return faces;
}

}  // namespace oracle
