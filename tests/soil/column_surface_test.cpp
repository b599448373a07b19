// A column's surface is told twice: by the kernels' text, which bodies and slopes stand on, and by
// what settles soil and draws it. Both say the same of what both are asked about.
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

TEST(ColumnSurface, kernels_and_host_say_the_same_of_a_pile) {
    std::mt19937 random(1);
    for (int i = 0; i < 10000; ++i) {
        const Column column(random);
        const ColumnProfile profile = column_profile(column.voxels());
        ASSERT_EQ(column_surface_q16(column.voxels()), profile.soil_q16) << i;
        ASSERT_EQ(profile.top_q16, profile.soil_q16) << i;
    }
}

TEST(ColumnSurface, rounding_in_the_topmost_voxel_is_all_they_differ_by) {
    for (int missing = 0; missing <= kSupportSlack; ++missing) {
        std::vector<int32_t> terrain(8, 0), volume(8, 0);
        volume[0] = kVoxelFull;
        volume[1] = kVoxelFull - missing;
        const ColumnVoxels column{terrain.data(), volume.data(), 8, 1, nullptr};
        ASSERT_EQ(column_profile(column).soil_q16, 2 * kVoxelFull - missing);
        // Spans count a voxel that carries as full.
        ASSERT_EQ(column_surface_q16(column), 2 * kVoxelFull);
    }
}

TEST(ColumnSurface, bare_ground_has_a_top_and_no_soil) {
    std::vector<int32_t> terrain(8, 0), volume(8, 0);
    for (size_t z = 0; z < 3; ++z) terrain[z] = kVoxelFull;
    const ColumnVoxels column{terrain.data(), volume.data(), 8, 1, nullptr};
    EXPECT_EQ(column_profile(column).top_q16, 3 * kVoxelFull);
    EXPECT_EQ(column_profile(column).soil_q16, 0);
    EXPECT_EQ(column_surface_q16(column), kTerrainTop - 3 * kVoxelFull);
}

}  // namespace
}  // namespace bsoil::column_surface_test
