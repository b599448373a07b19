// Meshes that are cut into convex parts.
#include "robots/convex_parts.h"

#include <gtest/gtest.h>

namespace bsoil::scene::convex_parts_test {
namespace {

/// Outer size 1 x 1 x 0.6 m, walls and floor 0.1 m thick.
constexpr double kBinSolid = 0.6 - 0.8 * 0.8 * 0.5;  // [m3]

TEST(ConvexParts, bin_falls_into_its_plates) {
    TriangleMesh bin;
    const auto corners = [&](double r, double z) {
        for (const auto& [x, y] : {std::pair{-r, -r}, {r, -r}, {r, r}, {-r, r}}) {
            bin.vertices.push_back({x, y, z});
        }
    };
    corners(0.5, 0);
    corners(0.5, 0.6);
    corners(0.4, 0.6);
    corners(0.4, 0.1);
    const auto quad = [&](int a, int b, int c, int d) {
        bin.triangles.push_back({a, b, c});
        bin.triangles.push_back({a, c, d});
    };
    quad(3, 2, 1, 0);
    quad(12, 13, 14, 15);
    for (const int low : {0, 4, 8}) {
        for (int i = 0; i < 4; ++i) {
            const int j = (i + 1) % 4;
            quad(low + i, low + j, low + 4 + j, low + 4 + i);
        }
    }
    EXPECT_NEAR(mesh_volume_m3(bin), kBinSolid, 1e-12);
    const std::vector<ConvexHull> parts = convex_parts(bin, 20);
    double sum_m3 = 0;
    for (const ConvexHull& part : parts) sum_m3 += part.volume_m3;
    EXPECT_NEAR(sum_m3, kBinSolid, 0.03 * kBinSolid);
    // The floor and four walls: of equally good cuts the first is taken, whatever the rounding.
    EXPECT_EQ(parts.size(), 5u);
    EXPECT_LE(convex_parts(bin, 3).size(), 3u);
    EXPECT_TRUE(convex_parts({}, 3).empty());
}

}  // namespace
}  // namespace bsoil::scene::convex_parts_test
