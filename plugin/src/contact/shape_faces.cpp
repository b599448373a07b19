#include "contact/shape_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "bsoil/distance_lattice.h"

namespace bsoil {
namespace {

Vec3 unit_or(Vec3 v, Vec3 otherwise) {
    const double size = length(v);
    return size > 0 ? v * (1 / size) : otherwise;
}

/// Distance above a face, and its normal.
struct Height {
    double m;
    Vec3 normal;
};

Height higher(const Height& a, const Height& b) { return a.m >= b.m ? a : b; }

Height box_face(Vec3 half, Vec3 p) {
    const double x = std::abs(p.x) - half.x, y = std::abs(p.y) - half.y, z = std::abs(p.z) - half.z;
    if (x >= y && x >= z) return {x, {p.x < 0 ? -1.0 : 1.0, 0, 0}};
    if (y >= z) return {y, {0, p.y < 0 ? -1.0 : 1.0, 0}};
    return {z, {0, 0, p.z < 0 ? -1.0 : 1.0}};
}

Height hull_face(std::span<const Plane> planes, Vec3 p) {
    double most = -std::numeric_limits<double>::infinity();
    Vec3 normal;
    for (const Plane& plane : planes) {
        const double height_m = dot(plane.normal, p) - plane.offset;
        if (height_m <= most) continue;
        most = height_m;
        normal = plane.normal;
    }
    return {most, normal};
}

Height face_of_core(const ConvexShape& shape, Vec3 p) {
    const Vec3 up{0, 0, 1};
    const double r = shape.radius_m, h = shape.half_height_m;
    const Vec3 radial{p.x, p.y, 0};
    switch (shape.kind) {
        case ConvexShape::Kind::box:
            return box_face(shape.half_extents_m, p);
        case ConvexShape::Kind::sphere:
            return {length(p) - r, unit_or(p, up)};
        case ConvexShape::Kind::capsule: {
            const Vec3 off = radial + Vec3{0, 0, p.z - std::clamp(p.z, -h, h)};
            return {length(off) - r, unit_or(off, {1, 0, 0})};
        }
        case ConvexShape::Kind::cylinder:
            return higher({length(radial) - r, unit_or(radial, {1, 0, 0})},
                          {std::abs(p.z) - h, p.z < 0 ? -up : up});
        case ConvexShape::Kind::cone: {
            const double slant = std::hypot(r, 2 * h);
            const double c = 2 * h / slant, s = r / slant;
            return higher(
                {length(radial) * c + (p.z - h) * s, c * unit_or(radial, {1, 0, 0}) + s * up},
                {-h - p.z, -up});
        }
        case ConvexShape::Kind::hull:
            return hull_face(shape.planes, p);
        case ConvexShape::Kind::lattice: {
            const DistanceLattice::Face nearest = shape.lattice->nearest_face(p);
            return {nearest.distance_m, nearest.normal};
        }
    }
    return {0, up};
}

/// nearest_face() is at least `share` of the way by which a point lies farther than `radius_m` from
/// the shape's origin.
struct Bound {
    double radius_m = 0, share = 0;
};

Bound bound_of(const ConvexShape& shape) {
    const double r = shape.radius_m, h = shape.half_height_m;
    switch (shape.kind) {
        case ConvexShape::Kind::box:  // of a point off a corner, its largest part
            return {length(shape.half_extents_m), 1 / std::numbers::sqrt3};
        case ConvexShape::Kind::sphere:
            return {r, 1};
        case ConvexShape::Kind::capsule:
            return {r + h, 1};
        case ConvexShape::Kind::cylinder:
            return {std::hypot(r, h), 1 / std::numbers::sqrt2};
        case ConvexShape::Kind::hull: {
            // The plane through which the ray from the origin leaves rises by its offset over the
            // way there.
            double least = shape.bound_m;
            for (const Plane& plane : shape.planes) least = std::min(least, plane.offset);
            return least > 0 ? Bound{shape.bound_m, least / shape.bound_m} : Bound{};
        }
        case ConvexShape::Kind::cone:
        case ConvexShape::Kind::lattice:
            break;
    }
    return {};
}

}  // namespace

double shape_thickness_m(const ConvexShape& shape) {
    if (shape.kind == ConvexShape::Kind::lattice) {
        const Vec3 size = shape.lattice->bounds().max - shape.lattice->bounds().min;
        return std::min({size.x, size.y, size.z}) + 2 * shape.rounding_m;
    }
    const Vec3 half = shape.half_extents_m;
    const double core =
        shape.kind == ConvexShape::Kind::box    ? std::min({half.x, half.y, half.z})
        : shape.kind == ConvexShape::Kind::hull ? shape.bound_m
        : shape.kind == ConvexShape::Kind::cylinder || shape.kind == ConvexShape::Kind::cone
            ? std::min(shape.radius_m, shape.half_height_m)
            : shape.radius_m;
    return 2 * (core + shape.rounding_m);
}

NearestFace nearest_face(const ConvexShape& shape, Vec3 p) {
    const Height face = face_of_core(shape, p);
    return {face.m - shape.rounding_m, face.normal};
}

void BodyFaces::place(const SoilBody& body, const WallShapes& walls) {
    parts_.clear();
    thickest_m_ = 0;
    for (size_t i = 0; i < body.shapes->size(); ++i) {
        const ConvexShape& shape = (*body.shapes)[i];
        const Pose to_world = body.pose * shape.local;
        const double thick_m = shape_thickness_m(shape) + walls.growth[i].growth_m;
        const Bound bound = bound_of(shape);
        parts_.push_back({&shape, &walls.growth[i], to_world, inverse(to_world), thick_m,
                          bound.radius_m, bound.share});
        thickest_m_ = std::max(thickest_m_, thick_m);
    }
}

BodyFaces::Found BodyFaces::find(Vec3 point_m, double thin_m) const {
    double least_m = std::numeric_limits<double>::infinity();
    Found found{nullptr, {least_m, {0, 0, 1}}};
    for (const Part& part : parts_) {
        if (part.thickness_m < thin_m && thickest_m_ >= thin_m) continue;
        if (found.part) {
            const double off_m = length(point_m - part.to_world.position) - part.bound_m;
            // Farther than the nearest, by more than rounding.
            const double least_off_m = off_m * part.bound_share - part.shape->rounding_m;
            if (least_off_m > least_m * (1 + 1e-9)) continue;
        }
        const NearestFace its = nearest_face(*part.shape, transform(part.to_shape, point_m));
        if (std::abs(its.distance_m) < least_m) {
            least_m = std::abs(its.distance_m);
            found = {&part, its};
        }
    }
    return found;
}

NearestFace BodyFaces::in_world(const Found& found) {
    NearestFace face = found.face;
    if (!found.part) return face;
    face.normal = rotate(found.part->to_world.rotation, face.normal);
    if (found.part->growth->is_thin()) {
        face.sheet_normal = rotate(found.part->to_world.rotation, found.part->growth->normal);
        face.rim_share = found.part->growth->rim_share();
    }
    return face;
}

NearestFace BodyFaces::nearest(Vec3 point_m, double thin_m) const {
    return in_world(find(point_m, thin_m));
}

std::optional<NearestFace> BodyFaces::nearest_below(Vec3 point_m, double thin_m,
                                                    double least_m) const {
    const Found found = find(point_m, thin_m);
    if (!(found.face.distance_m > least_m)) return {};
    return in_world(found);
}

}  // namespace bsoil
