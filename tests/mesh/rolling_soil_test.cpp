// Soil that rolls along the ground, as the mesher gives it to pictures.
#include <gtest/gtest.h>

#include <cmath>

#include "bsoil/surface_mesh.h"
#include "voxel_tiles.h"

namespace bsoil::rolling_soil_test {
namespace {

/// All that rolls.
std::vector<RollingSoil> rolling_soil(const SurfaceMesher& mesher) {
    std::vector<RollingSoil> all;
    for (int ty = 0; ty < mesher.tile_count_y(); ++ty) {
        for (int tx = 0; tx < mesher.tile_count_x(); ++tx) {
            const auto rolling = mesher.rolling_soil(tx, ty);
            all.insert(all.end(), rolling.begin(), rolling.end());
        }
    }
    return all;
}

TEST(RollingSoil, rolls_down_its_slope_until_it_rests) {
    test::VoxelTiles tiles(24, 24, 24);
    tiles.frame().voxel_m = 0.1;
    tiles.fill_heights([](double x, double) { return 18 - 0.5 * x; });
    for (MaterialDef& material : tiles.materials()) {
        material.friction_angle_rad = std::atan(0.48);  // a third of the excess that rolls in full
    }
    SurfaceMesher mesher(tiles);
    mesher.update();
    EXPECT_TRUE(rolling_soil(mesher).empty());

    // Columns 6..11 of row 10, in two tiles; what slips slowly looks as if it rested.
    tiles.set_motion([](int x, int y) {
        GroundMotion motion;
        if (y == 10 && x >= 6 && x < 12) motion.slip_m_s = 0.6;
        if (y == 12) motion.slip_m_s = 0.01;
        return motion;
    });
    tiles.touch(6, 10), tiles.touch(8, 10);
    mesher.update();
    const std::vector<RollingSoil> found = rolling_soil(mesher);
    ASSERT_EQ(found.size(), 6u);
    const Vec3 downhill = Vec3{2, 0, -1} * (1 / std::sqrt(5.0));
    for (size_t i = 0; i < found.size(); ++i) {
        const double x = 6.5 + static_cast<double>(i);
        EXPECT_LT(length(found[i].velocity_m_s - 0.6 * downhill), 1e-6);
        EXPECT_NEAR(found[i].amount, 0.6f / 3, 1e-4f);  // tops are floats
        EXPECT_LT(length(found[i].normal - Vec3{1, 0, 2} * (1 / std::sqrt(5.0))), 1e-6);
        // The surface runs through the columns' tops.
        EXPECT_LT(length(found[i].center_m - 0.1 * Vec3{x, 10.5, 18 - 0.5 * x}), 1e-6);
    }

    // However fast, where the slope stands nothing rolls.
    for (MaterialDef& material : tiles.materials()) material.friction_angle_rad = 0.6;
    tiles.touch(6, 10), tiles.touch(8, 10);
    mesher.update();
    EXPECT_TRUE(rolling_soil(mesher).empty());
    for (MaterialDef& material : tiles.materials()) material.friction_angle_rad = 0.3;
    tiles.touch(6, 10), tiles.touch(8, 10);
    mesher.update();
    EXPECT_EQ(rolling_soil(mesher).size(), 6u);

    tiles.set_motion({});
    EXPECT_EQ(mesher.update().tile_read_count, 0);  // nothing else has changed
    EXPECT_TRUE(rolling_soil(mesher).empty());
}

TEST(RollingSoil, slides_on_along_level_ground_with_its_momentum) {
    test::VoxelTiles tiles(8, 8, 8);
    const double half = std::sqrt(0.5);
    tiles.frame().grid_to_world = {{0, 0, 0}, {-half, 0, 0, half}};  // y is up
    tiles.fill_heights([](double, double) { return 4.25; });
    tiles.set_motion([](int x, int y) {
        GroundMotion motion;
        if (x == 3 && y == 4) motion.velocity_m_s = {0.5, -0.2, 0.3};
        if (x == 5 && y == 4) motion.velocity_m_s = {0, -2, 0};  // falls: not along the ground
        if (x == 6 && y == 2) motion.slip_m_s = 1;               // nowhere to go
        return motion;
    });
    SurfaceMesher mesher(tiles);
    mesher.update();
    const std::vector<RollingSoil> found = rolling_soil(mesher);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_LT(length(found[0].velocity_m_s - Vec3{0.5, 0, 0.3}), 1e-6);
    EXPECT_LT(length(found[0].normal - Vec3{0, 1, 0}), 1e-6);
    EXPECT_LT(length(found[0].center_m - Vec3{3.5, 4.25, -4.5}), 1e-6);
}

TEST(RollingSoil, goes_over_the_edge_of_a_step) {
    test::VoxelTiles tiles(16, 8, 16);
    tiles.fill_heights([](double x, double) { return x < 8 ? 12 : 4; });
    tiles.set_motion([](int x, int) { return GroundMotion{x == 7 ? 1.0 : 0.0, {}}; });
    SurfaceMesher mesher(tiles);
    mesher.update();
    const std::vector<RollingSoil> found = rolling_soil(mesher);
    ASSERT_EQ(found.size(), 8u);
    for (const RollingSoil& soil : found) {
        EXPECT_EQ(soil.amount, 1);
        EXPECT_NEAR(length(soil.velocity_m_s), 1, 1e-6);
        EXPECT_GT(soil.velocity_m_s.x, 0.5);
        EXPECT_NEAR(soil.velocity_m_s.y, 0, 1e-6);
        EXPECT_LT(soil.velocity_m_s.z, -0.5);
    }
}

}  // namespace
}  // namespace bsoil::rolling_soil_test
