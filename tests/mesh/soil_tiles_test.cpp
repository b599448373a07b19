#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <vector>

#include "bsoil/surface_mesh.h"
#include "mesh_checks.h"

namespace bsoil::soil_tiles_test {
namespace {

TEST(SoilTiles, box_of_soil_meshes_to_its_own_volume_with_either_axis_up) {
    for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
        SoilDef def;
        def.size_m = up == UpAxis::y ? Vec3{2, 1, 1.5} : Vec3{2, 1.5, 1};
        def.up = up;
        def.backend = Backend::cpu;
        Result<std::unique_ptr<Soil>> soil = Soil::create(def);
        ASSERT_TRUE(soil) << soil.error();
        // Level ground to 0.42 m over the whole grid: a partial voxel on top.
        const Vec3 top = up == UpAxis::y ? Vec3{2, 0.42, 2} : Vec3{2, 2, 0.42};
        const Status filled = (*soil)->fill(BoxFill{{{-2, -2, -2}, top}, {}});
        ASSERT_TRUE(filled) << filled.error();
        const SoilTiles tiles(**soil);
        SurfaceMesher mesher(tiles);
        mesher.update();
        Mesh mesh;
        mesher.gather(mesh);
        EXPECT_EQ(test::open_edge_count(mesh), 0);
        EXPECT_NEAR(test::enclosed_volume(mesh), 2 * 1.5 * 0.42, 0.01);
        double highest = 0;
        for (size_t v = 0; v < mesh.vertex_count(); ++v) {
            const Vec3 p = test::vertex(mesh, v);
            highest = std::max(highest, up == UpAxis::y ? p.y : p.z);
        }
        // Whether a voxel is inside is found by sampling: a quarter of 5 cm.
        EXPECT_NEAR(highest, 0.42, 0.0125);
    }
}

/// Sand as poured and levelled: a plate compacts it.
MaterialDef loose_sand() {
    MaterialDef sand = materials::dry_sand();
    sand.name = "loose_sand";
    sand.density_kg_m3 = 1450;
    return sand;
}

/// Level ground of two materials: in the left half sand, in the right gravel.
Result<std::unique_ptr<Soil>> sand_beside_gravel() {
    SoilDef def;
    def.size_m = {1.6, 0.8, 0.8};
    def.up = UpAxis::z;
    def.backend = Backend::cpu;
    def.materials = {loose_sand(), materials::gravel()};
    auto soil = Soil::create(def);
    if (!soil) return soil;
    for (const auto& [low, high, name] :
         {std::tuple{-1.0, 0.0, "loose_sand"}, std::tuple{0.0, 1.0, "gravel"}}) {
        const Status filled = (*soil)->fill(BoxFill{{{low, -1, -1}, {high, 1, 0.4}}, name});
        if (!filled) return Error{filled.error()};
    }
    return soil;
}

float brightness(const std::array<float, 3>& color) { return color[0] + color[1] + color[2]; }

TEST(SoilTiles, untouched_ground_has_its_materials_colours) {
    auto soil = sand_beside_gravel();
    ASSERT_TRUE(soil) << soil.error();
    const SoilTiles tiles(**soil);
    EXPECT_EQ(tiles.color_at(2, 8, 7, 0), loose_sand().color);
    EXPECT_EQ(tiles.color_at(29, 8, 7, 1), materials::gravel().color);
}

TEST(SoilTiles, a_single_voxel_in_the_air_is_grains_at_the_end_of_any_grid) {
    for (const int size : {8, 12, 15, 16}) {
        SoilDef def;
        def.voxel_m = 0.1;
        def.size_m = {0.1 * size, 0.8, 0.8};
        def.up = UpAxis::z;
        def.backend = Backend::cpu;
        auto soil = Soil::create(def);
        ASSERT_TRUE(soil) << soil.error();
        ASSERT_EQ((*soil)->frame().size[0], size);
        const Vec3 middle = (*soil)->frame().to_world({size - 0.5, 3.5, 5.5});
        const Vec3 half{0.05, 0.05, 0.05};
        ASSERT_TRUE((*soil)->fill(BoxFill{{middle - half, middle + half}, {}}));
        const SoilTiles tiles(**soil);
        SurfaceMesher mesher(tiles);
        mesher.update();
        EXPECT_EQ(mesher.loose_soil((size - 1) / 8, 0).size(), 1u) << size;
        Mesh mesh;
        mesher.gather(mesh);
        EXPECT_EQ(mesh.triangle_count(), 0u) << size;
    }
}

TEST(SoilTiles, other_colours_show_wherever_soil_lies_bare) {
    auto soil = sand_beside_gravel();
    ASSERT_TRUE(soil) << soil.error();
    const SoilTiles tiles(**soil);
    SurfaceMesher mesher(tiles);
    mesher.update();
    SoilDef def = (*soil)->def();
    def.materials[0].color = {0.1f, 0.2f, 0.3f};
    ASSERT_TRUE((*soil)->change(def));
    mesher.update();
    Mesh mesh, expected;
    mesher.gather(mesh);
    SurfaceMesher as_new(tiles);
    as_new.update();
    as_new.gather(expected);
    EXPECT_EQ(mesh.colors, expected.colors);  // of the top, the sides and the floor
    EXPECT_EQ(mesh.palette, expected.palette);
}

TEST(SoilTiles, moved_soil_is_darker_and_compacted_soil_paler_than_settled_ground) {
    auto soil = sand_beside_gravel();
    ASSERT_TRUE(soil) << soil.error();
    const SoilTiles tiles(**soil);
    // A plate goes down into the sand. Below it the sand is compacted, beside it some is moved.
    SoilBody plate;
    ConvexShape box;
    box.half_extents_m = {0.15, 0.15, 0.05};
    const std::vector<ConvexShape> shapes{box};
    plate.shapes = &shapes;
    plate.id = 1;
    plate.linear_velocity_m_s = {0, 0, -0.3};
    plate.contact_pressure_pa = 2e5;
    for (int step = 0; step < 24; ++step) {
        plate.pose.position = {-0.4, 0, 0.45 - 0.005 * step};
        plate.center_of_mass_m = plate.pose.position;
        (*soil)->step({&plate, 1});
    }
    const float settled = brightness(loose_sand().color);
    float palest = 0, darkest = 10;
    double densest = 0;
    for (int z = 0; z < 10; ++z) {
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 15; ++x) {
                if ((*soil)->sample(x, y, z).volume < 0.1) continue;
                densest = std::max(densest, (*soil)->sample(x, y, z).density_kg_m3);
                const float here = brightness(tiles.color_at(x, y, z, 0));
                palest = std::max(palest, here);
                darkest = std::min(darkest, here);
            }
        }
    }
    EXPECT_GT(palest, 1.05f * settled) << "densest " << densest;
    EXPECT_LT(darkest, 0.9f * settled);
}

