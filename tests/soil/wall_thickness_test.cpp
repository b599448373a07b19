// Which shapes are thickened for the soil, and by how much.
#include "contact/wall_thickness.h"

#include "soil_fixture.h"

namespace bsoil::wall_thickness_test {
namespace {

constexpr double kVoxel = 0.05;

TEST(WallThickness, sheets_get_two_voxels) {
    const ConvexShape plate = box_shape({0.2, 0.005, 0.3});
    const SheetGrowth growth = sheet_growth(plate, kVoxel);
    EXPECT_DOUBLE_EQ(growth.thickness_m, 0.01);
    EXPECT_DOUBLE_EQ(growth.rim_share(), 0.1);
    const ConvexShape wall = thickened(plate, growth);
    EXPECT_DOUBLE_EQ(wall.half_extents_m.x, 0.2);
    EXPECT_DOUBLE_EQ(wall.half_extents_m.y, 0.05);
    EXPECT_DOUBLE_EQ(wall.half_extents_m.z, 0.3);
    const ConvexShape disc = round_shape(ConvexShape::Kind::cylinder, 0.3, 0.01);
    EXPECT_DOUBLE_EQ(thickened(disc, sheet_growth(disc, kVoxel)).half_height_m, 0.05);
}

TEST(WallThickness, rounding_counts_as_thickness) {
    ConvexShape plate = box_shape({0.2, 0.03, 0.3});
    plate.rounding_m = 0.01;
    EXPECT_DOUBLE_EQ(
        thickened(plate, sheet_growth(plate, kVoxel)).half_extents_m.y + plate.rounding_m, 0.05);
}

TEST(WallThickness, blocks_bars_and_pebbles_stay) {
    EXPECT_FALSE(sheet_growth(box_shape({0.2, 0.05, 0.3}), kVoxel).is_thin());
    EXPECT_FALSE(sheet_growth(box_shape({0.2, 0.01, 0.01}), kVoxel).is_thin());
    EXPECT_FALSE(sheet_growth(box_shape({0.01, 0.01, 0.01}), kVoxel).is_thin());
    EXPECT_FALSE(sheet_growth(sphere_shape(0.01), kVoxel).is_thin());
    EXPECT_FALSE(
        sheet_growth(round_shape(ConvexShape::Kind::cylinder, 0.01, 0.3), kVoxel).is_thin());
    EXPECT_FALSE(sheet_growth(octahedron_shape(0.02), kVoxel).is_thin());
}

ConvexShape box_hull(Vec3 half) {
    ConvexShape hull;
    hull.kind = ConvexShape::Kind::hull;
    hull.bound_m = length(half);
    hull.planes = {{{1, 0, 0}, half.x},  {{-1, 0, 0}, half.x}, {{0, 1, 0}, half.y},
                   {{0, -1, 0}, half.y}, {{0, 0, 1}, half.z},  {{0, 0, -1}, half.z}};
    return hull;
}

TEST(WallThickness, hulls_are_thickened_like_boxes) {
    const ConvexShape plate = box_hull({0.2, 0.3, 0.005});
    const ConvexShape wall = thickened(plate, sheet_growth(plate, kVoxel));
    EXPECT_DOUBLE_EQ(wall.planes[0].offset, 0.2);
    EXPECT_DOUBLE_EQ(wall.planes[2].offset, 0.3);
    EXPECT_DOUBLE_EQ(wall.planes[4].offset, 0.05);
    EXPECT_DOUBLE_EQ(wall.planes[5].offset, 0.05);
    EXPECT_GE(wall.bound_m, length(Vec3{0.2, 0.3, 0.05}));
    EXPECT_FALSE(sheet_growth(box_hull({0.2, 0.005, 0.005}), kVoxel).is_thin());
}

}  // namespace
}  // namespace bsoil::wall_thickness_test
