/// Dust over soil that moves fast.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "render_fixture.h"
#include "voxel_tiles.h"

namespace bsoil::render::dust_test {
namespace {

/// A stream of thin soil that falls from high up on level ground.
struct Stream {
    test::VoxelTiles tiles{16, 16, 64};

    Stream() {
        tiles.frame().voxel_m = 0.05;
        tiles.fill_heights([](double, double) { return 4; });
        for (int z = 4; z < 64; ++z) {
            for (int x = 4; x < 12; ++x) {
                for (int y = 4; y < 12; ++y) tiles.volume(x, y, z) = 0.2f;
            }
        }
    }
    std::vector<DustPuff> dust(Vec3 velocity_m_s, double cohesion_pa) {
        tiles.set_velocity(velocity_m_s);
        for (MaterialDef& material : tiles.materials()) material.cohesion_pa = cohesion_pa;
        SurfaceMesher mesher(tiles);
        mesher.update();
        std::vector<DustPuff> dust;
        append_dust(mesher, dust);
        return dust;
    }
};

TEST(Dust, rises_where_dry_soil_lands_fast) {
    Stream stream;
    EXPECT_TRUE(stream.dust({0, 0, -1}, 0).empty());
    EXPECT_TRUE(stream.dust({0, 0, -5}, 1000).empty());
    const std::vector<DustPuff> dust = stream.dust({0, 0, -5}, 0);
    // Of 8 x 8 columns with three voxels near the ground every second one, and fewer of the 56
    // above them. Standard deviations are 7 and 26.
    const auto lands = std::count_if(dust.begin(), dust.end(),
                                     [](const DustPuff& puff) { return puff.center.z < 8 * 0.05; });
    EXPECT_NEAR(static_cast<double>(lands), 8 * 8 * 3 / 2, 20);
    EXPECT_NEAR(static_cast<double>(dust.size()) - static_cast<double>(lands),
                8 * 8 * 56 / 2 * std::sqrt(0.15), 80);
    for (const DustPuff& puff : dust) {
        EXPECT_GT(puff.strength, 0.3f);
        EXPECT_LE(puff.strength, 1.0f);
    }
}

TEST(Dust, is_less_where_soil_rolls) {
    test::VoxelTiles tiles(32, 32, 32);
    tiles.fill_heights([](double x, double) { return 4 + 0.8 * x; });
    double speed = 0.9;
    tiles.set_motion([&speed](int, int) { return GroundMotion{speed, {}}; });
    const auto count = [&] {
        SurfaceMesher mesher(tiles);
        mesher.update();
        std::vector<DustPuff> dust;
        append_dust(mesher, dust);
        return static_cast<double>(dust.size());
    };
    EXPECT_EQ(count(), 0);
    speed = 5;
    EXPECT_NEAR(count(), 32 * 32 / 2 * std::sqrt(0.1), 40);
}

/// Dust in the middle of the picture, at the height of its life.
DustPuff puff(uint32_t seed) {
    DustPuff puff;
    puff.side_m = 0.1f;
    puff.color = {0.8f, 0.5f, 0.2f};
    puff.seed = seed;
    return puff;
}

double difference(const Image& a, const Image& b, int x, int y) {
    return std::abs(brightness(a, x, y) - brightness(b, x, y));
}

TEST_F(Render, dust_is_seen_before_what_is_behind_it_and_nowhere_else) {
    View view = front_view();
    view.items = {item_of(renderer_->add_mesh(box_mesh({3, 3, 0.1}, {0.02f, 0.02f, 0.02f})), {})};
    view.items[0].pose.position = {0, 0, -3};
    const Image bare = draw(view);
    for (uint32_t seed = 0; seed < 60; ++seed) view.dust.push_back(puff(seed));
    const Image dusty = draw(view);
    EXPECT_GT(difference(dusty, bare, 160, 100), 20);
    EXPECT_GT(brightness(dusty, 160, 100), brightness(bare, 160, 100));
    // No cloud gets wider than 7 voxels nor begins further off than one: 64 pixels to the sides.
    for (int y = 0; y < 200; ++y) {
        for (const int x : {5, 40, 90, 230, 280, 315}) EXPECT_EQ(difference(dusty, bare, x, y), 0);
    }
    EXPECT_EQ(draw(view).rgba, dusty.rgba);
    view.time_s = 0.2;
    EXPECT_NE(draw(view).rgba, dusty.rgba);
    view.time_s = 0;

    // Not in depths and labels.
    const Result<Buffers> with = renderer_->buffers(view);
    View without_dust = view;
    without_dust.dust.clear();
    const Result<Buffers> without = renderer_->buffers(without_dust);
    ASSERT_TRUE(with && without);
    EXPECT_EQ(with->depths_m, without->depths_m);
    EXPECT_EQ(with->labels, without->labels);

    // A wall before it hides it.
    view.items[0].pose.position = {0, 0, 2};
    View walled = view;
    walled.dust.clear();
    EXPECT_EQ(draw(view).rgba, draw(walled).rgba);

    // It does not come through the walls of a box, though its clouds are wider.
    view.items[0] = item_of(renderer_->add_mesh(box_mesh({0.5, 0.5, 0.5}, {0.5f, 0.5f, 0.5f})), {});
    walled.items = view.items;
    EXPECT_EQ(draw(view).rgba, draw(walled).rgba);
}

TEST_F(Render, dust_is_no_narrower_in_an_upright_picture) {
    View view = front_view();
    view.items = {item_of(renderer_->add_mesh(box_mesh({3, 3, 0.1}, {0.02f, 0.02f, 0.02f})), {})};
    view.items[0].pose.position = {0, 0, -3};
    for (uint32_t seed = 0; seed < 60; ++seed) view.dust.push_back(puff(seed));
    const Image wide = draw(view);
    view.width = 100;  // of the same height: the middle of the picture before
    const Image upright = draw(view);
    double most = 0;
    for (int y = 60; y < 140; ++y) {
        for (int x = 2; x < 98; ++x) {
            most =
                std::max(most, std::abs(brightness(upright, x, y) - brightness(wide, 110 + x, y)));
        }
    }
    EXPECT_LT(most, 4);  // roundings
}

TEST_F(Render, dust_far_outside_the_picture_and_behind_the_eye_is_left_out) {
    View view = front_view();
    view.items = {item_of(renderer_->add_mesh(sphere_mesh(1, {0.2f, 0.2f, 0.2f})), {})};
    const Image bare = draw(view);
    for (const Vec3 center : {Vec3{50, 0, 0}, Vec3{0, -80, 0}, Vec3{0, 0, 30}}) {
        view.dust.push_back(puff(3));
        view.dust.back().center = center;
    }
    EXPECT_EQ(draw(view).rgba, bare.rgba);
}

}  // namespace
}  // namespace bsoil::render::dust_test