TEST(SoilTiles, a_mixture_has_the_mean_of_its_colours_and_the_weights_of_its_materials) {
    SoilDef def;
    def.size_m = {0.8, 0.8, 0.8};
    def.up = UpAxis::z;
    def.backend = Backend::cpu;
    def.materials = {materials::dry_sand(), materials::clay(), materials::gravel(),
                     materials::sandy_loam()};
    auto soil = Soil::create(def);
    ASSERT_TRUE(soil) << soil.error();
    // In each voxel a layer of every material, as thick as its share by volume.
    const double shares[] = {0.4, 0.3, 0.2, 0.1};
    double from_m = 0;
    for (int z = 0; z < 4; ++z) {
        for (size_t m = 0; m < 4; ++m) {
            const double to_m = from_m + shares[m] * def.voxel_m;
            const BoxFill layer{{{-1, -1, from_m}, {1, 1, to_m}}, def.materials[m].name};
            ASSERT_TRUE((*soil)->fill(layer));
            from_m = to_m;
        }
    }
    const SoilTiles tiles(**soil);
    const MaterialWeights weights = tiles.weights_at(8, 8, 3, 0);
    const std::array<float, 3> color = tiles.color_at(8, 8, 3, 0);
    double mass_share = 0;
    for (const double share : (*soil)->material_shares(8, 8, 3)) mass_share += share;
    EXPECT_NEAR(mass_share, 1, 1e-12);
    std::array<double, 3> mean{};
    for (size_t m = 0; m < 4; ++m) {
        EXPECT_NEAR(weights[m], 255 * shares[m], 17) << "material " << m;  // one step
        for (size_t c = 0; c < 3; ++c) {
            mean[c] += shares[m] * static_cast<double>(def.materials[m].color[c]);
        }
    }
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(color[c], mean[c], 0.03);  // by those steps

    SurfaceMesher mesher(tiles);
    mesher.update();
    Mesh mesh;
    mesher.gather(mesh);
    EXPECT_EQ(mesh.palette.size(), 4u);
    ASSERT_EQ(mesh.weights.size(), mesh.vertex_count());
    int mixed = 0;
    for (const MaterialWeights& at : mesh.weights) mixed += at == weights;
    EXPECT_GT(mixed, 16 * 16);  // the whole top
    Mesh other;
    other.positions = {0, 0, 0};
    mesh.append(other);
    EXPECT_TRUE(mesh.weights.empty());  // of a soil and something else there is no one palette
}

