#include "bsoil/render/primitives.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mesh_checks.h"

namespace bsoil::render::primitives_test {
namespace {

constexpr Color kGrey{0.5f, 0.5f, 0.5f};

/// Corners computed in different ways agree to a few bits only.
int open_edges(const Mesh& mesh) {
    return test::open_edge_count(mesh, [](float v) { return std::round(v * 1e4f) + 0.0f; });
}

/// 48 segments around an axis take 0.3 % off a circle's area; twelve of a quarter circle as much
/// again.
void expect_solid(const Mesh& mesh, double volume) {
    EXPECT_EQ(open_edges(mesh), 0);
    EXPECT_NEAR(test::enclosed_volume(mesh), volume, 0.01 * volume);
    for (size_t t = 0; t < mesh.triangle_count(); ++t) {
        const uint32_t* i = &mesh.indices[3 * t];
        const Vec3 face = cross(test::vertex(mesh, i[1]) - test::vertex(mesh, i[0]),
                                test::vertex(mesh, i[2]) - test::vertex(mesh, i[0]));
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(length(test::normal(mesh, i[k])), 1, 1e-5);
            EXPECT_GE(dot(face, test::normal(mesh, i[k])), 0);
        }
    }
}

TEST(Primitives, are_closed_and_enclose_their_volume) {
    expect_solid(box_mesh({1, 2, 3}, kGrey), 48);
    expect_solid(sphere_mesh(2, kGrey), 4.0 / 3 * std::numbers::pi * 8);
    expect_solid(capsule_mesh(0.5, 1, kGrey),
                 std::numbers::pi * 0.25 * 2 + 4.0 / 3 * std::numbers::pi * 0.125);
    expect_solid(cylinder_mesh(0.5, 1, kGrey), std::numbers::pi * 0.25 * 2);
    expect_solid(cone_mesh(1, 1.5, kGrey), std::numbers::pi * 3 / 3);
}

TEST(Primitives, bevels_cut_edges_off) {
    // Twelve edges, each a prism with legs of c; at a corner three of them meet.
    const double c = 0.5;
    expect_solid(box_mesh({1, 2, 3}, kGrey, c), 48 - 24 * c * c + 6 * c * c * c);
    // No more than a third of the thinnest extent, 2, is cut.
    const double most = 2.0 / 3;
    expect_solid(box_mesh({1, 2, 3}, kGrey, 5), 48 - 24 * most * most + 6 * most * most * most);
    // A ring with a triangle of c x c turns about the axis with its centroid.
    const double ring = 2 * std::numbers::pi * (0.5 - 0.2 / 3) * 0.2 * 0.2 / 2;
    expect_solid(cylinder_mesh(0.5, 1, kGrey, 0.2), std::numbers::pi * 0.25 * 2 - 2 * ring);
}

TEST(Primitives, hull_is_the_intersection_of_its_half_spaces) {
    const double s = 1 / std::sqrt(3.0);
    std::vector<Plane> octahedron;
    for (int c = 0; c < 8; ++c) {
        octahedron.push_back({{c & 1 ? s : -s, c & 2 ? s : -s, c & 4 ? s : -s}, s});
    }
    expect_solid(hull_mesh(octahedron, 1, kGrey), 4.0 / 3);
}

TEST(Primitives, convex_mesh_is_in_the_bodys_frame_with_its_rounding) {
    ConvexShape shape;
    shape.half_extents_m = {0.9, 0.9, 0.9};
    shape.rounding_m = 0.1;
    shape.local.position = {5, 0, 0};
    const Mesh mesh = convex_mesh(shape, kGrey);
    expect_solid(mesh, 8);
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        EXPECT_NEAR(std::abs(mesh.positions[3 * v] - 5), 1, 1e-5);
    }
}

TEST(Primitives, triangle_mesh_is_flat_shaded) {
    const Mesh mesh = triangle_mesh({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                     {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}},
                                    kGrey);
    EXPECT_EQ(mesh.vertex_count(), 12u);
    expect_solid(mesh, 1.0 / 6);
}

}  // namespace
}  // namespace bsoil::render::primitives_test
