// Heightfields and distance fields, against Bullet's own rays, heights and distances.
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btSdfCollisionShape.h>
#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <random>

#include "bullet_types.h"
#include "mesh_crossings.h"

namespace bsoil::bullet::field_conversion_test {
namespace {

// --- heightfields

/// Height of a surface over a point by a vertical ray through the triangles that bodies collide
/// with; NaN beside it.
double triangle_height(const btHeightfieldTerrainShape& shape, Vec3 p) {
    const int up = shape.getUpAxis();
    btVector3 from = to_bullet(p), to = from;
    from[up] = 8;
    to[up] = -8;
    CrossingCounter counter(from, to);
    shape.processAllTriangles(&counter, to, from);
    return counter.fractions.empty() ? std::numeric_limits<double>::quiet_NaN()
                                     : 8 - 16 * counter.fractions.front();
}

/// The same as Bullet's ray test finds it. It knows no diamonds and zigzags.
double ray_height(const btHeightfieldTerrainShape& shape, Vec3 p) {
    btCollisionObject object;
    object.setCollisionShape(const_cast<btHeightfieldTerrainShape*>(&shape));
    const int up = shape.getUpAxis();
    btVector3 from = to_bullet(p), to = from;
    from[up] = 8;
    to[up] = -8;
    btCollisionWorld::ClosestRayResultCallback hit(from, to);
    btCollisionWorld::rayTestSingle(btTransform(btQuaternion::getIdentity(), from),
                                    btTransform(btQuaternion::getIdentity(), to), &object, &shape,
                                    btTransform::getIdentity(), hit);
    return hit.hasHit() ? static_cast<double>(hit.m_hitPointWorld[up])
                        : std::numeric_limits<double>::quiet_NaN();
}

void expect_same_heights(const btHeightfieldTerrainShape& shape, bool by_ray_test = true) {
    const auto converted = convert_shape(shape, {{0, 0, 0}, 2, kVoxel});
    ASSERT_TRUE(converted) << converted.error();
    const int up = shape.getUpAxis();
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> u(-0.48, 0.48);
    int judged = 0;
    for (int i = 0; i < 2000; ++i) {
        btVector3 p = 0.5f * (low + high);
        for (int k = 0; k < 3; ++k) p[k] += static_cast<btScalar>(u(random)) * (high[k] - low[k]);
        const double height = by_ray_test ? ray_height(shape, from_bullet(p))
                                          : triangle_height(shape, from_bullet(p));
        if (std::isnan(height)) continue;  // the ray slipped through between two triangles
        const double above = static_cast<double>(p[up]) - height;
        // Ridges and valleys are rounded, by more straight up than across where slopes are steep.
        if (std::abs(above) < 0.03) continue;
        ++judged;
        ASSERT_EQ(distance_to(*converted, from_bullet(p)) < 0, above < 0)
            << from_bullet(p).x << " " << from_bullet(p).y << " " << from_bullet(p).z << ": "
            << above << " m above, distance " << distance_to(*converted, from_bullet(p));
    }
    EXPECT_GT(judged, 800);
    // And on down through the grid.
    btVector3 deep = 0.5f * (low + high);
    deep[up] = -1.9f;
    EXPECT_LT(distance_to(*converted, from_bullet(deep)), 0);
}

TEST(MeshConversion, heightfields_are_solid_up_to_where_rays_hit_them) {
    constexpr int kWidth = 12, kLength = 10;
    std::vector<float> heights;
    std::vector<short> shorts;
    std::vector<unsigned char> bytes;
    std::mt19937 random(8);
    std::uniform_int_distribution<int> level(0, 40);
    for (int i = 0; i < kWidth * kLength; ++i) {
        bytes.push_back(static_cast<unsigned char>(level(random)));
        shorts.push_back(static_cast<short>(bytes.back() * 10 - 200));
        heights.push_back(static_cast<float>(shorts.back()) * 0.0004f);
    }
    const btVector3 scaling[3] = {{1, 0.2f, 0.3f}, {0.2f, 1.3f, 0.3f}, {0.25f, 0.2f, 1}};
    for (int up = 0; up < 3; ++up) {
        for (int diagonal = 0; diagonal < 4; ++diagonal) {
            SCOPED_TRACE("up axis " + std::to_string(up) + ", diagonals " +
                         std::to_string(diagonal));
            btHeightfieldTerrainShape shape(kWidth, kLength, heights.data(), -0.08f, 0.08f, up,
                                            diagonal == 1);
            shape.setUseDiamondSubdivision(diagonal == 2);
            shape.setUseZigzagSubdivision(diagonal == 3);
            shape.setLocalScaling(scaling[up]);
            expect_same_heights(shape, false);
            if (diagonal < 2) expect_same_heights(shape);
        }
    }
    btHeightfieldTerrainShape of_shorts(kWidth, kLength, shorts.data(), 0.0004f, -0.08f, 0.08f, 1,
                                        false);
    of_shorts.setLocalScaling(scaling[1]);
    expect_same_heights(of_shorts);
    btHeightfieldTerrainShape of_bytes(kWidth, kLength, bytes.data(), 0.004f, 0.f, 0.16f, 1, false);
    of_bytes.setLocalScaling(scaling[1]);
    expect_same_heights(of_bytes);
}

TEST(MeshConversion, part_of_a_heightfield_within_the_grid_is_converted) {
    constexpr int kSide = 401;
    std::vector<float> heights;
    for (int i = 0; i < kSide * kSide; ++i) {
        heights.push_back(0.3f * std::sin(0.9f * float(i % kSide)) *
                          std::cos(0.7f * float(i / kSide)));
    }
    btHeightfieldTerrainShape shape(kSide, kSide, heights.data(), -0.4f, 0.4f, 2, false);
    const GridBall grid{{37.3, -61.8, 0.4}, 2, kVoxel};
    const auto converted = convert_shape(shape, grid);
    ASSERT_TRUE(converted) << converted.error();
    std::mt19937 random(9);
    std::uniform_real_distribution<double> u(-1, 1);
    for (int i = 0; i < 3000; ++i) {
        const Vec3 p = grid.center_m + Vec3{2 * u(random), 2 * u(random), u(random)};
        const double above = p.z - ray_height(shape, p);
        if (std::abs(above) < 0.02) continue;
        ASSERT_EQ(distance_to(*converted, p) < 0, above < 0);
    }
}

// --- signed distance fields

template <typename T>
void put(std::vector<char>& out, T value) {
    const auto* bytes = reinterpret_cast<const char*>(&value);
    out.insert(out.end(), bytes, bytes + sizeof value);
}

/// A distance field of one cubic cell over [-1, 1]^3 in the format that Bullet reads: 32 nodes, of
/// which the first eight are the corners; here of a function that is linear in x, y, z.
std::vector<char> linear_field(Vec3 slope, double offset) {
    std::vector<char> out;
    for (const double v : {-1.0, -1.0, -1.0, 1.0, 1.0, 1.0}) put(out, v);
    for (int k = 0; k < 3; ++k) put(out, 1u);
    for (int k = 0; k < 3; ++k) put(out, 2.0);
    for (int k = 0; k < 3; ++k) put(out, 0.5);
    put(out, 1ull);  // cells
    put(out, 1ull);  // fields
    put(out, 1ull);
    put(out, 32ull);
    std::vector<Vec3> nodes;
    for (int i = 0; i < 8; ++i) {
        nodes.push_back({i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0});
    }
    // Two nodes on each edge, at thirds; edges along x, then y, then z.
    for (int axis = 0; axis < 3; ++axis) {
        for (int edge = 0; edge < 4; ++edge) {
            for (const double t : {-1.0 / 3, 1.0 / 3}) {
                double p[3];
                p[axis] = t;
                // Along x and y the other axis counts slower, along z faster.
                const int a = axis == 0 ? 1 : 0, b = axis == 2 ? 1 : 2;
                const bool low_first = axis != 1;
                p[a] = (low_first ? edge & 1 : edge >> 1) ? 1 : -1;
                p[b] = (low_first ? edge >> 1 : edge & 1) ? 1 : -1;
                nodes.push_back({p[0], p[1], p[2]});
            }
        }
    }
    for (const Vec3 p : nodes) put(out, dot(slope, p) + offset);
    put(out, 1ull);
    put(out, 1ull);
    for (unsigned i = 0; i < 32; ++i) put(out, i);
    put(out, 1ull);
    put(out, 1ull);
    put(out, 0u);
    return out;
}

TEST(MeshConversion, distance_field_is_solid_where_its_query_is_negative) {
    const std::vector<char> data = linear_field(Vec3{0.6, 0.8, 0}, 0.13);
    btSdfCollisionShape shape;
    ASSERT_TRUE(shape.initializeSDF(data.data(), static_cast<int>(data.size())));
    const auto converted = convert_shape(shape, kGrid);
    ASSERT_TRUE(converted) << converted.error();
    std::mt19937 random(10);
    std::uniform_real_distribution<double> u(-1.2, 1.2);
    int inside = 0;
    for (int i = 0; i < 5000; ++i) {
        const Vec3 p{u(random), u(random), u(random)};
        btScalar distance = 0;
        btVector3 normal;
        const bool is_known = shape.queryPoint(to_bullet(p), distance, normal);
        const double beyond = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) - 1;
        if (std::abs(beyond) < 0.02 || std::abs(distance) < 0.01) continue;
        const bool expected = is_known && distance < 0;
        inside += expected ? 1 : 0;
        ASSERT_EQ(distance_to(*converted, p) < 0, expected) << p.x << " " << p.y << " " << p.z;
    }
    EXPECT_GT(inside, 500);
    const uint64_t before = shape_fingerprint(shape, kGrid);
    const std::vector<char> other = linear_field(Vec3{0.6, 0.8, 0}, 0.14);
    ASSERT_TRUE(shape.initializeSDF(other.data(), static_cast<int>(other.size())));
    EXPECT_NE(before, shape_fingerprint(shape, kGrid));
}

}  // namespace
}  // namespace bsoil::bullet::field_conversion_test
