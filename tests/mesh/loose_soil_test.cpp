/// Soil that rolls, in pictures.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "render_fixture.h"
#include "voxel_tiles.h"

namespace bsoil::render::loose_soil_test {
namespace {

/// A slope towards the eye, of which a strip may roll.
struct Slope {
    test::VoxelTiles tiles{32, 32, 32};
    SurfaceMesher mesher{tiles};

    Slope() {
        tiles.frame().voxel_m = 0.1;
        const double half = std::sqrt(0.5);
        tiles.frame().grid_to_world = {{-1.6, -1.2, 1.6}, {-half, 0, 0, half}};  // y is up
        tiles.fill_heights([](double, double y) { return 4 + 0.5 * y; });
        for (MaterialDef& material : tiles.materials()) material.friction_angle_rad = 0.3;
    }
    void roll(double slip_m_s) {
        tiles.set_motion([slip_m_s](int x, int y) {
            return GroundMotion{x >= 12 && x < 20 && y >= 4 && y < 28 ? slip_m_s : 0.0, {}};
        });
        for (int y = 0; y < 32; y += 8) {
            for (int x = 0; x < 32; x += 8) tiles.touch(x, y);
        }
        mesher.update();
    }
};

/// Pixels that differ by more than 6 grey levels within columns x0..x1.
int changed_count(const Image& a, const Image& b, int x0, int x1) {
    int changed = 0;
    for (int y = 0; y < a.height; ++y) {
        for (int x = x0; x < x1; ++x) {
            changed += std::abs(brightness(a, x, y) - brightness(b, x, y)) > 6;
        }
    }
    return changed;
}

TEST_F(Render, soil_that_rolls_is_seen_as_grains_where_it_does) {
    Slope slope;
    SurfaceItems items(*renderer_, slope.mesher, 0);
    View view = front_view();
    view.camera.eye = {0, 4, 9};
    const auto draw_slope = [&] {
        items.update();
        view.items.clear();
        view.grains.clear();
        items.append_to(view.items);
        append_grains(slope.mesher, view.grains);
        return draw(view);
    };
    slope.roll(0);
    const Image still = draw_slope();
    EXPECT_TRUE(view.grains.empty());
    slope.roll(1);
    const Image rolling = draw_slope();
    EXPECT_EQ(view.grains.size(), 8u * 24u);
    // The strip is 0.8 m of 3.2 m wide: 64 pixels, a little more where it is near. Grains hide a
    // third of it and lie beside where the surface was dark or bright; outside nothing changes.
    const int inside = changed_count(still, rolling, 120, 200);
    EXPECT_GT(inside, 64 * 100 / 5);
    EXPECT_EQ(changed_count(still, rolling, 0, 110), 0);
    EXPECT_EQ(changed_count(still, rolling, 210, 320), 0);
    EXPECT_EQ(draw(view).rgba, rolling.rgba);

    // They travel down the slope, and are fewer where soil rolls slowly.
    view.time_s = 0.03;
    EXPECT_GT(changed_count(rolling, draw(view), 120, 200), inside / 4);
    view.time_s = 0;
    slope.roll(0.2);
    const int slow = changed_count(still, draw_slope(), 120, 200);
    EXPECT_LT(slow, inside / 2);
    EXPECT_GT(slow, inside / 20);
    slope.roll(0);
    EXPECT_EQ(draw_slope().rgba, still.rgba);
}

TEST_F(Render, rolling_grains_lie_flat_on_their_slope) {
    View view = front_view();
    GrainGroup group;
    group.side_m = 1;
    group.grain_m = 0.02f;
    group.normal = {0, 1, 0};
    group.flatness = 0.75f;
    view.grains = {group};
    view.grain_label = 1;
    const auto rows = [&] {
        const Result<Buffers> buffers = renderer_->buffers(view);
        EXPECT_TRUE(buffers) << buffers.error();
        int low = 200, high = 0;
        for (int y = 0; y < 200; ++y) {
            for (int x = 0; x < 320; ++x) {
                if (buffers->labels[static_cast<size_t>(y * 320 + x)] == 0) continue;
                low = std::min(low, y);
                high = std::max(high, y);
            }
        }
        return high - low + 1;
    };
    // A quarter of 80 pixels, and a grain of 1.6 pixels, give or take a pixel.
    EXPECT_NEAR(rows(), 20, 3);
    view.grains[0].flatness = 0;
    EXPECT_NEAR(rows(), 80, 4);
    view.grains[0].flatness = 0.75f;
    view.grains[0].normal = {1, 0, 0};
    EXPECT_NEAR(rows(), 80, 4);
}

TEST_F(Render, rolling_grains_behind_their_slope_are_left_out) {
    View view = front_view();
    GrainGroup group;
    group.side_m = 1;
    group.grain_m = 0.04f;
    group.flatness = 0.75f;
    view.grain_label = 1;
    const auto seen = [&](Vec3 normal) {
        group.normal = normal;
        view.grains = {group};
        const Result<Buffers> buffers = renderer_->buffers(view);
        EXPECT_TRUE(buffers) << buffers.error();
        return std::count(buffers->labels.begin(), buffers->labels.end(), 1u);
    };
    EXPECT_GT(seen({0, 0, 1}), 300);
    EXPECT_GT(seen({1, 0, 0}), 100);  // seen from its edge
    EXPECT_EQ(seen({0, 0, -1}), 0);
    // In part outside of the picture, which is 4 m wide.
    group.center = {2.2, 0, 0};
    EXPECT_GT(seen({0, 0, 1}), 100);
    group.center = {0, 1.6, 0};
    EXPECT_GT(seen({0, 0, 1}), 50);
}

TEST_F(Render, grains_too_far_to_be_told_apart_hide_as_much_as_they_did) {
    View view = front_view();
    for (uint32_t seed = 0; seed < 40; ++seed) {
        GrainGroup group;
        group.side_m = 2;
        group.grain_m = 0.04f;
        group.seed = seed;
        view.grains.push_back(group);
    }
    view.grain_label = 1;
    const auto hidden_share = [&](double away_m) {
        view.camera.eye = {0, 0, away_m};
        const Result<Buffers> buffers = renderer_->buffers(view);
        EXPECT_TRUE(buffers) << buffers.error();
        const double side = 160 * 10 / away_m;
        return static_cast<double>(std::count(buffers->labels.begin(), buffers->labels.end(), 1u)) /
               (side * side);
    };
    // A grain has 3.2 pixels, 0.6 and 0.32. A tenth is a standard deviation of the last: 640
    // pixels.
    const double near = hidden_share(10);
    EXPECT_GT(near, 0.2);
    EXPECT_LT(near, 0.8);
    EXPECT_NEAR(hidden_share(53), near, 0.1 * near);
    EXPECT_NEAR(hidden_share(100), near, 0.2 * near);
}

}  // namespace
}  // namespace bsoil::render::loose_soil_test
