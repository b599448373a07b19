#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "bsoil/render/primitives.h"
#include "bsoil/render/renderer.h"
#include "voxel_tiles.h"

namespace bsoil::render {
namespace {

class Render : public ::testing::Test {
  protected:
    void SetUp() override {
        Result<std::unique_ptr<Renderer>> created = Renderer::create();
        if (!created) GTEST_SKIP() << created.error();
        renderer_ = std::move(*created);
    }

    Image draw(const View& view) {
        Result<Image> image = renderer_->render(view);
        EXPECT_TRUE(image) << image.error();
        return image ? *image : Image{};
    }

    std::unique_ptr<Renderer> renderer_;
};

double brightness(const Image& image, int x, int y) {
    const uint8_t* p = image.pixel(x, y);
    return (p[0] + p[1] + p[2]) / 3.0;
}

double mean_brightness(const Image& image, int x0, int y0, int x1, int y1) {
    double sum = 0;
    for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) sum += brightness(image, x, y);
    }
    return sum / ((x1 - x0) * (y1 - y0));
}

/// Looks along -z at the origin; 1 m is 80 pixels there.
View front_view() {
    View view;
    view.width = 320;
    view.height = 200;
    view.camera = {{0, 0, 10}, {}, {0, 1, 0}, 2 * std::atan(100.0 / 80 / 10)};
    view.to_sun = {1, 0.2, 0.5};
    return view;
}

TEST_F(Render, the_side_towards_the_sun_is_brighter) {
    View view = front_view();
    view.items = {{renderer_->add_mesh(sphere_mesh(1, {0.5f, 0.5f, 0.5f})), {}, 0, 0}};
    const Image image = draw(view);
    ASSERT_EQ(image.width, 320);
    ASSERT_EQ(image.height, 200);
    const double sun_side = mean_brightness(image, 195, 80, 225, 120);
    const double far_side = mean_brightness(image, 95, 80, 125, 120);
    EXPECT_GT(sun_side, 2 * far_side);
    EXPECT_GT(far_side, 5);  // the sky lights it
    EXPECT_EQ(image.pixel(0, 0)[3], 255);
    // Sky: bright, and bluer than red.
    EXPECT_GT(image.pixel(2, 2)[2], image.pixel(2, 2)[0]);
}

TEST_F(Render, rows_run_from_top_to_bottom) {
    View view = front_view();
    Pose above;
    above.position = {0, 0.8, 0};
    view.items = {{renderer_->add_mesh(sphere_mesh(0.2, {1, 0, 0})), above, 0, 0}};
    const Image image = draw(view);
    const uint8_t* upper = image.pixel(160, 100 - 64);
    const uint8_t* lower = image.pixel(160, 100 + 64);
    EXPECT_GT(upper[0], 2 * upper[2]);
    EXPECT_LT(lower[0], lower[2] + 20);
}

TEST_F(Render, bodies_cast_shadows) {
    View view = front_view();
    view.to_sun = {0, 1, 0.2};
    view.camera.eye = {0, 6, 8};
    const MeshId ground = renderer_->add_mesh(box_mesh({2, 0.1, 2}, {0.6f, 0.6f, 0.6f}));
    const MeshId ball = renderer_->add_mesh(sphere_mesh(0.4, {0.6f, 0.6f, 0.6f}));
    Pose high;
    high.position = {0, 1.5, 1.5};
    view.items = {{ground, {}, 0, 0}};
    const Image bare = draw(view);
    view.items.push_back({ball, high, 0, 0});
    const Image image = draw(view);
    // The shadow lies about 0.3 m towards -z of the ball, near z = 1.2; the ball hides less than
    // it.
    int darker = 0;
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 320; ++x)
            darker += brightness(image, x, y) < 0.7 * brightness(bare, x, y);
    }
    EXPECT_GT(darker, 500);
}

TEST_F(Render, soil_is_not_blank_and_equal_from_picture_to_picture) {
    test::VoxelTiles tiles(32, 32, 24);
    tiles.frame().voxel_m = 0.1;
    const double half = std::sqrt(0.5);
    tiles.frame().grid_to_world = {{-1.6, 0, 1.6}, {-half, 0, 0, half}};
    const auto pile = [](double x, double y) { return 14 - 0.6 * std::hypot(x - 16, y - 16); };
    tiles.fill_heights(pile);
    SurfaceMesher mesher(tiles);
    mesher.update();
    SurfaceItems soil(*renderer_, mesher, 0.01f);
    soil.update();
    View view = front_view();
    view.camera.eye = {0, 4, 6};
    view.camera.target = {0, 1, 0};
    view.floor_height_m = 0;
    soil.append_to(view.items);
    EXPECT_EQ(view.items.size(), 16u);
    const Image image = draw(view);
    const double sky = mean_brightness(image, 0, 0, 320, 5);
    int unlike_sky = 0;
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 320; ++x) unlike_sky += std::abs(brightness(image, x, y) - sky) > 20;
    }
    EXPECT_GT(unlike_sky, 320 * 200 / 10);
    EXPECT_EQ(draw(view).rgba, image.rgba);

    // A hole shows once it is uploaded.
    for (int z = 8; z < 24; ++z) tiles.volume(16, 16, z) = 0;
    tiles.touch(16, 16);
    mesher.update();
    soil.update();
    view.items.clear();
    soil.append_to(view.items);
    EXPECT_NE(draw(view).rgba, image.rgba);
}

