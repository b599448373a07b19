#include "bsoil/contact/underside.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bsoil/distance_lattice.h"

namespace bsoil {
namespace {

/// Columns along either side of the rectangle that is looked at: as many as the grid has, within
/// these bounds. With 7 over its 2.5 m the tracks of a machine had 7 tenths of their width.
constexpr int kColumnsLeast = 7, kColumnsMost = 64;
/// The rectangle is drawn in to the columns that meet soil, or round the lowest one, so often at
/// most: a ball 1 mm deep touches a small part of its width.
constexpr int kSupportRounds = 5;
/// Drawn in again only where its area gets smaller by this factor. Ours: a round costs as much as
/// the first one. Larger: rounds for nothing; smaller: few columns meet a small contact.
constexpr double kSmaller = 0.7;
/// A line has met the surface where it is so near to it, of the body's size. Ours: 10 um of a
/// metre, well below any sinkage that counts. Larger: depths are short by so much; smaller: more
/// steps.
constexpr double kNear = 1e-5;
/// Steps of such a line. Ours: on a face it nears by half at least, so this is more than kNear asks
/// for. Fewer: lines along a wall are given up.
constexpr int kStepsMost = 64;
/// Steeper faces than this (cosine between the normal and straight down) are as wide as this one.
/// Ours: 84 deg, past which a column's area is no measure of the face. Larger: steep cones have
/// less area; smaller: one column beside a wall bears as much as a sole.
constexpr double kSteepest = 0.1;

/// Below or equal to the distance of a point from a solid, and zero on it; negative inside.
double solid_distance_m(const ConvexShape& shape, Vec3 p) {
    const double r = shape.radius_m, h = shape.half_height_m;
    const auto radial = [p] { return std::hypot(p.x, p.y); };
    double distance_m = 0;
    switch (shape.kind) {
        case ConvexShape::Kind::box: {
            const Vec3 half = shape.half_extents_m;
            distance_m =
                std::max({std::abs(p.x) - half.x, std::abs(p.y) - half.y, std::abs(p.z) - half.z});
            break;
        }
        case ConvexShape::Kind::sphere:
            distance_m = length(p) - r;
            break;
        case ConvexShape::Kind::capsule:
            distance_m = std::hypot(radial(), p.z - std::clamp(p.z, -h, h)) - r;
            break;
        case ConvexShape::Kind::cylinder:
            distance_m = std::max(radial() - r, std::abs(p.z) - h);
            break;
        case ConvexShape::Kind::cone: {
            const double slant = std::hypot(r, 2 * h);
            distance_m = std::max((radial() * 2 * h + (p.z - h) * r) / slant, -h - p.z);
            break;
        }
        case ConvexShape::Kind::hull:
            distance_m = -HUGE_VAL;
            for (const Plane& plane : shape.planes) {
                distance_m = std::max(distance_m, dot(plane.normal, p) - plane.offset);
            }
            break;
        case ConvexShape::Kind::lattice:
            distance_m = shape.lattice->distance_m(p);
            break;
    }
    return distance_m - shape.rounding_m;
}

/// A body's solids, in the order of its shapes.
class Solids {
  public:
    Solids(std::span<const ConvexShape> shapes, const Pose& pose)
        : shapes_(shapes), to_body_(inverse(pose)) {}
    double distance_m(Vec3 point) const {
        const Vec3 at = transform(to_body_, point);
        double least = HUGE_VAL;
        for (const ConvexShape& shape : shapes_) {
            least = std::min(least, solid_distance_m(shape, transform(inverse(shape.local), at)));
        }
        return least;
    }
    Vec3 normal(Vec3 at, double step_m) const {
        const auto slope = [&](Vec3 axis) {
            return distance_m(at + step_m * axis) - distance_m(at - step_m * axis);
        };
        const Vec3 gradient{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
        const double size = length(gradient);
        return size > 0 ? gradient * (1 / size) : Vec3{};
    }

  private:
    std::span<const ConvexShape> shapes_;
    Pose to_body_;
};

struct Rectangle {
    std::array<double, 2> low, high;
    double area() const { return (high[0] - low[0]) * (high[1] - low[1]); }
};

}  // namespace

double sample_underside(std::span<const ConvexShape> shapes, const Pose& pose, const Aabb& box,
                        const SurfaceSoil& surface, Vec3 up, double voxel_m, int body,
                        std::vector<ContactVoxel>& out) {
    out.clear();
    const Solids solids(shapes, pose);
    // Up is the world's y or z; the two others are level.
    const bool y_up = up.y > 0.5;
    const auto make = [y_up](double a, double b, double height) {
        return y_up ? Vec3{a, height, b} : Vec3{a, b, height};
    };
    const Vec3 plane = surface.plane.position_m, normal = surface.plane.normal;
    const double rise = dot(normal, up);
    const double size_m = length(box.max - box.min);
    const double bottom_m = dot(box.min, up) - kNear * size_m;
    const double height_m = dot(box.max, up) - bottom_m;
    Rectangle area{{box.min.x, y_up ? box.min.z : box.min.y},
                   {box.max.x, y_up ? box.max.z : box.max.y}};
    double apart_m = 0;
    if (!(rise > 0) || !(area.area() > 0)) return apart_m;
    // From a column's foot up to the plane.
    const auto room_m = [&](double a, double b) {
        return dot(plane - make(a, b, bottom_m), normal) / rise;
    };
    // Most bodies of a heap lie above the soil.
    if (std::max({room_m(area.low[0], area.low[1]), room_m(area.high[0], area.low[1]),
                  room_m(area.low[0], area.high[1]), room_m(area.high[0], area.high[1])}) <= 0) {
        return apart_m;
    }
    for (int round = 0; round < kSupportRounds; ++round) {
        out.clear();
        std::array<int, 2> count{};
        std::array<double, 2> cell{};
        for (int axis = 0; axis < 2; ++axis) {
            const double side_m = area.high[axis] - area.low[axis];
            count[axis] = static_cast<int>(
                std::clamp<double>(std::ceil(side_m / voxel_m), kColumnsLeast, kColumnsMost));
            cell[axis] = side_m / count[axis];
        }
        apart_m = std::max(cell[0], cell[1]);
        Rectangle met{{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}};
        const auto join = [&](const std::array<double, 2>& at) {
            for (int axis = 0; axis < 2; ++axis) {
                met.low[axis] = std::min(met.low[axis], at[axis] - 1.5 * cell[axis]);
                met.high[axis] = std::max(met.high[axis], at[axis] + 1.5 * cell[axis]);
            }
        };
        double deepest_m = -HUGE_VAL;
        std::array<double, 2> deepest{};
        for (int i = 0; i < count[0] * count[1]; ++i) {
            const std::array<double, 2> at{area.low[0] + (i % count[0] + 0.5) * cell[0],
                                           area.low[1] + (i / count[0] + 0.5) * cell[1]};
            const Vec3 foot = make(at[0], at[1], bottom_m);
            double risen_m = 0, distance_m = HUGE_VAL;
            for (int step = 0; step < kStepsMost && risen_m < height_m; ++step) {
                distance_m = solids.distance_m(foot + risen_m * up);
                if (distance_m <= kNear * size_m) break;
                risen_m += distance_m;
            }
            if (distance_m > kNear * size_m) continue;
            const double depth_m = room_m(at[0], at[1]) - risen_m;
            if (depth_m > deepest_m) {
                deepest_m = depth_m;
                deepest = at;
            }
            if (!(depth_m > 0)) continue;
            join(at);
            ContactVoxel& element = out.emplace_back();
            element.body = body;
            element.center_m = element.position_m = foot + risen_m * up;
            element.normal = solids.normal(element.position_m, kNear * size_m);
            const double down = -dot(element.normal, up);
            if (!(down > 0)) element.normal = -up;
            element.area_m2 = cell[0] * cell[1] / std::clamp(down, kSteepest, 1.0);
            element.depth_m = element.bearing_depth_m = depth_m;
            element.material = surface.material;
            element.relative_density = surface.relative_density;
            element.saturation = surface.saturation;
            element.undisturbed = surface.undisturbed;
        }
        if (deepest_m == -HUGE_VAL) return apart_m;
        if (out.empty()) join(deepest);  // the lowest point lies between the columns
        for (int axis = 0; axis < 2; ++axis) {
            met.low[axis] = std::max(met.low[axis], area.low[axis]);
            met.high[axis] = std::min(met.high[axis], area.high[axis]);
        }
        if (!(met.area() < kSmaller * area.area())) return apart_m;
        area = met;
    }
    return apart_m;
}

}  // namespace bsoil
