/// The face of a body that a point is nearest to.
#include "contact/shape_faces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

namespace {
using namespace bsoil;
using Kind = ConvexShape::Kind;

/// A cube with some corners cut off.
ConvexShape random_hull(std::mt19937& random) {
    std::uniform_real_distribution<double> unit(-1, 1), offset(0.1, 0.6);
    ConvexShape shape;
    shape.kind = Kind::hull;
    for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        for (const double sign : {-1.0, 1.0}) shape.planes.push_back({sign * axis, 0.6});
    }
    for (int i = 0; i < 5; ++i) {
        const Vec3 n{unit(random), unit(random), unit(random)};
        shape.planes.push_back({n * (1 / length(n)), offset(random)});
    }
    shape.bound_m = 0.6 * std::sqrt(3.0);
    return shape;
}

ConvexShape random_shape(std::mt19937& random) {
    constexpr Kind kKinds[] = {Kind::box,      Kind::sphere, Kind::capsule,
                               Kind::cylinder, Kind::cone,   Kind::hull};
    std::uniform_real_distribution<double> place(-1, 1), size(0.05, 0.8), angle(-3, 3);
    const Kind kind = kKinds[random() % std::size(kKinds)];
    ConvexShape shape = kind == Kind::hull ? random_hull(random) : ConvexShape{};
    shape.kind = kind;
    shape.half_extents_m = {size(random), size(random), size(random)};
    shape.radius_m = size(random);
    shape.half_height_m = size(random);
    shape.rounding_m = random() % 2 == 0 ? 0.02 : 0;
    const double half = angle(random) / 2;
    shape.local = {{place(random), place(random), place(random)},
                   {0, std::sin(half), 0, std::cos(half)}};
    return shape;
}

TEST(BodyFaces, nearest_of_all_parts_whichever_are_passed_over) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-3, 3);
    for (int run = 0; run < 100; ++run) {
        SoilBody body;
        std::vector<ConvexShape> shapes;
        for (int i = 0; i < 6; ++i) shapes.push_back(random_shape(random));
        body.shapes = &shapes;
        body.pose = {{place(random), 0.5, place(random)}, {0, 0, std::sin(0.3), std::cos(0.3)}};
        WallShapes walls;
        walls.growth.resize(shapes.size());
        BodyFaces faces;
        faces.place(body, walls);
        for (int i = 0; i < 200; ++i) {
            const Vec3 at{place(random), place(random), place(random)};
            double least_m = std::numeric_limits<double>::infinity();
            Vec3 normal;
            for (const ConvexShape& shape : shapes) {
                const Pose to_world = body.pose * shape.local;
                const NearestFace face = nearest_face(shape, transform(inverse(to_world), at));
                if (std::abs(face.distance_m) >= std::abs(least_m)) continue;
                least_m = face.distance_m;
                normal = rotate(to_world.rotation, face.normal);
            }
            const NearestFace found = faces.nearest(at, 0);
            ASSERT_EQ(found.distance_m, least_m);
            ASSERT_EQ(length(found.normal - normal), 0);
            const std::optional<NearestFace> below = faces.nearest_below(at, 0, 0.5);
            ASSERT_EQ(below.has_value(), least_m > 0.5);
            if (!below) continue;
            ASSERT_EQ(length(below->normal - normal), 0);
        }
    }
}

}  // namespace
