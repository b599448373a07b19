/// The soil as a volume: what its voxels show, and that only what changed is read again.
#include "run/soil_volume.h"

#include <gtest/gtest.h>

#include <cmath>

namespace bsoil::scene::soil_volume_test {
namespace {

std::unique_ptr<Soil> level_ground() {
    SoilDef def;
    def.size_m = {2, 2, 1};
    def.up = UpAxis::z;
    def.backend = Backend::cpu;
    auto soil = Soil::create(def);
    EXPECT_TRUE(soil) << soil.error();
    EXPECT_TRUE((*soil)->fill(BoxFill{{{-2, -2, -2}, {2, 2, 0.425}}, {}}));
    return std::move(*soil);
}

const uint8_t* voxel(const SoilVolume& volume, int x, int y, int z) {
    const int* size = volume.data().size;
    return &volume.data().rgba[4 * static_cast<size_t>((z * size[1] + y) * size[0] + x)];
}

TEST(SoilVolume, soil_hides_as_much_as_there_is_of_it) {
    const auto soil = level_ground();
    SoilVolume volume(*soil, {});
    EXPECT_TRUE(volume.update());
    EXPECT_TRUE(volume.data().validate());
    EXPECT_EQ(voxel(volume, 3, 20, 7)[3], 255);
    EXPECT_NEAR(voxel(volume, 3, 20, 8)[3], 128, 32);  // a fill samples quarters of a voxel
    EXPECT_EQ(voxel(volume, 3, 20, 9)[3], 0);
    const MaterialDef sand = soil->materials()[0];
    for (size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(voxel(volume, 3, 20, 7)[c], 255 * std::sqrt(sand.color[c]), 1);
    }
}

TEST(SoilVolume, only_what_changed_is_new) {
    const auto soil = level_ground();
    SoilVolume volume(*soil, {});
    EXPECT_TRUE(volume.update());
    EXPECT_FALSE(volume.update());
    EXPECT_TRUE(soil->fill(BoxFill{{{0.5, 0.5, 0.4}, {0.6, 0.6, 0.6}}, {}}));
    EXPECT_TRUE(volume.update());
    EXPECT_EQ(voxel(volume, 31, 31, 10)[3], 255);
    EXPECT_FALSE(volume.update());
}

TEST(SoilVolume, a_field_hides_the_more_the_more_there_is_of_it) {
    const auto soil = level_ground();
    SoilVolume volume(*soil, {Field::density, 1000, 2000, 0});
    volume.update();
    const double density = soil->sample(3, 20, 7).density_kg_m3;
    EXPECT_NEAR(voxel(volume, 3, 20, 7)[3], 255 * (density - 1000) / 1000, 1);
    EXPECT_EQ(volume.bar().low, 1000);
    SoilVolume still(*soil, {Field::velocity, 0, 0, 0});
    still.update();
    EXPECT_EQ(voxel(still, 3, 20, 7)[3], 0);  // nothing moves
}

TEST(SoilVolume, moisture_is_a_field_where_a_soil_takes_water) {
    EXPECT_FALSE(has_field(level_ground()->materials(), Field::moisture));
    EXPECT_TRUE(has_field(level_ground()->materials(), Field::density));
    SoilDef def;
    def.size_m = {2, 2, 1};
    def.up = UpAxis::z;
    def.backend = Backend::cpu;
    def.materials = {materials::dry_sand()};
    def.materials[0].pore_water_fraction = 0.2;
    def.materials[0].placed_saturation = 0.5;
    const auto soil = Soil::create(def);
    ASSERT_TRUE(soil) << soil.error();
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-2, -2, -2}, {2, 2, 0.425}}, {}}));
    ASSERT_TRUE(has_field((*soil)->materials(), Field::moisture));
    SoilVolume volume(**soil, {Field::moisture, 0, 0, 0});
    volume.update();
    EXPECT_NEAR(voxel(volume, 3, 20, 5)[3], 128, 2);
}

// Dry sand as placed: (1 / 1430 - 1 / 1600) / (1 / 1430 - 1 / 1750) = 0.58.
TEST(SoilVolume, compaction_is_the_relative_density) {
    SoilDef def;
    def.size_m = {2, 2, 1};
    def.up = UpAxis::z;
    def.backend = Backend::cpu;
    const auto soil = Soil::create(def);
    ASSERT_TRUE(soil) << soil.error();
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-2, -2, -2}, {2, 2, 0.425}}, {}}));
    ASSERT_TRUE(has_field((*soil)->materials(), Field::compaction));
    SoilVolume volume(**soil, {Field::compaction, 0, 0, 0});
    volume.update();
    EXPECT_NEAR(voxel(volume, 3, 20, 5)[3], 0.58 * 255, 2);
    std::vector<MaterialDef> fixed = (*soil)->materials();
    fixed[0].loose_density_kg_m3 = fixed[0].compacted_density_kg_m3 = 0;
    EXPECT_FALSE(has_field(fixed, Field::compaction));
}

}  // namespace
}  // namespace bsoil::scene::soil_volume_test
