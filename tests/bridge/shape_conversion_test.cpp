// Every converted shape against Bullet's own signed distance, at random points and poses.
#include "shape_conversion.h"

#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>
#include <BulletCollision/CollisionShapes/btMinkowskiSumShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <btBulletCollisionCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <set>

#include "bsoil/limits.h"
#include "bullet_types.h"
#include "cure.h"
#include "lowest_point.h"
#include "shape_distance.h"

namespace bsoil::bullet::shape_conversion_test {
namespace {

constexpr int kPointCount = 4000;
constexpr int kPoseCount = 4;
/// Bullet's solver was seen to be off by 4e-4 at these sizes; points nearer to the surface are not
/// judged.
constexpr double kSurfaceBand_m = 1e-3;
/// Bullet rounds the edges of a box and a cylinder by their margin, the table does not: with this
/// one the two differ by less than the band.
constexpr btScalar kThinMargin_m = 5e-4f;

const GridBall kGrid{{0, 0, 0}, 10};

btTransform random_pose(std::mt19937& random) {
    std::uniform_real_distribution<double> u(-1, 1);
    btQuaternion q(btScalar(u(random)), btScalar(u(random)), btScalar(u(random)),
                   btScalar(u(random) + 1.5));
    q.normalize();
    return btTransform(q, to_bullet({u(random), u(random), u(random)}));
}

struct Agreement {
    int judged = 0, inside = 0, wrong = 0;
};

/// Compares the inside tests of points in and around the shape. Points that Bullet puts between the
/// surface and `swell_m` outside of it may count as inside.
Agreement compare(const btConvexShape& shape, double swell_m = 0, double band_m = kSurfaceBand_m,
                  const GridBall& grid = kGrid) {
    const auto converted = convert_shape(shape, grid);
    EXPECT_TRUE(converted) << converted.error();
    if (!converted) return {};
    std::mt19937 random(7);
    Agreement out;
    for (int k = 0; k < kPoseCount; ++k) {
        const btTransform pose = random_pose(random);
        const Pose to_world = from_bullet(pose);
        btVector3 low, high;
        shape.getAabb(btTransform::getIdentity(), low, high);
        const Vec3 center = 0.5 * (from_bullet(low) + from_bullet(high));
        const Vec3 half = 0.6 * (from_bullet(high) - from_bullet(low));
        std::uniform_real_distribution<double> u(-1, 1);
        for (int i = 0; i < kPointCount; ++i) {
            const Vec3 p =
                center + Vec3{half.x * u(random), half.y * u(random), half.z * u(random)};
            const double expected = bullet_distance(shape, pose, transform(to_world, p));
            if (std::isinf(expected) || std::abs(expected) < band_m) continue;
            if (expected > 0 && expected < swell_m) continue;
            ++out.judged;
            const bool is_inside = signed_distance(*converted, p) < 0;
            out.inside += is_inside ? 1 : 0;
            if (is_inside != (expected < 0)) ++out.wrong;
        }
    }
    return out;
}

void expect_agreement(const btConvexShape& shape, double swell_m = 0,
                      double band_m = kSurfaceBand_m, const GridBall& grid = kGrid) {
    SCOPED_TRACE(shape.getName());
    const Agreement a = compare(shape, swell_m, band_m, grid);
    // The solver gives up on single points near the middle of a shape.
    EXPECT_GT(a.judged, kPointCount * kPoseCount * 7 / 10);
    EXPECT_GT(a.inside, kPointCount * kPoseCount / 20);
    EXPECT_LT(a.inside, a.judged);
    EXPECT_EQ(a.wrong, 0) << "of " << a.judged;
}

std::vector<btVector3> random_points(int count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(-0.4, 0.4);
    std::vector<btVector3> out;
    for (int i = 0; i < count; ++i) {
        out.push_back(to_bullet({u(random) + 0.3, 0.7 * u(random), u(random)}));
    }
    return out;
}

TEST(ShapeConversion, box_agrees_with_bullet) {
    btBoxShape box(btVector3(0.3f, 0.2f, 0.5f));
    box.setMargin(kThinMargin_m);
    expect_agreement(box);
}

TEST(ShapeConversion, margin_of_a_box_lies_inside_its_extents) {
    btBoxShape box(btVector3(0.3f, 0.2f, 0.5f));
    const auto converted = convert_shape(box, kGrid);
    ASSERT_TRUE(converted);
    EXPECT_NEAR(converted->front().half_extents_m.x, 0.3, 1e-6);
    EXPECT_NEAR(converted->front().half_extents_m.y, 0.2, 1e-6);
    EXPECT_EQ(converted->front().rounding_m, 0);
}

TEST(ShapeConversion, sphere_agrees_with_bullet) { expect_agreement(btSphereShape(0.4f)); }

TEST(ShapeConversion, capsules_agree_with_bullet) {
    expect_agreement(btCapsuleShape(0.2f, 0.5f));
    expect_agreement(btCapsuleShapeX(0.2f, 0.5f));
    expect_agreement(btCapsuleShapeZ(0.2f, 0.5f));
}

TEST(ShapeConversion, cylinders_agree_with_bullet) {
    btCylinderShape y(btVector3(0.3f, 0.5f, 0.3f));
    btCylinderShapeX x(btVector3(0.5f, 0.3f, 0.3f));
    btCylinderShapeZ z(btVector3(0.3f, 0.3f, 0.15f));
    for (btCylinderShape* c :
         {&y, static_cast<btCylinderShape*>(&x), static_cast<btCylinderShape*>(&z)}) {
        c->setMargin(kThinMargin_m);
        expect_agreement(*c);
    }
}

TEST(ShapeConversion, cones_agree_with_bullet) {
    expect_agreement(btConeShape(0.3f, 0.6f));
    expect_agreement(btConeShapeX(0.3f, 0.6f));
    expect_agreement(btConeShapeZ(0.3f, 0.6f));
}

TEST(ShapeConversion, scaled_shapes_agree_with_bullet) {
    btBoxShape box(btVector3(0.3f, 0.2f, 0.5f));
    box.setLocalScaling(btVector3(1.5f, 0.5f, 1));
    box.setMargin(kThinMargin_m);
    expect_agreement(box);
    btConeShape cone(0.3f, 0.6f);
    cone.setLocalScaling(btVector3(1.5f, 1.5f, 1.5f));
    expect_agreement(cone);
    btCapsuleShape capsule(0.2f, 0.5f);
    capsule.setLocalScaling(btVector3(1.3f, 1.3f, 1.3f));
    expect_agreement(capsule);
}

TEST(ShapeConversion, convex_hull_agrees_with_bullet_margin_included) {
    btConvexHullShape hull;
    for (const btVector3& p : random_points(14, 3)) hull.addPoint(p);
    hull.setLocalScaling(btVector3(1, 1.4f, 0.8f));
    hull.setMargin(0.04f);
    expect_agreement(hull);
    hull.setMargin(0);
    expect_agreement(hull);
}

TEST(ShapeConversion, hull_has_the_faces_that_trying_every_triple_finds) {
    for (unsigned seed = 1; seed < 20; ++seed) {
        const std::vector<btVector3> points = random_points(20, seed);
        btConvexHullShape shape;
        for (const btVector3& p : points) shape.addPoint(p);
        const auto converted = convert_shape(shape, kGrid);
        ASSERT_TRUE(converted);
        size_t face_count = 0;
        for (const btVector3& a : points) {
            for (const btVector3& b : points) {
                for (const btVector3& c : points) {
                    if (!(&a < &b && &a < &c) || &b == &c) continue;
                    const btVector3 n = (b - a).cross(c - a).normalized();
                    const bool is_face = std::all_of(
                        points.begin(), points.end(),
                        [&](const btVector3& p) { return n.dot(p - a) < btScalar(1e-6); });
                    face_count += is_face ? 1 : 0;
                }
            }
        }
        EXPECT_EQ(converted->front().planes.size(), face_count) << "seed " << seed;
    }
}

TEST(ShapeConversion, faces_of_a_cube_are_merged) {
    btConvexHullShape hull;
    for (int i = 0; i < 8; ++i) {
        hull.addPoint(btVector3(i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f));
    }
    const auto converted = convert_shape(hull, kGrid);
    ASSERT_TRUE(converted);
    EXPECT_EQ(converted->front().planes.size(), 6u);
    EXPECT_NEAR(converted->front().bound_m, std::sqrt(0.75), 1e-6);
}

TEST(ShapeConversion, point_cloud_agrees_with_bullet) {
    std::vector<btVector3> points = random_points(20, 5);
    btConvexPointCloudShape cloud(points.data(), static_cast<int>(points.size()),
                                  btVector3(1, 1, 1));
    expect_agreement(cloud);
}

TEST(ShapeConversion, hull_with_too_many_faces_is_enclosed) {
    btConvexHullShape hull;
    std::mt19937 random(11);
    std::normal_distribution<double> g;
    for (int i = 0; i < 400; ++i) {
        const Vec3 p{g(random), g(random), g(random)};
        hull.addPoint(to_bullet(p * (0.4 / length(p))));
    }
    hull.setMargin(0);
    const auto converted = convert_shape(hull, kGrid);
    ASSERT_TRUE(converted);
    EXPECT_LE(converted->front().planes.size(), static_cast<size_t>(limits::kHullPlaneCapacity));
    expect_agreement(hull, 0.03 * 0.4);
}

TEST(ShapeConversion, multi_sphere_agrees_with_bullet) {
    const btVector3 centers[3] = {{0, 0, 0}, {0.5f, 0.1f, 0}, {0.1f, 0.3f, 0.4f}};
    const btScalar radii[3] = {0.3f, 0.15f, 0.2f};
    const btMultiSphereShape shape(centers, radii, 3);
    // Between points s apart a sphere of radius R is off by s^2 / (4 R): 1.0 mm at half of 50 mm,
    // 0.2 mm at half of 20 mm. The polyhedron is off by 0.3 mm.
    expect_agreement(shape, 0, 1.5e-3);
    expect_agreement(shape, 0, kSurfaceBand_m, {{0, 0, 0}, 10, 0.02});
    expect_agreement(btUniformScalingShape(const_cast<btMultiSphereShape*>(&shape), 1.3f), 0,
                     1.5e-3);
}

TEST(ShapeConversion, small_multi_sphere_is_enclosed_within_three_percent) {
    const btVector3 centers[2] = {{0, 0, 0}, {0.5f, 0.1f, 0}};
    const btScalar radii[2] = {0.3f, 0.15f};
    const GridBall coarse{{0, 0, 0}, 100, 0.5};
    const btMultiSphereShape shape(centers, radii, 2);
    EXPECT_EQ(convert_shape(shape, coarse)->front().kind, ConvexShape::Kind::hull);
    expect_agreement(shape, 0.03 * 0.5, kSurfaceBand_m, coarse);
}

// It was the polyhedron that its child is, where that is small, and cut as that is.
TEST(ShapeConversion, scaled_multi_sphere_is_as_fine_as_its_own_size_asks) {
    const btVector3 centers[2] = {{0, 0, 0}, {0.05f, 0.01f, 0}};
    const btScalar radii[2] = {0.03f, 0.015f};
    btMultiSphereShape small(centers, radii, 2);
    const btUniformScalingShape large(&small, 10);
    EXPECT_EQ(convert_shape(small, kGrid)->front().kind, ConvexShape::Kind::hull);
    EXPECT_EQ(convert_shape(large, kGrid)->front().kind, ConvexShape::Kind::lattice);
    EXPECT_NE(shape_fingerprint(large, {{0, 0, 0}, 0.3}),
              shape_fingerprint(large, {{0.5, 0, 0}, 0.3}));
}

TEST(ShapeConversion, convex_triangle_mesh_is_the_hull_of_its_corners) {
    btTriangleMesh mesh;
    const std::vector<btVector3> points = random_points(12, 9);
    for (size_t i = 0; i + 2 < points.size(); ++i) {
        mesh.addTriangle(points[i], points[i + 1], points[i + 2]);
    }
    btConvexTriangleMeshShape shape(&mesh);
    expect_agreement(shape);
    shape.setLocalScaling(btVector3(1.2f, 0.8f, 1));
    expect_agreement(shape);
}

TEST(ShapeConversion, tetrahedron_agrees_with_bullet) {
    btBU_Simplex1to4 simplex({-0.3f, -0.2f, -0.3f}, {0.5f, -0.1f, 0}, {0, 0.6f, 0.1f},
                             {0.1f, 0, 0.5f});
    expect_agreement(simplex);
}

TEST(ShapeConversion, minkowski_sum_is_the_set_of_differences) {
    btBoxShape box(btVector3(0.2f, 0.15f, 0.1f));
    btConeShape cone(0.2f, 0.5f);
    btMinkowskiSumShape sum(&box, &cone);
    // The cone points down in it.
    sum.setTransformA(btTransform(btQuaternion(btVector3(1, 0, 0), 0.4f), btVector3(0.3f, 0, 0)));
    sum.setTransformB(btTransform(btQuaternion(btVector3(0, 0, 1), 0.7f), btVector3(0, 0.1f, 0)));
    // Its edges are rounded by a quarter of a voxel.
    expect_agreement(sum, 0, 0.0125);
    expect_agreement(sum, 0, 5e-3, {{0, 0, 0}, 10, 0.02});
}

TEST(ShapeConversion, minkowski_sum_of_polyhedra_is_one) {
    btBoxShape box(btVector3(0.2f, 0.15f, 0.1f)), other(btVector3(0.1f, 0.3f, 0.2f));
    box.setMargin(0);
    other.setMargin(0);
    btMinkowskiSumShape sum(&box, &other);
    sum.setTransformB(btTransform(btQuaternion(btVector3(0, 0, 1), 0.7f), btVector3(0, 0.1f, 0)));
    const auto converted = convert_shape(sum, kGrid);
    ASSERT_TRUE(converted);
    EXPECT_EQ(converted->front().kind, ConvexShape::Kind::hull);
    EXPECT_EQ(converted->front().planes.size(), 10u);  // of each, the z faces in common
    expect_agreement(sum);
}

TEST(ShapeConversion, triangle_is_a_plate_of_its_margin) {
    btTriangleShape triangle({-0.4f, 0.1f, -0.3f}, {0.5f, 0, -0.2f}, {0.1f, 0.2f, 0.6f});
    // Half of the thinnest wall is 44 mm here. Distances are interpolated over 25 mm, around edges
    // as sharp as the margin's radius.
    triangle.setMargin(0.06f);
    expect_agreement(triangle, 0, 0.006);
    expect_agreement(btUniformScalingShape(&triangle, 1.4f), 0, 0.006);
}

TEST(ShapeConversion, uniform_scaling_scales_the_child) {
    btConeShape cone(0.3f, 0.6f);
    expect_agreement(btUniformScalingShape(&cone, 1.7f));
    btConvexHullShape hull;
    for (const btVector3& p : random_points(14, 3)) hull.addPoint(p);
    expect_agreement(btUniformScalingShape(&hull, 0.6f));
}

TEST(ShapeConversion, nested_compound_is_the_union_of_its_children) {
    btBoxShape box(btVector3(0.2f, 0.2f, 0.3f));
    box.setMargin(kThinMargin_m);
    btConeShape cone(0.3f, 0.6f);
    std::mt19937 random(2);
    const btTransform box_in_inner = random_pose(random), inner_in_outer = random_pose(random),
                      cone_in_outer = random_pose(random);
    btCompoundShape inner, outer;
    inner.addChildShape(box_in_inner, &box);
    outer.addChildShape(inner_in_outer, &inner);
    outer.addChildShape(cone_in_outer, &cone);
    const auto converted = convert_shape(outer, kGrid);
    ASSERT_TRUE(converted);
    ASSERT_EQ(converted->size(), 2u);
    std::uniform_real_distribution<double> u(-3, 3);
    int inside_count = 0;
    for (int i = 0; i < kPointCount * 5; ++i) {
        const Vec3 p{u(random), u(random), u(random)};
        const double expected = std::min(bullet_distance(box, inner_in_outer * box_in_inner, p),
                                         bullet_distance(cone, cone_in_outer, p));
        if (std::isinf(expected) || std::abs(expected) < kSurfaceBand_m) continue;
        const bool is_inside = signed_distance(*converted, p) < 0;
        inside_count += is_inside ? 1 : 0;
        EXPECT_EQ(is_inside, expected < 0);
    }
    EXPECT_GT(inside_count, 20);
}

TEST(ShapeConversion, static_plane_fills_the_half_space_within_the_grid) {
    std::mt19937 random(4);
    std::normal_distribution<double> g;
    std::uniform_real_distribution<double> u(-1, 1);
    for (int k = 0; k < 20; ++k) {
        const Vec3 raw{g(random), g(random), g(random)};
        const Vec3 n = raw * (1 / length(raw));
        const double constant = 3 * u(random);
        const GridBall grid{{2, -1, 0.5}, 4};
        const auto converted =
            convert_shape(btStaticPlaneShape(to_bullet(n), btScalar(constant)), grid);
        ASSERT_TRUE(converted);
        for (int i = 0; i < 500; ++i) {
            const Vec3 v{g(random), g(random), g(random)};
            const Vec3 p =
                grid.center_m + v * (grid.radius_m * std::cbrt(std::abs(u(random))) / length(v));
            const double above = dot(n, p) - constant;
            if (std::abs(above) < kSurfaceBand_m) continue;
            EXPECT_EQ(signed_distance(*converted, p) < 0, above < 0);
        }
    }
}

void expect_refusal(const btCollisionShape& shape, const std::string& mention) {
    const auto converted = convert_shape(shape, kGrid);
    ASSERT_FALSE(converted) << shape.getName();
    EXPECT_NE(converted.error().find(shape.getName()), std::string::npos) << converted.error();
    EXPECT_NE(converted.error().find(mention), std::string::npos) << converted.error();
    EXPECT_TRUE(says_what_to_do(converted.error())) << converted.error();
}

TEST(ShapeConversion, zero_inverted_and_nan_extents_are_refused_by_field) {
    const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
    expect_refusal(btBoxShape(btVector3(0, 1, 1)), "half extent x");
    expect_refusal(btBoxShape(btVector3(1, -1, 1)), "half extent y");
    expect_refusal(btBoxShape(btVector3(1, 1, nan)), "half extent z");
    expect_refusal(btSphereShape(0), "radius");
    expect_refusal(btSphereShape(-1), "radius");
    expect_refusal(btCapsuleShape(0, 1), "radius");
    expect_refusal(btCapsuleShape(1, -1), "half height");
    expect_refusal(btCylinderShape(btVector3(1, 0, 1)), "half height");
    expect_refusal(btConeShape(nan, 1), "radius");
    expect_refusal(btCompoundShape(), "no children");
    const btVector3 center(0, 0, 0);
    const btScalar radius = 0;
    expect_refusal(btMultiSphereShape(&center, &radius, 1), "radius");
}

TEST(ShapeConversion, hulls_without_volume_are_refused) {
    btConvexHullShape empty;
    expect_refusal(empty, "no points");
    btConvexHullShape flat;
    for (int i = 0; i < 9; ++i) flat.addPoint(btVector3(btScalar(i % 3), 0, btScalar(i / 3)));
    expect_refusal(flat, "volume");
    btConvexHullShape line;
    for (int i = 0; i < 4; ++i) line.addPoint(btVector3(btScalar(i), 0, 0));
    expect_refusal(line, "volume");
}

TEST(ShapeConversion, refusal_inside_a_compound_names_the_child) {
    btEmptyShape empty;
    btCompoundShape compound;
    compound.addChildShape(btTransform::getIdentity(), &empty);
    expect_refusal(compound, "child 0");
    expect_refusal(compound, "Empty");
}

// It looked at the first and the last point.
TEST(ShapeConversion, fingerprint_follows_each_point_of_a_hull_edited_in_place) {
    btConvexHullShape hull;
    for (int i = 0; i < 200; ++i) {
        const double angle = 2 * std::numbers::pi * i / 200;
        hull.addPoint(to_bullet({std::cos(angle), std::sin(angle), i % 2 == 0 ? 0.1 : -0.1}),
                      false);
    }
    hull.recalcLocalAabb();
    btConvexPointCloudShape cloud(hull.getUnscaledPoints(), hull.getNumPoints(), {1, 1, 1});
    std::set<uint64_t> seen{shape_fingerprint(hull, kGrid), shape_fingerprint(cloud, kGrid)};
    ASSERT_EQ(seen.size(), 2u);
    for (int i = 0; i < hull.getNumPoints(); ++i) {
        hull.getUnscaledPoints()[i] *= btScalar(0.999);
        EXPECT_TRUE(seen.insert(shape_fingerprint(hull, kGrid)).second) << i;
        EXPECT_TRUE(seen.insert(shape_fingerprint(cloud, kGrid)).second) << i;
    }
}

TEST(ShapeConversion, fingerprint_follows_size_scaling_margin_and_children) {
    btBoxShape box(btVector3(1, 2, 3));
    const uint64_t first = shape_fingerprint(box, kGrid);
    EXPECT_EQ(first, shape_fingerprint(box, kGrid));
    box.setLocalScaling(btVector3(1, 1, 2));
    const uint64_t scaled = shape_fingerprint(box, kGrid);
    EXPECT_NE(first, scaled);
    btCompoundShape compound;
    btTransform pose = btTransform::getIdentity();
    compound.addChildShape(pose, &box);
    const uint64_t at_origin = shape_fingerprint(compound, kGrid);
    pose.setOrigin(btVector3(0, 1, 0));
    compound.updateChildTransform(0, pose);
    EXPECT_NE(at_origin, shape_fingerprint(compound, kGrid));
    btConvexHullShape hull;
    for (const btVector3& p : random_points(14, 3)) hull.addPoint(p);
    const uint64_t hull_first = shape_fingerprint(hull, kGrid);
    hull.setMargin(0.1f);
    EXPECT_NE(hull_first, shape_fingerprint(hull, kGrid));
}

TEST(ShapeConversion, fingerprint_tells_a_child_from_a_grandchild) {
    btBoxShape box(btVector3(1, 2, 3));
    btTransform aside = btTransform::getIdentity();
    aside.setOrigin(btVector3(0, 4, 0));
    uint64_t prints[2];
    for (const bool is_nested : {false, true}) {
        btCompoundShape inner, outer;
        inner.addChildShape(btTransform::getIdentity(), &box);
        outer.addChildShape(aside, &inner);
        (is_nested ? inner : outer).addChildShape(aside, &box);
        prints[is_nested] = shape_fingerprint(outer, kGrid);
    }
    EXPECT_NE(prints[0], prints[1]);
}

// Bullet rounds a cylinder's rims by the margin, the soil does not: a tilted wheel was said to
// reach 0.37 margins less deep.
TEST(LowestPoint, is_that_of_the_solid_that_the_soil_meets) {
    const double s = 0.5, c = std::sqrt(0.75);
    const btTransform tilted(btQuaternion({0, 0, 1}, SIMD_PI / 6), {2, 1, 3});
    const auto expect = [&](const btCollisionShape& shape, double below_m) {
        const auto lowest_m = lowest_height_m(shape, tilted, {0, 1, 0});
        ASSERT_TRUE(lowest_m) << shape.getName();
        EXPECT_NEAR(1 - *lowest_m, below_m, 1e-6) << shape.getName();
    };
    btCylinderShape cylinder({0.3f, 0.2f, 0.3f});
    ASSERT_GT(cylinder.getMargin(), 0.01f) << "else nothing is tested";
    expect(cylinder, 0.3 * s + 0.2 * c);
    expect(btUniformScalingShape(&cylinder, 2), 2 * (0.3 * s + 0.2 * c));
    expect(btCylinderShapeX({0.2f, 0.3f, 0.3f}), 0.3 * c + 0.2 * s);
    expect(btCylinderShapeZ({0.3f, 0.3f, 0.2f}), 0.3);
    expect(btBoxShape({0.3f, 0.2f, 0.1f}), 0.3 * s + 0.2 * c);
    expect(btSphereShape(0.3f), 0.3);
    expect(btCapsuleShape(0.2f, 0.6f), 0.3 * c + 0.2);
    // Outside of these the margin is the soil's as well.
    const btConeShape cone(0.3f, 0.4f);
    expect(cone, 0.3 * s + 0.2 * c + static_cast<double>(cone.getMargin()));
    btConvexHullShape hull;
    for (int corner = 0; corner < 8; ++corner) {
        hull.addPoint(
            {corner & 1 ? 0.3f : -0.3f, corner & 2 ? 0.2f : -0.2f, corner & 4 ? 0.1f : -0.1f});
    }
    expect(hull, 0.3 * s + 0.2 * c + static_cast<double>(hull.getMargin()));
}

}  // namespace
}  // namespace bsoil::bullet::shape_conversion_test
