/// Walls inside the grid show what is inside the soil, as the sides of the grid do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "bsoil/material.h"
#include "mesh_checks.h"
#include "voxel_tiles.h"

namespace bsoil::bare_walls_test {
namespace {

using test::VoxelTiles;

/// Mixtures by the voxel's place.
class MixedTiles final : public test::SameTiles {
  public:
    using SameTiles::SameTiles;
    MaterialWeights weights_at(int x, int y, int z, int) const override {
        return {static_cast<uint8_t>(10 + z), static_cast<uint8_t>(10 + 2 * (x % 7 + y % 5))};
    }
};

TEST(BareWalls, of_a_dug_trench_show_the_mixture_at_their_height) {
    VoxelTiles tiles(40, 24, 30);
    // A trench across the border between two tiles.
    tiles.fill_heights([](double x, double) { return x > 12 && x < 20 ? 5.0 : 25.0; });
    const MixedTiles mixed(tiles);
    SurfaceMesher mesher(mixed);
    mesher.update();
    Mesh mesh;
    mesher.gather(mesh);
    int wall_count = 0;
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 at = test::vertex(mesh, v);
        const bool is_wall = std::abs(at.x - 12) < 0.1 || std::abs(at.x - 20) < 0.1;
        // Below what is seen of the top, and off the sides of the grid.
        if (!is_wall || at.z < 6 || at.z > 23 || at.y < 1 || at.y > 23) continue;
        const int x = at.x < 16 ? 11 : 20, y = static_cast<int>(at.y), z = static_cast<int>(at.z);
        ASSERT_EQ(mesh.weights[v], mixed.weights_at(x, y, z, 0)) << at.x << " " << at.z;
        const auto [a, b] = std::pair{mesh.weights[v][0], mesh.weights[v][1]};
        const auto red = static_cast<float>(a * tiles.materials()[0].color[0] +
                                            b * tiles.materials()[1].color[0]) /
                         static_cast<float>(a + b);
        ASSERT_NEAR(mesh.colors[3 * v], red, 1e-5f);
        ++wall_count;
    }
    EXPECT_GT(wall_count, 2 * 20 * 16);
}

TEST(BareWalls, a_mesh_that_follows_a_dig_equals_a_new_one) {
    VoxelTiles tiles(40, 32, 20);
    tiles.fill_heights([](double, double) { return 15.0; });
    const MixedTiles mixed(tiles);
    SurfaceMesher mesher(mixed);
    std::mt19937 random(41);
    std::uniform_int_distribution<int> x(0, 39), y(0, 31), depth(0, 19);
    Mesh updated, fresh;
    for (int round = 0; round < 80; ++round) {
        const int at_x = x(random), at_y = y(random), bottom = depth(random);
        for (int u = at_x; u < std::min(40, at_x + 3); ++u) {
            for (int z = 0; z < 20; ++z) tiles.volume(u, at_y, z) = z < bottom ? 1.0f : 0.0f;
            tiles.touch(u, at_y);
        }
        mesher.update();
        mesher.gather(updated);
        SurfaceMesher other(mixed);
        other.update();
        other.gather(fresh);
        ASSERT_EQ(updated.weights, fresh.weights) << round;
        ASSERT_EQ(updated.colors, fresh.colors) << round;
        ASSERT_EQ(updated.positions, fresh.positions) << round;
    }
}

}  // namespace
}  // namespace bsoil::bare_walls_test
