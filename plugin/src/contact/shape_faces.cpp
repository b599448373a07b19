#include "contact/shape_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bsoil/distance_lattice.h"

namespace bsoil {
namespace {

Vec3 unit_or(Vec3 v, Vec3 otherwise) {
    const double size = length(v);
    return size > 0 ? v * (1 / size) : otherwise;
}

NearestFace higher(const NearestFace& a, const NearestFace& b) {
    return a.distance_m >= b.distance_m ? a : b;
}

NearestFace box_face(Vec3 half, Vec3 p) {
    const auto face = [](double at, double half_extent, Vec3 axis) {
        return NearestFace{std::abs(at) - half_extent, at < 0 ? -axis : axis};
    };
    return higher(face(p.x, half.x, {1, 0, 0}),
                  higher(face(p.y, half.y, {0, 1, 0}), face(p.z, half.z, {0, 0, 1})));
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
    const Vec3 up{0, 0, 1};
    const double r = shape.radius_m, h = shape.half_height_m;
    const Vec3 radial{p.x, p.y, 0};
    NearestFace face;
    switch (shape.kind) {
        case ConvexShape::Kind::box:
            face = box_face(shape.half_extents_m, p);
            break;
        case ConvexShape::Kind::sphere:
            face = {length(p) - r, unit_or(p, up)};
            break;
        case ConvexShape::Kind::capsule: {
            const Vec3 off = radial + Vec3{0, 0, p.z - std::clamp(p.z, -h, h)};
            face = {length(off) - r, unit_or(off, {1, 0, 0})};
            break;
        }
        case ConvexShape::Kind::cylinder:
            face = higher({length(radial) - r, unit_or(radial, {1, 0, 0})},
                          {std::abs(p.z) - h, p.z < 0 ? -up : up});
            break;
        case ConvexShape::Kind::cone: {
            const double slant = std::hypot(r, 2 * h);
            const double c = 2 * h / slant, s = r / slant;
            face = higher(
                {length(radial) * c + (p.z - h) * s, c * unit_or(radial, {1, 0, 0}) + s * up},
                {-h - p.z, -up});
            break;
        }
        case ConvexShape::Kind::hull:
            face.distance_m = -std::numeric_limits<double>::infinity();
            for (const Plane& plane : shape.planes)
                face = higher(face, {dot(plane.normal, p) - plane.offset, plane.normal});
            break;
        case ConvexShape::Kind::lattice: {
            const DistanceLattice::Face nearest = shape.lattice->nearest_face(p);
            face = {nearest.distance_m, nearest.normal};
            break;
        }
    }
    face.distance_m -= shape.rounding_m;
    return face;
}

void BodyFaces::place(const SoilBody& body, const WallShapes& walls) {
    parts_.clear();
    thickest_m_ = 0;
    for (size_t i = 0; i < body.shapes->size(); ++i) {
        const ConvexShape& shape = (*body.shapes)[i];
        const Pose to_world = body.pose * shape.local;
        const double thick_m = shape_thickness_m(shape) + walls.growth[i].growth_m;
        parts_.push_back({&shape, &walls.growth[i], to_world, inverse(to_world), thick_m});
        thickest_m_ = std::max(thickest_m_, thick_m);
    }
}

NearestFace BodyFaces::nearest(Vec3 point_m, double thin_m) const {
    NearestFace nearest{std::numeric_limits<double>::infinity(), {0, 0, 1}};
    for (const Part& part : parts_) {
        if (part.thickness_m < thin_m && thickest_m_ >= thin_m) continue;
        const NearestFace face = nearest_face(*part.shape, transform(part.to_shape, point_m));
        if (std::abs(face.distance_m) < std::abs(nearest.distance_m))
            nearest = {face.distance_m, rotate(part.to_world.rotation, face.normal),
                       rotate(part.to_world.rotation, part.growth->normal),
                       part.growth->is_thin() ? part.growth->rim_share() : 1};
    }
    return nearest;
}

}  // namespace bsoil