TEST(SoilTiles, the_sides_of_the_grid_show_mixtures_as_the_surface_does) {
    SoilDef def;
    def.size_m = {0.8, 0.8, 0.8};
    def.up = UpAxis::z;
    def.backend = Backend::cpu;
    def.materials = {materials::dry_sand(), materials::clay()};
    auto soil = Soil::create(def);
    ASSERT_TRUE(soil) << soil.error();
    // Six voxels of three parts sand and two of clay, then four of clay alone.
    for (int z = 0; z < 6; ++z) {
        const double low = z * def.voxel_m, middle = low + 0.6 * def.voxel_m;
        ASSERT_TRUE((*soil)->fill(BoxFill{{{-1, -1, low}, {1, 1, middle}}, "dry_sand"}));
        ASSERT_TRUE((*soil)->fill(BoxFill{{{-1, -1, middle}, {1, 1, low + def.voxel_m}}, "clay"}));
    }
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-1, -1, 0.3}, {1, 1, 0.5}}, "clay"}));
    const SoilTiles tiles(**soil);
    const MaterialWeights mixture = tiles.weights_at(0, 5, 2, 0),
                          alone = tiles.weights_at(0, 5, 8, 1);
    EXPECT_GT(mixture[1], 50);
    EXPECT_GT(mixture[0], mixture[1]);
    EXPECT_EQ(alone, (MaterialWeights{0, 255}));
    SurfaceMesher mesher(tiles);
    for (const uint8_t level : {uint8_t{0}, uint8_t{1}}) {
        SCOPED_TRACE(static_cast<int>(level));
        const std::vector<uint8_t> levels(4, level);
        mesher.update(levels);
        Mesh mesh;
        mesher.gather(mesh);
        int mixed_count = 0, alone_count = 0;
        const float share = static_cast<float>(mixture[1]) / (mixture[0] + mixture[1]);
        for (size_t v = 0; v < mesh.vertex_count(); ++v) {
            const Vec3 at = test::vertex(mesh, v);
            const bool is_at_side =
                std::abs(std::abs(at.x) - 0.4) < 1e-6 && std::abs(mesh.normals[3 * v]) > 0.99f;
            if (!is_at_side || at.z < 0.01) continue;
            if (at.z < 0.26) {
                EXPECT_EQ(mesh.weights[v], mixture) << at.z;
                const float red = (1 - share) * mesh.palette[0][0] + share * mesh.palette[1][0];
                EXPECT_NEAR(mesh.colors[3 * v], red, 1e-5f);
                ++mixed_count;
            } else if (at.z > 0.34) {
                EXPECT_EQ(mesh.weights[v], alone) << at.z;
                EXPECT_EQ(mesh.colors[3 * v], mesh.palette[1][0]);
                ++alone_count;
            }
        }
        EXPECT_GT(mixed_count, 10);
        EXPECT_GT(alone_count, 10);
        EXPECT_EQ(test::open_edge_count(mesh), 0);
    }
}

TEST(SoilTiles, neither_wet_nor_cohesive_soil_makes_dust) {
    SoilDef def;
    def.size_m = {0.8, 0.8, 0.8};
    def.backend = Backend::cpu;
    MaterialDef wet = materials::dry_sand(), damp = wet;
    wet.name = "wet", damp.name = "damp";
    wet.pore_water_fraction = damp.pore_water_fraction = 0.2;
    wet.placed_saturation = 0.5, damp.placed_saturation = 0.05;
    def.materials = {materials::dry_sand(), wet, damp, materials::clay()};
    const float expected[] = {1, 0, 0.5f, 0};
    for (size_t m = 0; m < 4; ++m) {
        auto soil = Soil::create(def);
        ASSERT_TRUE(soil) << soil.error();
        ASSERT_TRUE((*soil)->fill(BoxFill{{{-1, 0, -1}, {1, 0.4, 1}}, def.materials[m].name}));
        EXPECT_NEAR(SoilTiles(**soil).dust_at(8, 8, 3, static_cast<int>(m)), expected[m], 0.01)
            << def.materials[m].name;
    }
}

}  // namespace
}  // namespace bsoil::soil_tiles_test
