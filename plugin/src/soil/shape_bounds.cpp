#include "soil/shape_bounds.h"

#include <algorithm>
#include <cmath>

#include "bsoil/distance_lattice.h"
#include "bsoil/limits.h"

namespace bsoil {
namespace {

Vec3 half_box(const ConvexShape& s) {
    switch (s.kind) {
        case ConvexShape::Kind::box:
            return s.half_extents_m;
        case ConvexShape::Kind::sphere:
            return {s.radius_m, s.radius_m, s.radius_m};
        case ConvexShape::Kind::capsule:
            return {s.radius_m, s.radius_m, s.half_height_m + s.radius_m};
        case ConvexShape::Kind::cylinder:
        case ConvexShape::Kind::cone:
            return {s.radius_m, s.radius_m, s.half_height_m};
        case ConvexShape::Kind::hull:
            return {s.bound_m, s.bound_m, s.bound_m};
        case ConvexShape::Kind::lattice:
            return 0.5 * (s.lattice->bounds().max - s.lattice->bounds().min);
    }
    return {};
}

/// Middle of the box, in the shape's frame.
Vec3 middle_of_box(const ConvexShape& s) {
    return s.kind == ConvexShape::Kind::lattice
               ? 0.5 * (s.lattice->bounds().min + s.lattice->bounds().max)
               : Vec3{};
}

}  // namespace

Aabb shape_bounds(const ConvexShape& shape, const Pose& body_to_grid, double voxel_m) {
    const Pose pose = body_to_grid * shape.local;
    const Vec3 half = half_box(shape);
    const Vec3 axes[3] = {rotate(pose.rotation, {half.x, 0, 0}),
                          rotate(pose.rotation, {0, half.y, 0}),
                          rotate(pose.rotation, {0, 0, half.z})};
    Vec3 reach{shape.rounding_m, shape.rounding_m, shape.rounding_m};
    for (const Vec3& axis : axes) reach += {std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)};
    const Vec3 middle = transform(pose, middle_of_box(shape));
    return {(middle - reach) * (1 / voxel_m), (middle + reach) * (1 / voxel_m)};
}

bool is_valid_shape(const ConvexShape& s) {
    constexpr double kLargest = 1e5;  // metres; beyond it floats no longer resolve a voxel
    const auto sound = [](double value) { return value > 0 && value < kLargest; };
    if (!is_rigid(s.local) || !(s.rounding_m >= 0 && s.rounding_m < kLargest)) return false;
    switch (s.kind) {
        case ConvexShape::Kind::box:
            return sound(s.half_extents_m.x) && sound(s.half_extents_m.y) &&
                   sound(s.half_extents_m.z);
        case ConvexShape::Kind::sphere:
            return sound(s.radius_m);
        case ConvexShape::Kind::capsule:
            return sound(s.radius_m) && s.half_height_m >= 0 && s.half_height_m < kLargest;
        case ConvexShape::Kind::cylinder:
        case ConvexShape::Kind::cone:
            return sound(s.radius_m) && sound(s.half_height_m);
        case ConvexShape::Kind::hull:
            return s.planes.size() >= 4 && s.planes.size() <= limits::kHullPlaneCapacity &&
                   sound(s.bound_m) &&
                   std::all_of(s.planes.begin(), s.planes.end(), [](const Plane& p) {
                       return is_finite(p.normal) && std::abs(length(p.normal) - 1) < 1e-3 &&
                              std::isfinite(p.offset);
                   });
        case ConvexShape::Kind::lattice:
            return s.lattice != nullptr;
    }
    return false;
}

bool contains(const ConvexShape& s, Vec3 p) {
    const auto radius = [&] { return std::hypot(p.x, p.y); };  // boxes and hulls need none
    switch (s.kind) {
        case ConvexShape::Kind::box:
            return std::abs(p.x) <= s.half_extents_m.x && std::abs(p.y) <= s.half_extents_m.y &&
                   std::abs(p.z) <= s.half_extents_m.z;
        case ConvexShape::Kind::sphere:
            return length(p) <= s.radius_m;
        case ConvexShape::Kind::capsule:
            return std::hypot(radius(), p.z - std::clamp(p.z, -s.half_height_m, s.half_height_m)) <=
                   s.radius_m;
        case ConvexShape::Kind::cylinder:
            return radius() <= s.radius_m && std::abs(p.z) <= s.half_height_m;
        case ConvexShape::Kind::cone:
            return p.z >= -s.half_height_m &&
                   radius() <= s.radius_m * (s.half_height_m - p.z) / (2 * s.half_height_m);
        case ConvexShape::Kind::hull:
            return std::all_of(s.planes.begin(), s.planes.end(), [&](const Plane& plane) {
                return dot(plane.normal, p) <= plane.offset;
            });
        case ConvexShape::Kind::lattice:
            return s.lattice->distance_m(p) <= 0;
    }
    return false;
}

Aabb merge(const Aabb& a, const Aabb& b) {
    return {{std::min(a.min.x, b.min.x), std::min(a.min.y, b.min.y), std::min(a.min.z, b.min.z)},
            {std::max(a.max.x, b.max.x), std::max(a.max.y, b.max.y), std::max(a.max.z, b.max.z)}};
}

int clamped_floor(double value, int low, int high) {
    return static_cast<int>(
        std::floor(std::clamp(value, static_cast<double>(low), static_cast<double>(high))));
}

}  // namespace bsoil