TEST_F(Render, soil_in_a_grid_of_any_size_is_drawn) {
    // Sides one voxel wide, just short of two tiles, and two voxels into a tile, where the mesher
    // once read beyond its window.
    constexpr int kSizes[][3] = {{40, 10, 20}, {10, 18, 9}, {1, 26, 40}, {15, 1, 3}, {1, 1, 1}};
    for (const auto& [nx, ny, nz] : kSizes) {
        SCOPED_TRACE(std::to_string(nx) + " x " + std::to_string(ny) + " x " + std::to_string(nz));
        test::VoxelTiles tiles(nx, ny, nz);
        const double longest = std::max({nx, ny, nz});
        tiles.frame().voxel_m = 2 / longest;
        const double half = std::sqrt(0.5);
        tiles.frame().grid_to_world = {{-nx / longest, 0, ny / longest}, {-half, 0, 0, half}};
        tiles.fill_heights([top = nz](double, double) { return 0.7 * top; });
        SurfaceMesher mesher(tiles);
        mesher.update();
        SurfaceItems soil(*renderer_, mesher, 0.01f);
        soil.update();
        View view = front_view();
        view.camera.eye = {0, 4, 6};
        const Image empty = draw(view);
        soil.append_to(view.items);
        EXPECT_EQ(view.items.size(), static_cast<size_t>((nx + 7) / 8 * ((ny + 7) / 8)));
        EXPECT_NE(draw(view).rgba, empty.rgba);
    }
}

TEST_F(Render, removed_meshes_are_gone_and_their_ids_are_used_again) {
    View view = front_view();
    const Image empty = draw(view);
    const MeshId ball = renderer_->add_mesh(sphere_mesh(1, {1, 0, 0}));
    view.items = {{ball, {}, 0, 0}};
    EXPECT_NE(draw(view).rgba, empty.rgba);
    renderer_->remove_mesh(ball);
    EXPECT_EQ(draw(view).rgba, empty.rgba);
    EXPECT_EQ(renderer_->add_mesh(box_mesh({1, 1, 1}, {1, 0, 0})).value, ball.value);
}

TEST_F(Render, bad_views_are_refused_with_the_field_named) {
    View view = front_view();
    view.width = 0;
    EXPECT_NE(renderer_->render(view).error().find("View::width"), std::string::npos);
    view = front_view();
    view.camera.fov_rad = 40;  // degrees
    EXPECT_NE(renderer_->render(view).error().find("Camera::fov_rad"), std::string::npos);
    view = front_view();
    view.camera.up = {0, 0, 1};
    EXPECT_FALSE(renderer_->render(view));
    view = front_view();
    view.camera.eye.x = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(renderer_->render(view));
    view = front_view();
    view.to_sun = {};
    EXPECT_FALSE(renderer_->render(view));
    EXPECT_FALSE(Renderer::create({.sample_count = 99}));
}

TEST_F(Render, the_callers_context_is_current_again) {
    // Without a context before, none is left behind.
    ASSERT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
    View view = front_view();
    view.items = {{renderer_->add_mesh(sphere_mesh(1, {1, 1, 1})), {}, 0, 0}};
    draw(view);
    EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);

    const EGLDisplay display =
        eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) {
        GTEST_SKIP() << "no surfaceless EGL display for a caller's context";
    }
    const EGLint attributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                 EGL_OPENGL_ES2_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    ASSERT_TRUE(eglChooseConfig(display, attributes, &config, 1, &count) && count == 1);
    const EGLint size[] = {EGL_WIDTH, 4, EGL_HEIGHT, 4, EGL_NONE};
    const EGLSurface surface = eglCreatePbufferSurface(display, config, size);
    ASSERT_NE(surface, EGL_NO_SURFACE);
    ASSERT_TRUE(eglBindAPI(EGL_OPENGL_ES_API));
    const EGLint version[] = {EGL_CONTEXT_CLIENT_VERSION, 2, EGL_NONE};
    const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, version);
    ASSERT_NE(context, EGL_NO_CONTEXT);
    ASSERT_TRUE(eglMakeCurrent(display, surface, surface, context));
    draw(view);
    renderer_->remove_mesh(view.items[0].mesh);
    EXPECT_TRUE(Renderer::create());
    renderer_.reset();
    EXPECT_EQ(eglGetCurrentContext(), context);
    EXPECT_EQ(eglGetCurrentSurface(EGL_DRAW), surface);
    EXPECT_EQ(eglQueryAPI(), static_cast<EGLenum>(EGL_OPENGL_ES_API));
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglBindAPI(EGL_OPENGL_API);
    eglDestroyContext(display, context);
    eglDestroySurface(display, surface);
}

}  // namespace
}  // namespace bsoil::render
