// Meshes against Bullet's own rays, and what of them is refused.
#include "mesh_conversion.h"

#include <BulletCollision/CollisionShapes/btBox2dShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btMinkowskiSumShape.h>
#include <BulletCollision/CollisionShapes/btMultimaterialTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <numbers>
#include <random>

#include "bsoil/bullet/soil_action.h"
#include "bsoil/limits.h"
#include "bullet_scene.h"
#include "bullet_types.h"
#include "cure.h"
#include "mesh_crossings.h"

namespace bsoil::bullet::mesh_conversion_test {
namespace {

const double kHalfWall = 0.5 * limits::kThinnestWallVoxels * kVoxel;
/// Edges are rounded over a cell of half a voxel, by up to a quarter of it.
constexpr double kEdgeBand = 0.2 * kVoxel;

/// Rows of quads (a grid of points, wrapped around its second index) as triangles of a mesh.
struct Torus {
    std::vector<btVector3> points;
    std::vector<int> indices;
    Torus(double ring_m, double tube_m, int ring_count, int tube_count) {
        for (int i = 0; i < ring_count; ++i) {
            for (int j = 0; j < tube_count; ++j) {
                const double a = 2 * std::numbers::pi * i / ring_count,
                             b = 2 * std::numbers::pi * j / tube_count;
                const double r = ring_m + tube_m * std::cos(b);
                points.push_back(
                    to_bullet({r * std::cos(a), tube_m * std::sin(b), r * std::sin(a)}));
                const auto at = [&](int u, int v) {
                    return (i + u) % ring_count * tube_count + (j + v) % tube_count;
                };
                for (const int index :
                     {at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)}) {
                    indices.push_back(index);
                }
            }
        }
    }
    btTriangleIndexVertexArray array() {
        return {static_cast<int>(indices.size() / 3),
                indices.data(),
                3 * int(sizeof(int)),
                static_cast<int>(points.size()),
                reinterpret_cast<btScalar*>(points.data()),
                int(sizeof(btVector3))};
    }
};

bool is_inside_by_rays(const btConcaveShape& shape, Vec3 p) {
    int votes = 0;
    for (const Vec3 far : {Vec3{7.1, 3.3, 2.2}, Vec3{-2.7, 6.1, 4.3}, Vec3{1.3, -2.9, 7.7}}) {
        const btVector3 from = to_bullet(p), to = to_bullet(p + far);
        CrossingCounter counter(from, to);
        btVector3 low = from, high = from;
        low.setMin(to);
        high.setMax(to);
        shape.processAllTriangles(&counter, low, high);
        votes += counter.hits.size() % 2 == 1 ? 1 : 0;
    }
    return votes >= 2;
}

/// Points inside and outside by Bullet's rays and by the conversion.
void expect_same_inside(const btConcaveShape& shape, double band_m, double margin_m = 0) {
    SCOPED_TRACE(shape.getName());
    const auto converted = convert_shape(shape, kGrid);
    ASSERT_TRUE(converted) << converted.error();
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    const Vec3 middle = 0.5 * (from_bullet(low) + from_bullet(high)),
               half = 0.55 * (from_bullet(high) - from_bullet(low));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> u(-1, 1);
    int judged = 0, inside = 0;
    for (int i = 0; i < 6000; ++i) {
        const Vec3 p = middle + Vec3{half.x * u(random), half.y * u(random), half.z * u(random)};
        const double d = distance_to(*converted, p);
        if (std::abs(d + margin_m) < margin_m + band_m) continue;
        ++judged;
        const bool expected = is_inside_by_rays(shape, p);
        inside += expected ? 1 : 0;
        ASSERT_EQ(d < 0, expected) << p.x << " " << p.y << " " << p.z << ": " << d;
    }
    EXPECT_GT(judged, 3000);
    EXPECT_GT(inside, 150);
}

TEST(MeshConversion, triangle_meshes_are_inside_where_rays_say_so) {
    Torus torus(0.5, 0.2, 40, 24);
    btTriangleIndexVertexArray array = torus.array();
    btBvhTriangleMeshShape bvh(&array, true);
    expect_same_inside(bvh, 0.004);
    btMultimaterialTriangleMeshShape multi(&array, true);
    expect_same_inside(multi, 0.004);
    btScaledBvhTriangleMeshShape scaled(&bvh, btVector3(1.5f, 0.8f, 1));
    expect_same_inside(scaled, 0.004);
    btScaledBvhTriangleMeshShape mirrored(&bvh, btVector3(-1, 1, 1.2f));
    expect_same_inside(mirrored, 0.004);
}

TEST(MeshConversion, local_scaling_of_a_mesh_is_honoured) {
    Torus torus(0.5, 0.2, 40, 24);
    btTriangleIndexVertexArray array = torus.array();
    btBvhTriangleMeshShape bvh(&array, true);
    bvh.setLocalScaling(btVector3(0.7f, 1.4f, 1));
    expect_same_inside(bvh, 0.004);
}

TEST(MeshConversion, gimpact_meshes_are_inside_where_rays_say_so) {
    Torus torus(0.5, 0.2, 40, 24);
    btTriangleIndexVertexArray array = torus.array();
    btGImpactMeshShape gimpact(&array);
    gimpact.setMargin(0);
    gimpact.updateBound();
    expect_same_inside(gimpact, 0.004);
    gimpact.setLocalScaling(btVector3(1.2f, 1, 0.8f));
    gimpact.updateBound();
    expect_same_inside(gimpact, 0.004);
    gimpact.setMargin(0.02f);
    gimpact.updateBound();
    expect_same_inside(gimpact, 0.004, 0.02);
    const auto part = convert_shape(*gimpact.getMeshPart(0), kGrid);
    ASSERT_TRUE(part) << part.error();
    const auto whole = convert_shape(gimpact, kGrid);
    EXPECT_TRUE(
        std::ranges::equal(part->front().lattice->words(), whole->front().lattice->words()));
}

TEST(MeshConversion, gimpact_margin_is_that_of_its_parts) {
    Torus torus(0.5, 0.2, 40, 24);
    btTriangleIndexVertexArray array = torus.array();
    btGImpactMeshShape gimpact(&array);
    gimpact.updateBound();
    const double margin = static_cast<double>(gimpact.getMeshPart(0)->getMargin());
    const auto converted = convert_shape(gimpact, kGrid);
    ASSERT_TRUE(converted);
    // A corner on the outer equator of the torus; interpolation rounds it by a few millimetres.
    EXPECT_NEAR(distance_to(*converted, {0.7, 0, 0}), -margin, 0.004);
}

TEST(MeshConversion, index_types_and_double_corners_read_alike) {
    Torus torus(0.5, 0.2, 16, 12);
    btTriangleIndexVertexArray ints = torus.array();
    std::vector<uint16_t> shorts(torus.indices.begin(), torus.indices.end());
    std::vector<uint8_t> bytes(torus.indices.begin(), torus.indices.end());
    std::vector<double> doubles;
    for (const btVector3& p : torus.points) {
        for (int k = 0; k < 3; ++k) doubles.push_back(static_cast<double>(p[k]));
    }
    const auto mesh_of = [&](const void* indices, int stride, PHY_ScalarType type) {
        btIndexedMesh part;
        part.m_numTriangles = static_cast<int>(torus.indices.size() / 3);
        part.m_triangleIndexBase = static_cast<const unsigned char*>(indices);
        part.m_triangleIndexStride = stride;
        part.m_numVertices = static_cast<int>(torus.points.size());
        part.m_vertexBase = reinterpret_cast<const unsigned char*>(doubles.data());
        part.m_vertexStride = 3 * sizeof(double);
        part.m_vertexType = PHY_DOUBLE;
        auto array = std::make_unique<btTriangleIndexVertexArray>();
        array->addIndexedMesh(part, type);
        return array;
    };
    btBvhTriangleMeshShape expected_shape(&ints, true);
    const auto expected = convert_shape(expected_shape, kGrid);
    ASSERT_TRUE(expected);
    const auto check = [&](std::unique_ptr<btTriangleIndexVertexArray> array) {
        btBvhTriangleMeshShape shape(array.get(), true);
        const auto got = convert_shape(shape, kGrid);
        ASSERT_TRUE(got) << got.error();
        EXPECT_TRUE(
            std::ranges::equal(got->front().lattice->words(), expected->front().lattice->words()));
    };
    check(mesh_of(shorts.data(), 6, PHY_SHORT));
    check(mesh_of(bytes.data(), 3, PHY_UCHAR));
    check(mesh_of(torus.indices.data(), 12, PHY_INTEGER));
}

TEST(MeshConversion, meshes_in_nested_compounds_go_where_the_children_are) {
    Torus torus(0.5, 0.2, 40, 24);
    btTriangleIndexVertexArray array = torus.array();
    btGImpactMeshShape gimpact(&array);
    gimpact.setMargin(0);
    gimpact.updateBound();
    btTransform inner_pose(btQuaternion(btVector3(1, 2, 3).normalized(), 0.8f),
                           btVector3(0.3f, -0.2f, 0.4f));
    btTransform outer_pose(btQuaternion(btVector3(-1, 1, 0).normalized(), -1.3f),
                           btVector3(0, 0.5f, 0));
    btCompoundShape inner, outer;
    inner.addChildShape(inner_pose, &gimpact);
    outer.addChildShape(outer_pose, &inner);
    const auto converted = convert_shape(outer, kGrid);
    ASSERT_TRUE(converted) << converted.error();
    ASSERT_EQ(converted->size(), 1u);
    const Pose child_to_outer = from_bullet(outer_pose * inner_pose);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> u(-0.7, 0.7);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 p{u(random), 0.3 * u(random), u(random)};
        const double d = distance_to(*converted, transform(child_to_outer, p));
        if (std::abs(d) < 0.004) continue;
        ASSERT_EQ(d < 0, is_inside_by_rays(gimpact, p));
    }
    btGImpactCompoundShape gimpact_compound;
    btBoxShape box(btVector3(0.2f, 0.3f, 0.4f));
    gimpact_compound.addChildShape(inner_pose, &box);
    gimpact_compound.updateBound();
    const auto boxes = convert_shape(gimpact_compound, kGrid);
    ASSERT_TRUE(boxes) << boxes.error();
    EXPECT_NEAR(boxes->front().local.position.z, 0.4, 1e-6);
    EXPECT_NEAR(boxes->front().half_extents_m.y, 0.3, 1e-6);
}

