// The surface on which bodies and slopes stand, and how far up a column is filled: what rests is
// one rule, so that the two differ by a voxel's rounding and by terrain alone.
#include "soil/column_surface.h"

#include <gtest/gtest.h>

#include <random>

#include "base/layout.h"

namespace bsoil::column_surface_test {
namespace {

using namespace layout;

/// Terrain from the floor up, soil on it, air, and perhaps soil that hangs in that.
struct Column {
    std::vector<int32_t> terrain, volume;
    explicit Column(std::mt19937& random) : terrain(32, 0), volume(32, 0) {
        const auto any = [&random](int low, int high) {
            return std::uniform_int_distribution<int>(low, high)(random);
        };
        int z = any(0, 8);
        for (int i = 0; i < z; ++i) terrain[static_cast<size_t>(i)] = kVoxelFull;
        for (const int end = z + any(1, 8); z < end; ++z) {
            volume[static_cast<size_t>(z)] = any(kVoxelFull - kSupportSlack, kVoxelFull);
        }
        volume[static_cast<size_t>(z)] = any(1, kVoxelFull - kSupportSlack - 1);
        if (any(0, 1) == 1) volume[static_cast<size_t>(z) + 4] = any(1, kVoxelFull);
    }
    ColumnVoxels voxels() const { return {terrain.data(), volume.data(), 32, 1, nullptr}; }
};

TEST(ColumnSurface, is_where_the_fill_ends) {
    std::mt19937 random(1);
    for (int i = 0; i < 10000; ++i) {
        const Column column(random);
        const ColumnFill fill = column_fill(column.voxels());
        ASSERT_EQ(column_surface_q16(column.voxels()), fill.soil_q16) << i;
        ASSERT_EQ(fill.top_q16, fill.soil_q16) << i;
    }
}

TEST(ColumnSurface, rests_on_the_same_soil_as_the_fill_wherever_that_hangs) {
    std::mt19937 random(2);
    const std::vector<int32_t> amounts{
        0,         1, kVoxelFull / 2, kVoxelFull - kSupportSlack - 1, kVoxelFull - kSupportSlack,
        kVoxelFull};
    const std::vector<int32_t> terrain(6, 0);
    for (int i = 0; i < 10000; ++i) {
        std::vector<int32_t> volume(terrain.size());
        for (int32_t& v : volume) v = amounts[random() % amounts.size()];
        const ColumnVoxels column{terrain.data(), volume.data(), 6, 1, nullptr};
        const ColumnFill fill = column_fill(column);
        ASSERT_GE(column_surface_q16(column), fill.soil_q16) << i;
        ASSERT_LE(column_surface_q16(column), fill.soil_q16 + kSupportSlack) << i;
        // What hangs is above all that rests, and what stops slides is no more than what rests.
        ASSERT_TRUE(fill.hanging < 0 || fill.hanging * kVoxelFull >= fill.soil_q16) << i;
        ASSERT_EQ(fill.stop_q16, fill.soil_q16) << i;
    }
}

TEST(ColumnSurface, counts_a_voxel_that_carries_as_full) {
    for (int missing = 0; missing <= kSupportSlack; ++missing) {
        std::vector<int32_t> terrain(8, 0), volume(8, 0);
        volume[0] = kVoxelFull;
        volume[1] = kVoxelFull - missing;
        const ColumnVoxels column{terrain.data(), volume.data(), 8, 1, nullptr};
        ASSERT_EQ(column_fill(column).soil_q16, 2 * kVoxelFull - missing);
        ASSERT_EQ(column_surface_q16(column), 2 * kVoxelFull);
    }
}

TEST(ColumnSurface, ends_under_terrain_that_hangs_over_it) {
    std::vector<int32_t> terrain(8, 0), volume(8, 0);
    volume[0] = kVoxelFull;
    terrain[5] = kVoxelFull;
    const ColumnVoxels column{terrain.data(), volume.data(), 8, 1, nullptr};
    EXPECT_EQ(column_surface_q16(column), kVoxelFull);
    EXPECT_EQ(column_fill(column).soil_q16, kVoxelFull);
    EXPECT_EQ(column_fill(column).top_q16, 6 * kVoxelFull);
}

TEST(ColumnSurface, bare_ground_has_a_top_and_no_soil) {
    std::vector<int32_t> terrain(8, 0), volume(8, 0);
    for (size_t z = 0; z < 3; ++z) terrain[z] = kVoxelFull;
    const ColumnVoxels column{terrain.data(), volume.data(), 8, 1, nullptr};
    EXPECT_EQ(column_fill(column).top_q16, 3 * kVoxelFull);
    EXPECT_EQ(column_fill(column).soil_q16, 0);
    EXPECT_EQ(column_surface_q16(column), kTerrainTop - 3 * kVoxelFull);
}

}  // namespace
}  // namespace bsoil::column_surface_test
