#include "shape_distance.h"

#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bsoil/distance_lattice.h"
#include "bullet_types.h"

namespace bsoil::bullet {
namespace {

/// Distance to an intersection of half spaces, by Dykstra's alternating projections. Of points that
/// are further than `clear_m` from one of them, so far: the hull is no nearer.
double distance_to_hull(const std::vector<Plane>& planes, Vec3 p, double clear_m) {
    double deepest = -std::numeric_limits<double>::infinity();
    for (const Plane& plane : planes) {
        deepest = std::max(deepest, dot(plane.normal, p) - plane.offset);
    }
    if (deepest <= 0 || deepest > clear_m) return deepest;
    std::vector<double> push(planes.size(), 0);
    Vec3 x = p;
    for (int sweep = 0; sweep < 3000; ++sweep) {
        double change = 0;
        for (size_t i = 0; i < planes.size(); ++i) {
            const double over = dot(planes[i].normal, x) + push[i] - planes[i].offset;
            const double next = std::max(0.0, over);
            x += (push[i] - next) * planes[i].normal;
            change = std::max(change, std::abs(push[i] - next));
            push[i] = next;
        }
        if (change < 1e-9) break;
    }
    return length(p - x);
}

/// Signed distance of a point to a cone or a cylinder, in the half plane (distance from the axis,
/// height), as a polygon.
double distance_to_profile(const std::vector<std::pair<double, double>>& edges_from_axis, double r,
                           double z) {
    double outside = std::numeric_limits<double>::infinity();
    bool is_inside = true;
    for (size_t i = 0; i + 1 < edges_from_axis.size(); ++i) {
        const auto [r0, z0] = edges_from_axis[i];
        const auto [r1, z1] = edges_from_axis[i + 1];
        const double dr = r1 - r0, dz = z1 - z0;
        const double t =
            std::clamp(((r - r0) * dr + (z - z0) * dz) / (dr * dr + dz * dz), 0.0, 1.0);
        outside = std::min(outside, std::hypot(r - r0 - t * dr, z - z0 - t * dz));
        if (dr * (z - z0) - dz * (r - r0) < 0) is_inside = false;
    }
    return is_inside ? -outside : outside;
}

double distance_to(const ConvexShape& s, Vec3 body_point) {
    const Vec3 p = transform(inverse(s.local), body_point);
    const double r = std::hypot(p.x, p.y);
    double d = 0;
    switch (s.kind) {
        case ConvexShape::Kind::box: {
            const Vec3 q{std::abs(p.x) - s.half_extents_m.x, std::abs(p.y) - s.half_extents_m.y,
                         std::abs(p.z) - s.half_extents_m.z};
            const Vec3 out{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)};
            d = length(out) + std::min(0.0, std::max({q.x, q.y, q.z}));
            break;
        }
        case ConvexShape::Kind::sphere:
            d = length(p) - s.radius_m;
            break;
        case ConvexShape::Kind::capsule:
            d = length(p - Vec3{0, 0, std::clamp(p.z, -s.half_height_m, s.half_height_m)}) -
                s.radius_m;
            break;
        case ConvexShape::Kind::cylinder:
            d = distance_to_profile({{0, -s.half_height_m},
                                     {s.radius_m, -s.half_height_m},
                                     {s.radius_m, s.half_height_m},
                                     {0, s.half_height_m}},
                                    r, p.z);
            break;
        case ConvexShape::Kind::cone:
            d = distance_to_profile(
                {{0, -s.half_height_m}, {s.radius_m, -s.half_height_m}, {0, s.half_height_m}}, r,
                p.z);
            break;
        case ConvexShape::Kind::hull:
            d = distance_to_hull(s.planes, p, s.rounding_m);
            break;
        case ConvexShape::Kind::lattice:
            d = s.lattice->distance_m(p);
            break;
    }
    return d - s.rounding_m;
}

}  // namespace

double signed_distance(const std::vector<ConvexShape>& shapes, Vec3 body_point) {
    double d = std::numeric_limits<double>::infinity();
    for (const ConvexShape& s : shapes) d = std::min(d, distance_to(s, body_point));
    return d;
}

double bullet_distance(const btConvexShape& shape, const btTransform& pose, Vec3 point) {
    using Solver = btGjkEpaSolver2;
    const btSphereShape dot_shape(0);
    const btTransform at(btQuaternion::getIdentity(), to_bullet(point));
    double nearest = std::numeric_limits<double>::infinity();
    for (const btVector3& guess :
         {btVector3(1, 1, 1), btVector3(-1, 0.3f, 0), btVector3(0, -1, -0.7f)}) {
        Solver::sResults results;
        double d = nearest;
        if (Solver::Distance(&shape, pose, &dot_shape, at, guess, results)) {
            d = static_cast<double>(results.distance - shape.getMargin());
        } else if (Solver::Penetration(&shape, pose, &dot_shape, at, guess, results)) {
            d = -static_cast<double>((results.witnesses[0] - results.witnesses[1]).length());
        }
        nearest = std::min(nearest, d);
    }
    return nearest;
}

}  // namespace bsoil::bullet
