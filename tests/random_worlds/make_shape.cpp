#include "make_shape.h"

#include <algorithm>

namespace bsoil::random_worlds {
namespace {

using Kind = ShapePlan::Kind;

/// Thinnest part of a shape, as a share of its bound.
constexpr double kSlim = 0.3;

ShapePlan sized(Random& random, Kind kind, double bound_m) {
    ShapePlan shape;
    shape.kind = kind;
    shape.axis = random.integer(0, 2);
    const double most = bound_m / 1.7321;
    shape.half_m = {random.uniform(kSlim, 1) * most, random.uniform(kSlim, 1) * most,
                    random.uniform(kSlim, 1) * most};
    // Of a capsule half_m.z is half the segment.
    if (kind == Kind::capsule) shape.half_m = shape.half_m * 0.8;
    if (kind == Kind::sphere) shape.half_m.x = bound_m * random.uniform(0.5, 1);
    return shape;
}

/// Points on a ball, so that each is a corner of the hull.
ShapePlan cloud(Random& random, Kind kind, double bound_m) {
    ShapePlan shape;
    shape.kind = kind;
    shape.margin_m = 0.02 * bound_m;
    for (int corner = 0; corner < 4; ++corner) {  // a tetrahedron: it never is flat
        const Vec3 v{(corner & 1) != 0 ? 0.55 : -0.55, (corner & 2) != 0 ? 0.55 : -0.55,
                     corner == 1 || corner == 2 ? -0.55 : 0.55};
        shape.points_m.push_back(v * bound_m);
    }
    for (int i = random.integer(0, 8); i > 0; --i) {
        shape.points_m.push_back(random.direction() * (0.95 * bound_m));
    }
    return shape;
}

/// A closed mesh: a prism with as many sides.
ShapePlan prism(Random& random, Kind kind, double bound_m) {
    ShapePlan shape;
    shape.kind = kind;
    shape.margin_m = 0.02 * bound_m;
    shape.half_m = {1, 1, 1};
    const int sides = random.integer(3, 9);
    const double radius = 0.7 * bound_m, half = random.uniform(0.3, 0.68) * bound_m;
    for (int i = 0; i < 2 * sides; ++i) {
        const double angle = 2 * 3.14159265358979 * (i / 2) / sides;
        shape.points_m.push_back(
            {radius * std::cos(angle), radius * std::sin(angle), (i & 1) != 0 ? half : -half});
    }
    const auto add = [&shape](int a, int b, int c) {
        shape.indices.insert(shape.indices.end(), {a, b, c});
    };
    for (int i = 0; i < sides; ++i) {
        const int j = (i + 1) % sides;
        add(2 * i, 2 * j, 2 * j + 1);
        add(2 * i, 2 * j + 1, 2 * i + 1);
        if (i > 0 && j > 0) add(0, 2 * j, 2 * i), add(1, 2 * i + 1, 2 * j + 1);
    }
    return shape;
}

/// A wavy open sheet of 4 x 4 squares.
ShapePlan sheet(Random& random, double bound_m) {
    ShapePlan shape;
    shape.kind = Kind::open_mesh;
    constexpr int kSide = 5;
    for (int i = 0; i < kSide * kSide; ++i) {
        shape.points_m.push_back({0.3 * bound_m * (i % kSide - 2), 0.3 * bound_m * (i / kSide - 2),
                                  0.2 * bound_m * random.uniform(-1, 1)});
    }
    for (int y = 0; y + 1 < kSide; ++y) {
        for (int x = 0; x + 1 < kSide; ++x) {
            const int i = y * kSide + x;
            shape.indices.insert(shape.indices.end(),
                                 {i, i + 1, i + kSide, i + 1, i + kSide + 1, i + kSide});
        }
    }
    return shape;
}

ShapePlan of_children(Random& random, Kind kind, double bound_m) {
    ShapePlan shape;
    shape.kind = kind;
    if (kind == Kind::scaled) {
        shape.half_m.x = random.uniform(0.5, 2);
        shape.children.push_back(sized(random,
                                       random.choose({Kind::box, Kind::cylinder, Kind::sphere}),
                                       bound_m / shape.half_m.x));
        shape.child_poses.emplace_back();
    } else if (kind == Kind::minkowski_sum) {
        shape.children.push_back(sized(random, Kind::box, 0.6 * bound_m));
        shape.children.push_back(sized(random, Kind::sphere, 0.35 * bound_m));
        shape.child_poses.resize(2);
    } else {  // the first child holds the origin
        const int count = random.integer(2, 4);
        for (int i = 0; i < count; ++i) {
            shape.children.push_back(sized(
                random,
                random.choose({Kind::box, Kind::sphere, Kind::cylinder, Kind::capsule, Kind::cone}),
                bound_m * 0.5));
            shape.child_poses.push_back(
                {i == 0 ? Vec3{} : random.direction() * (0.5 * bound_m), random.rotation()});
        }
    }
    return shape;
}

ShapePlan spheres(Random& random, double bound_m) {
    ShapePlan shape;
    shape.kind = Kind::multi_sphere;
    const int count = random.integer(2, 3);
    for (int i = 0; i < count; ++i) {
        shape.numbers_m.push_back(random.uniform(0.3, 0.45) * bound_m);
        shape.points_m.push_back(random.direction() * (0.5 * bound_m));
    }
    return shape;
}

ShapePlan field(Random& random, double extent_m, double height_m) {
    ShapePlan shape;
    shape.kind = Kind::heightfield;
    shape.side_count = random.integer(4, 12);
    const double spacing = 1.2 * extent_m / (shape.side_count - 1);
    shape.half_m = {spacing, spacing, 1};
    for (int i = 0; i < shape.side_count * shape.side_count; ++i) {
        shape.numbers_m.push_back(random.uniform(-0.5, 0.5) * height_m);
    }
    return shape;
}

}  // namespace

ShapePlan make_moving_shape(Random& random, double bound_m) {
    const Kind kind =
        random.choose({Kind::box, Kind::box, Kind::sphere, Kind::capsule, Kind::cylinder,
                       Kind::cone, Kind::hull, Kind::point_cloud, Kind::multi_sphere, Kind::scaled,
                       Kind::minkowski_sum, Kind::compound, Kind::compound, Kind::moving_mesh});
    switch (kind) {
        case Kind::hull:
        case Kind::point_cloud:
            return cloud(random, kind, bound_m);
        case Kind::multi_sphere:
            return spheres(random, bound_m);
        case Kind::scaled:
        case Kind::minkowski_sum:
        case Kind::compound:
            return of_children(random, kind, bound_m);
        case Kind::moving_mesh:
            return prism(random, kind, bound_m);
        default:
            return sized(random, kind, bound_m);
    }
}

ShapePlan make_fixed_shape(Random& random, double bound_m, double extent_m) {
    ShapePlan shape;
    switch (random.integer(0, 8)) {
        case 0:
            return prism(random, Kind::triangle_mesh, bound_m);
        case 1:
            shape = prism(random, Kind::scaled_triangle_mesh, bound_m);
            shape.half_m = {random.uniform(0.5, 1), random.uniform(0.5, 1), random.uniform(0.5, 1)};
            return shape;
        case 2:
            return sheet(random, bound_m);
        case 3:
            return field(random, extent_m, bound_m);
        case 4: {
            shape.kind = Kind::plane;
            const Vec3 n{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 1};
            shape.half_m = n * (1 / length(n));
            return shape;
        }
        case 5:
            shape.kind = Kind::triangle;
            shape.margin_m = 0.05 * bound_m;
            shape.points_m = {random.direction() * bound_m, random.direction() * bound_m,
                              random.direction() * bound_m};
            if (length(cross(shape.points_m[1] - shape.points_m[0],
                             shape.points_m[2] - shape.points_m[0])) < 0.1 * bound_m * bound_m) {
                return sized(random, Kind::box, bound_m);
            }
            return shape;
        default:
            return make_moving_shape(random, bound_m);
    }
}

}  // namespace bsoil::random_worlds
