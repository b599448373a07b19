/// Wet soil is darker and glossier than dry soil, in walls too.
#include <cmath>

#include "bsoil/soil.h"
#include "mesh_checks.h"
#include "render_fixture.h"

namespace bsoil::render::wet_surface_test {
namespace {

/// A square before the eye, of one colour whatever its water.
Mesh square(uint8_t wetness) {
    Mesh mesh =
        triangle_mesh({{{-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}}, {{0, 1, 2}, {0, 2, 3}}},
                      {0.2f, 0.16f, 0.1f});
    mesh.wetness.assign(mesh.vertex_count(), wetness);
    return mesh;
}

TEST_F(Render, soil_is_the_glossier_the_wetter_it_is) {
    View view = front_view();
    view.items = {item_of({}, {})};
    view.items[0].grain_m = 0.02f;
    const auto brightness_of = [&](uint8_t wetness, Vec3 to_sun) {
        const MeshId mesh = renderer_->add_mesh(square(wetness));
        view.items[0].mesh = mesh;
        view.to_sun = to_sun;
        const Image image = draw(view);
        renderer_->remove_mesh(mesh);
        return mean_brightness(image, 140, 80, 180, 120);
    };
    // The sun's mirror image is in the picture's middle, or far aside.
    constexpr Vec3 kMirrored{0, 0, 1}, kAside{1, 0, 1};
    const double dry = brightness_of(0, kMirrored), damp = brightness_of(128, kMirrored),
                 full = brightness_of(255, kMirrored);
    EXPECT_GT(damp, dry + 10);
    EXPECT_GT(full, damp + 20);
    // There gloss is not seen, but that a film sends a little of the sky back.
    const double dry_aside = brightness_of(0, kAside);
    EXPECT_NEAR(brightness_of(128, kAside), dry_aside, 3);
    EXPECT_NEAR(brightness_of(255, kAside), dry_aside, 12);
}

TEST_F(Render, a_film_of_water_covers_the_grains) {
    View view = front_view();
    view.items = {item_of({}, {})};
    view.items[0].grain_m = 0.05f;
    const auto roughness = [&](uint8_t wetness) {
        const MeshId mesh = renderer_->add_mesh(square(wetness));
        view.items[0].mesh = mesh;
        const Image image = draw(view);
        renderer_->remove_mesh(mesh);
        const double mean = mean_brightness(image, 0, 0, 320, 200);
        double sum = 0;
        for (int y = 0; y < 200; ++y) {
            for (int x = 0; x < 320; ++x) sum += std::pow(brightness(image, x, y) - mean, 2);
        }
        return std::sqrt(sum / (320 * 200));
    };
    const double dry = roughness(0);
    EXPECT_GT(dry, 3);
    EXPECT_NEAR(roughness(128), dry, 0.25 * dry);
    EXPECT_LT(roughness(255), 0.8 * dry);
}

TEST(WetSurface, the_water_table_is_seen_in_cuts_and_on_walls) {
    SoilDef def;
    def.size_m = {1.6, 1.6, 1.2};
    def.up = UpAxis::z;
    def.backend = Backend::cpu;
    def.water_table_m = 0.4;
    MaterialDef gravel = materials::gravel();  // draws no water up
    gravel.pore_water_fraction = 0.2;
    gravel.conductivity_m_s = 1e-2;
    gravel.moist_cohesion_pa = 0;
    def.materials = {gravel};
    auto soil = Soil::create(def);
    ASSERT_TRUE(soil) << soil.error();
    // Two banks with a trench between them.
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-0.8, -0.8, 0}, {-0.2, 0.8, 0.8}}, "gravel"}));
    ASSERT_TRUE((*soil)->fill(BoxFill{{{0.2, -0.8, 0}, {0.8, 0.8, 0.8}}, "gravel"}));
    const SoilTiles tiles(**soil);
    SurfaceMesher mesher(tiles);
    mesher.update();
    Mesh mesh;
    mesher.gather(mesh);
    ASSERT_EQ(mesh.wetness.size(), mesh.vertex_count());
    int wet_count[2] = {0, 0}, dry_count[2] = {0, 0};
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 at = test::vertex(mesh, v);
        const bool is_cut = std::abs(std::abs(at.x) - 0.8) < 1e-6;
        const bool is_wall = std::abs(std::abs(at.x) - 0.2) < 0.03 && std::abs(at.y) < 0.7;
        if ((!is_cut && !is_wall) || at.z < 0.06) continue;
        const double share =
            static_cast<double>(mesh.colors[3 * v]) / static_cast<double>(gravel.color[0]);
        if (at.z < 0.34) {
            EXPECT_EQ(mesh.wetness[v], 255) << at.z;
            EXPECT_NEAR(share, 0.5, 1e-5);
            ++wet_count[is_wall];
        } else if (at.z > 0.46 && at.z < 0.65) {
            EXPECT_EQ(mesh.wetness[v], 0) << at.z;
            EXPECT_NEAR(share, 1, 1e-5);
            ++dry_count[is_wall];
        }
    }
    for (int wall = 0; wall < 2; ++wall) {
        EXPECT_GT(wet_count[wall], 40) << wall;
        EXPECT_GT(dry_count[wall], 3) << wall;
    }
}

TEST(WetSurface, meshes_of_dry_soil_say_nothing_of_water) {
    Mesh dry = square(0), wet = square(200);
    dry.wetness.clear();
    Mesh both = dry;
    both.append(wet);
    ASSERT_EQ(both.wetness.size(), both.vertex_count());
    EXPECT_EQ(both.wetness.front(), 0);
    EXPECT_EQ(both.wetness.back(), 200);
    both.append(dry);
    ASSERT_EQ(both.wetness.size(), both.vertex_count());
    EXPECT_EQ(both.wetness.back(), 0);
    const std::vector<uint32_t> once = dry.indices;
    const auto count = static_cast<uint32_t>(dry.vertex_count());
    dry.append(dry);
    EXPECT_TRUE(dry.wetness.empty());
    ASSERT_EQ(dry.indices.size(), 2 * once.size());
    EXPECT_EQ(dry.indices.back(), once.back() + count);
}

}  // namespace
}  // namespace bsoil::render::wet_surface_test