TEST(MeshConversion, open_mesh_is_a_plate) {
    btTriangleMesh sheet;
    sheet.addTriangle({-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, true);
    sheet.addTriangle({-0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}, true);
    btBvhTriangleMeshShape bvh(&sheet, true);
    const auto converted = convert_shape(bvh, kGrid);
    ASSERT_TRUE(converted) << converted.error();
    std::mt19937 random(5);
    std::uniform_real_distribution<double> u(-0.6, 0.6);
    for (int i = 0; i < 4000; ++i) {
        const Vec3 p{u(random), 0.2 * u(random), u(random)};
        const double expected =
            std::max({std::abs(p.x) - 0.5, std::abs(p.y) - kHalfWall, std::abs(p.z) - 0.5});
        if (std::abs(expected) < kEdgeBand) continue;
        ASSERT_EQ(distance_to(*converted, p) < 0, expected < 0);
    }
}

TEST(MeshConversion, mesh_larger_than_the_grid_is_cut_to_it) {
    btTriangleMesh ground;  // a closed block of 2 km, its top at 0.3 m
    const auto at = [](int i) {
        return btVector3(i & 1 ? 1000.f : -1000.f, i & 2 ? 0.3f : -2000.f,
                         i & 4 ? 1000.f : -1000.f);
    };
    const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                             {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& f : faces) {
        ground.addTriangle(at(f[0]), at(f[1]), at(f[2]), true);
        ground.addTriangle(at(f[0]), at(f[2]), at(f[3]), true);
    }
    btBvhTriangleMeshShape bvh(&ground, true);
    const GridBall grid{{5, 0, -3}, 3, kVoxel};
    const auto converted = convert_shape(bvh, grid);
    ASSERT_TRUE(converted) << converted.error();
    std::mt19937 random(6);
    std::uniform_real_distribution<double> u(-1, 1);
    for (int i = 0; i < 4000; ++i) {
        const Vec3 p = grid.center_m + Vec3{3 * u(random), 3 * u(random), 3 * u(random)};
        if (std::abs(p.y - 0.3) < 0.002) continue;
        ASSERT_EQ(distance_to(*converted, p) < 0, p.y < 0.3);
    }
    EXPECT_NE(shape_fingerprint(bvh, grid), shape_fingerprint(bvh, {{5, 0, -2}, 3, kVoxel}));
}

/// A closed box of 8 m.
struct LargeMesh {
    btTriangleMesh mesh;
    std::unique_ptr<btBvhTriangleMeshShape> shape;
    LargeMesh() {
        const btBoxShape box(btVector3(4, 4, 4));
        const int faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                 {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
        for (const auto& f : faces) {
            btVector3 at[4];
            for (int k = 0; k < 4; ++k) box.getVertex(f[k], at[k]);
            mesh.addTriangle(at[0], at[1], at[2], true);
            mesh.addTriangle(at[0], at[2], at[3], true);
        }
        shape = std::make_unique<btBvhTriangleMeshShape>(&mesh, true);
    }
};

// It was refused, and the whole compound that had one such child with it.
TEST(MeshConversion, large_shapes_beside_the_grid_take_no_part) {
    const LargeMesh large;
    const btVector3 centers[] = {{-3, 0, 0}, {3, 0, 0}};
    const btScalar radii[] = {1, 2};
    const btMultiSphereShape spheres(centers, radii, 2);
    std::vector<float> heights(100, 0.5f);
    const btHeightfieldTerrainShape field(10, 10, heights.data(), 0.f, 1.f, 1, false);
    for (const btCollisionShape* shape :
         std::initializer_list<const btCollisionShape*>{large.shape.get(), &spheres, &field}) {
        SCOPED_TRACE(shape->getName());
        for (const Vec3 at : {Vec3{9, 0, 0}, Vec3{0, 12, 0}, Vec3{0, 0, -9}}) {
            const auto beside = convert_shape(*shape, {at, 2, 0.2});
            ASSERT_TRUE(beside) << beside.error();
            EXPECT_TRUE(beside->empty());
        }
        const auto here = convert_shape(*shape, {{3, 0, 0}, 2, 0.2});
        ASSERT_TRUE(here) << here.error();
        EXPECT_EQ(here->size(), 1u);
    }
    btBoxShape box(btVector3(0.2f, 0.2f, 0.2f));
    btCompoundShape level;
    btTransform far_away = btTransform::getIdentity();
    far_away.setOrigin(btVector3(20, 0, 0));
    level.addChildShape(far_away, large.shape.get());
    level.addChildShape(btTransform::getIdentity(), &box);
    const auto converted = convert_shape(level, {{0, 0, 0}, 2, 0.2});
    ASSERT_TRUE(converted) << converted.error();
    ASSERT_EQ(converted->size(), 1u);
    EXPECT_EQ(converted->front().kind, ConvexShape::Kind::box);
}

// --- fingerprints

TEST(MeshConversion, fingerprint_sees_a_corner_moved_and_refitted) {
    Torus torus(0.5, 0.2, 40, 24);
    btTriangleIndexVertexArray array = torus.array();
    btBvhTriangleMeshShape bvh(&array, true);
    btGImpactMeshShape gimpact(&array);
    gimpact.updateBound();
    const uint64_t first = shape_fingerprint(bvh, kGrid);
    const uint64_t first_gimpact = shape_fingerprint(gimpact, kGrid);
    EXPECT_EQ(first, shape_fingerprint(bvh, kGrid));
    torus.points[17] += btVector3(0, 0.01f, 0);  // inside of the box
    bvh.partialRefitTree(btVector3(-1, -1, -1), btVector3(1, 1, 1));
    gimpact.postUpdate();
    gimpact.updateBound();
    const uint64_t moved = shape_fingerprint(bvh, kGrid);
    EXPECT_NE(first, moved);
    EXPECT_NE(first_gimpact, shape_fingerprint(gimpact, kGrid));
    bvh.setLocalScaling(btVector3(1, 1, 1.01f));
    EXPECT_NE(moved, shape_fingerprint(bvh, kGrid));
    gimpact.setMargin(0.03f);
    EXPECT_NE(first_gimpact, shape_fingerprint(gimpact, kGrid));
    std::vector<float> heights(100, 0.5f);
    btHeightfieldTerrainShape field(10, 10, heights.data(), 0.f, 1.f, 1, false);
    const uint64_t level = shape_fingerprint(field, kGrid);
    heights[44] = 0.51f;
    EXPECT_NE(level, shape_fingerprint(field, kGrid));
}

// --- refusals

void expect_refusal(const btCollisionShape& shape, const std::string& mention) {
    const auto converted = convert_shape(shape, kGrid);
    ASSERT_FALSE(converted) << shape.getName() << ", " << mention;
    EXPECT_NE(converted.error().find(shape.getName()), std::string::npos) << converted.error();
    EXPECT_NE(converted.error().find(mention), std::string::npos) << converted.error();
    EXPECT_TRUE(says_what_to_do(converted.error())) << converted.error();
}

TEST(MeshConversion, broken_meshes_are_refused_by_what_is_wrong) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    Torus torus(0.5, 0.2, 16, 12);
    btTriangleIndexVertexArray array = torus.array();
    btBvhTriangleMeshShape bvh(&array, true);  // Bullet builds its tree from sound data
    torus.points[5].setX(nan);
    expect_refusal(bvh, "vertex 5");
    torus.points[5].setX(0.3f);
    torus.indices[7] = 16 * 12;
    expect_refusal(bvh, "triangle 2 of part 0 has vertex index 192, must be 0 to 191");
    torus.indices[7] = -3;
    expect_refusal(bvh, "vertex index -3");
    std::fill(torus.indices.begin(), torus.indices.end(), 4);
    expect_refusal(bvh, "no area");
    btTriangleIndexVertexArray nothing;
    btGImpactMeshShape empty(&nothing);
    expect_refusal(empty, "no triangles");
    btTriangleShape flat({0, 0, 0}, {1, 1, 1}, {2, 2, 2});
    expect_refusal(flat, "no area");
    std::vector<float> heights(16, 0);
    btHeightfieldTerrainShape field(4, 4, heights.data(), -1.f, 1.f, 1, false);
    heights[5] = nan;
    expect_refusal(field, "not finite");
    expect_refusal(btEmptyShape(), "not supported");
    expect_refusal(btBox2dShape(btVector3(1, 1, 0)), "not supported");
    btBU_Simplex1to4 three({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    expect_refusal(three, "volume");
}

TEST(MeshConversion, margins_that_are_no_numbers_are_refused) {
    Torus torus(0.5, 0.2, 16, 12);
    btTriangleIndexVertexArray array = torus.array();
    btGImpactMeshShape gimpact(&array);
    gimpact.setMargin(-0.1f);
    gimpact.updateBound();
    expect_refusal(gimpact, "margin");
}

// --- in a world

TEST(MeshConversion, moving_mesh_takes_part_in_a_world) {
    Torus torus(0.35, 0.12, 32, 16);
    btTriangleIndexVertexArray array = torus.array();
    BulletScene scene;
    SoilDef def;
    def.size_m = {1.6, 1.6, 1.6};
    auto soil = SoilAction::create(*scene.world, def);
    ASSERT_TRUE(soil) << soil.error();
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-0.8, 0, -0.8}, {0.8, 0.4, 0.8}}, {}}));
    btGImpactMeshShape shape(&array);
    shape.setMargin(0);
    shape.updateBound();
    btRigidBody& body = scene.add(60, shape, btVector3(0, 0.6f, 0));
    scene.run(3);
    EXPECT_TRUE((*soil)->refused().empty());
    // It lies on the soil, sunk in by less than its tube is thick.
    const double height = static_cast<double>(body.getWorldTransform().getOrigin().y());
    EXPECT_LT(height, 0.4 + 0.12);
    EXPECT_GT(height, 0.4 - 0.12);
    EXPECT_NEAR((*soil)->body_report(body).force_n.y, 60 * 9.81, 0.1 * 60 * 9.81);
    scene.remove(body);
}

}  // namespace
}  // namespace bsoil::bullet::mesh_conversion_test
