#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "render_fixture.h"
#include "voxel_tiles.h"

namespace bsoil::render::render_test {
namespace {

TEST_F(Render, the_side_towards_the_sun_is_brighter) {
    View view = front_view();
    view.items = {item_of(renderer_->add_mesh(sphere_mesh(1, {0.5f, 0.5f, 0.5f})), {})};
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
    view.items = {item_of(renderer_->add_mesh(sphere_mesh(0.2, {1, 0, 0})), above)};
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
    view.items = {item_of(ground, {})};
    const Image bare = draw(view);
    view.items.push_back(item_of(ball, high));
    const Image image = draw(view);
    // The shadow lies about 0.3 m towards -z of the ball, near z = 1.2; the ball hides less than
    // it.
    int darker = 0;
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 320; ++x) {
            darker += brightness(image, x, y) < 0.7 * brightness(bare, x, y);
        }
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
    EXPECT_EQ(view.items.size(), 1u);  // 4 x 4 tiles are one patch
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

TEST_F(Render, thin_soil_in_the_air_is_seen_as_grains) {
    test::VoxelTiles tiles(32, 32, 40);
    tiles.frame().voxel_m = 0.1;
    const double half = std::sqrt(0.5);
    tiles.frame().grid_to_world = {{-1.6, -2, 1.6}, {-half, 0, 0, half}};
    tiles.fill_heights([](double, double) { return 6; });
    SurfaceMesher mesher(tiles);
    View view = front_view();
    SurfaceItems soil(*renderer_, mesher, 0);
    const auto draw_grains = [&] {
        mesher.update();
        soil.update();
        view.items.clear();
        view.grains.clear();
        soil.append_to(view.items);
        append_grains(mesher, view.grains);
        return draw(view);
    };
    const Image bare = draw_grains();
    EXPECT_TRUE(view.grains.empty());
    // A stream, a fifth of it soil, falls in front of the sky.
    for (int z = 15; z < 40; ++z) {
        for (int y = 14; y < 18; ++y) {
            for (int x = 14; x < 18; ++x) tiles.volume(x, y, z) = 0.2f;
        }
    }
    tiles.touch(14, 14), tiles.touch(16, 14), tiles.touch(14, 16), tiles.touch(16, 16);
    const Image stream = draw_grains();
    // 0.4 m x 2 m of the picture, of which grains hide at least a fifth.
    int changed = 0;
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 320; ++x) {
            changed += std::abs(brightness(stream, x, y) - brightness(bare, x, y)) > 10;
        }
    }
    EXPECT_GT(changed, 32 * 160 / 5);
    EXPECT_EQ(draw(view).rgba, stream.rgba);

    // They travel as time goes on, and are on the label of all grains.
    for (GrainGroup& group : view.grains) group.velocity_m_s = {0, -2, 0};
    const Image falling = draw(view);
    view.time_s = 0.02;
    EXPECT_NE(draw(view).rgba, falling.rgba);
    view.grain_label = 7;
    const Result<Buffers> buffers = renderer_->buffers(view);
    ASSERT_TRUE(buffers) << buffers.error();
    EXPECT_GT(std::count(buffers->labels.begin(), buffers->labels.end(), 7u), 32 * 160 / 5);
}

TEST_F(Render, grains_are_as_many_as_the_soil_that_no_surface_shows) {
    test::VoxelTiles tiles(24, 24, 32);
    tiles.fill_heights([](double, double) { return 4.3; });
    double thin = 0;
    const auto put = [&](int x, int y, int z, float volume) {
        tiles.volume(x, y, z) = volume;
        thin += volume;
    };
    put(3, 4, 20, 0.4f);
    put(9, 9, 12, 0.03f);
    put(17, 20, 30, 0.25f);
    for (const int x : {12, 13}) {  // a lump, meshed together with what hangs on it
        tiles.volume(x, 12, 18) = 0.9f;
        tiles.volume(x, 12, 17) = 0.2f;
        tiles.volume(x, 12, 19) = 0.2f;
    }
    put(20, 4, 18, 1.0f);  // one voxel by itself
    SurfaceMesher mesher(tiles);
    mesher.update();
    std::vector<GrainGroup> grains;
    append_grains(mesher, grains);
    EXPECT_EQ(grains.size(), 8u);  // 1.6, 0.12, 1 and 4 groups
    double shares = 0;
    for (const GrainGroup& group : grains) shares += static_cast<double>(group.share);
    EXPECT_NEAR(shares, kVoxelGroups * thin, 1e-5);  // floats
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
        EXPECT_EQ(view.items.size(), static_cast<size_t>((nx + 31) / 32 * ((ny + 31) / 32)));
        EXPECT_NE(draw(view).rgba, empty.rgba);
    }
}

TEST_F(Render, soil_far_from_the_worlds_origin_is_drawn_as_near_it) {
    const auto drawn = [&](Vec3 place_m) {
        test::VoxelTiles tiles(16, 16, 16);
        const double half = std::sqrt(0.5);
        tiles.frame().voxel_m = 0.1;
        tiles.frame().grid_to_world = {place_m + Vec3{-0.8, 0, 0.8}, {-half, 0, 0, half}};
        tiles.fill_heights([](double x, double y) { return 9 - 0.7 * std::hypot(x - 8, y - 8); });
        SurfaceMeshDef def;
        def.origin_m = place_m;
        SurfaceMesher mesher(tiles, def);
        mesher.update();
        SurfaceItems soil(*renderer_, mesher, 0);
        soil.update();
        View view = front_view();
        view.camera.eye = place_m + Vec3{0, 3, 4};
        view.camera.target = place_m;
        soil.append_to(view.items);
        return draw(view);
    };
    const Image near = drawn({}), far = drawn({5e6, 0, 4e5});
    int other = 0;
    for (size_t i = 0; i < near.rgba.size(); ++i) other += std::abs(near.rgba[i] - far.rgba[i]) > 8;
    EXPECT_LT(other, 50);  // roundings at outlines
}

TEST_F(Render, a_cut_opens_what_is_cut_and_nothing_else) {
    View view = front_view();
    const MeshId ball = renderer_->add_mesh(sphere_mesh(1, {1, 0, 0}));
    Item inner = item_of(renderer_->add_mesh(sphere_mesh(0.3, {0, 1, 0})), {});
    inner.label = 2;
    Item outer = item_of(ball, {});
    outer.label = 1;
    outer.is_closed = true;
    view.items = {outer, inner};
    const size_t middle = 100 * 320 + 160;
    const auto label_in_the_middle = [&] {
        const Result<Buffers> buffers = renderer_->buffers(view);
        EXPECT_TRUE(buffers) << buffers.error();
        return buffers->labels[middle];
    };
    EXPECT_EQ(label_in_the_middle(), 1u);
    view.cut = Plane{{0, 0, 1}, 0};  // what lies towards the eye goes
    EXPECT_EQ(label_in_the_middle(), 1u);
    view.items[0].is_cut = true;
    EXPECT_EQ(label_in_the_middle(), 2u);
    const Image open = draw(view);
    EXPECT_GT(open.pixel(160, 100)[1], 2 * open.pixel(160, 100)[0]);
    view.cut->offset = 2;
    EXPECT_EQ(label_in_the_middle(), 1u);
    view.cut->offset = std::nan("");
    EXPECT_NE(renderer_->render(view).error().find("View::cut"), std::string::npos);
}

TEST_F(Render, closed_items_are_the_same_from_outside) {
    View view = front_view();
    view.items = {item_of(renderer_->add_mesh(sphere_mesh(1, {1, 0, 0})), {}),
                  item_of(renderer_->add_mesh(box_mesh({0.3, 0.3, 0.3}, {0, 1, 0})), {})};
    view.items[1].pose.position = {1.5, 0.3, 0.2};
    const Image image = draw(view);
    for (Item& item : view.items) item.is_closed = true;
    const Image closed = draw(view);
    // Shadows may differ where a back face was the nearer one in the map, by its bias.
    int other = 0;
    for (size_t i = 0; i < image.rgba.size(); ++i) {
        other += std::abs(image.rgba[i] - closed.rgba[i]) > 8;
    }
    EXPECT_LT(other, 200);
}

TEST_F(Render, removed_meshes_are_gone_and_their_ids_are_used_again) {
    View view = front_view();
    const Image empty = draw(view);
    const MeshId ball = renderer_->add_mesh(sphere_mesh(1, {1, 0, 0}));
    view.items = {item_of(ball, {})};
    EXPECT_NE(draw(view).rgba, empty.rgba);
    renderer_->remove_mesh(ball);
    EXPECT_EQ(draw(view).rgba, empty.rgba);
    EXPECT_EQ(renderer_->add_mesh(box_mesh({1, 1, 1}, {1, 0, 0})).value, ball.value);
}

TEST_F(Render, a_mesh_without_all_of_its_numbers_is_empty) {
    View view = front_view();
    const Image empty = draw(view);
    Mesh mesh = sphere_mesh(1, {1, 0, 0});
    mesh.colors.clear();
    view.items = {item_of(renderer_->add_mesh(mesh), {})};
    EXPECT_EQ(draw(view).rgba, empty.rgba);
    mesh = sphere_mesh(1, {1, 0, 0});
    mesh.indices[0] = 1'000'000;
    renderer_->set_mesh(view.items[0].mesh, mesh);
    EXPECT_EQ(draw(view).rgba, empty.rgba);
}

TEST_F(Render, a_shifted_camera_sees_its_target_beside_the_middle) {
    View view = front_view();
    Item ball = item_of(renderer_->add_mesh(sphere_mesh(0.1, {1, 0, 0})), {});
    ball.label = 3;
    view.items = {ball};
    view.camera.shift = 0.5;
    const Result<Buffers> buffers = renderer_->buffers(view);
    ASSERT_TRUE(buffers) << buffers.error();
    EXPECT_EQ(buffers->labels[100 * 320 + 240], 3u);
    EXPECT_EQ(buffers->labels[100 * 320 + 160], 0u);
    view.camera.shift = 2;
    EXPECT_NE(renderer_->buffers(view).error().find("Camera::shift"), std::string::npos);
}

TEST_F(Render, buffers_hold_depth_normal_and_label) {
    View view = front_view();
    view.floor_height_m = -1;
    Item ball = item_of(renderer_->add_mesh(sphere_mesh(0.8, {1, 0, 0})), {});
    ball.label = 7;
    Item box = item_of(renderer_->add_mesh(box_mesh({0.2, 0.2, 0.2}, {1, 0, 0})), {});
    box.pose.position = {1.4, 0, 0};
    box.label = 9;
    view.items = {ball, box};
    const Result<Buffers> buffers = renderer_->buffers(view);
    ASSERT_TRUE(buffers) << buffers.error();
    const auto at = [](int x, int y) { return static_cast<size_t>(y * 320 + x); };
    // The middle of the picture sees the sphere's front, 0.8 m before the target at 10 m; its
    // facets lie up to a hundredth of the radius inside of it.
    EXPECT_NEAR(buffers->depths_m[at(160, 100)], 9.2, 0.01);
    EXPECT_NEAR(buffers->normals[3 * at(160, 100) + 2], 1, 0.01);
    EXPECT_EQ(buffers->labels[at(160, 100)], 7u);
    // The box's front is 0.2 m before the target, whatever its place across.
    EXPECT_NEAR(buffers->depths_m[at(160 + 112, 100)], 9.8, 1e-3);
    EXPECT_EQ(buffers->labels[at(160 + 112, 100)], 9u);
    // The upper half of the sphere looks up, rows run from the top.
    EXPECT_GT(buffers->normals[3 * at(160, 60) + 1], 0.5f);
    EXPECT_EQ(buffers->labels[at(160, 2)], 0u);
    EXPECT_EQ(buffers->depths_m[at(160, 2)], 0);  // sky
    EXPECT_GT(buffers->depths_m[at(2, 198)], 0);  // floor
    EXPECT_EQ(buffers->labels[at(2, 198)], 0u);
}

TEST_F(Render, what_has_left_the_world_takes_nothing_else_out_of_the_picture) {
    View view = front_view();
    const MeshId ball = renderer_->add_mesh(sphere_mesh(1, {1, 0, 0}));
    for (const double y : {0.0, -2e4, std::numeric_limits<double>::infinity()}) {
        view.items.push_back(item_of(ball, {}));
        view.items.back().pose.position.y = y;
        view.items.back().label = static_cast<uint32_t>(view.items.size());
        const Result<Buffers> buffers = renderer_->buffers(view);
        ASSERT_TRUE(buffers) << buffers.error();
        EXPECT_EQ(buffers->labels[100 * 320 + 160], 1u) << y;
        EXPECT_NEAR(buffers->depths_m[100 * 320 + 160], 9, 0.02) << y;  // facets
    }
}

TEST_F(Render, lines_are_hidden_by_what_is_nearer_unless_they_are_in_front) {
    View view = front_view();
    view.line_width = 4;
    view.items = {item_of(renderer_->add_mesh(box_mesh({0.5, 0.5, 0.5}, {0.2f, 0.2f, 0.2f})), {})};
    const Line behind{{-1.5, 0, -1}, {1.5, 0, -1}, {1, 0, 0}};
    view.lines = {behind};
    const auto is_red = [](const Image& image, int x, int y) {
        const uint8_t* p = image.pixel(x, y);
        return p[0] > 200 && p[1] < 60;
    };
    const Image hidden = draw(view);
    EXPECT_TRUE(is_red(hidden, 60, 100));
    EXPECT_FALSE(is_red(hidden, 160, 100));
    view.front_lines = {behind};
    EXPECT_TRUE(is_red(draw(view), 160, 100));
    // A line that ends behind the eye is seen as far as it is before it.
    view.lines = {{{0, 0.8, 0}, {0, 0.8, 30}, {1, 0, 0}}};
    view.front_lines.clear();
    EXPECT_TRUE(is_red(draw(view), 160, 100 - 66));
    // One far beyond all items, 110 m from the eye, where 1 m is 7.3 pixels.
    view.lines = {{{-10, 10, -100}, {10, 10, -100}, {1, 0, 0}},
                  {{-10, 0, -100}, {10, 0, -100}, {1, 0, 0}}};
    const Image far = draw(view);
    EXPECT_TRUE(is_red(far, 160, 100 - 73));
    EXPECT_TRUE(is_red(far, 160 + 60, 100));
    EXPECT_FALSE(is_red(far, 160, 100));
    view.line_width = 0;
    EXPECT_NE(renderer_->render(view).error().find("View::line_width"), std::string::npos);
}

TEST_F(Render, an_item_that_emits_shows_its_own_colour) {
    View view = front_view();
    Item box = item_of(renderer_->add_mesh(box_mesh({1, 1, 1}, {0.5f, 0.25f, 1.0f})), {});
    box.emission = 1;
    view.items = {box};
    view.to_sun = {0, 0, -1};  // its front is in shadow
    const Image image = draw(view);
    const uint8_t* p = image.pixel(160, 100);
    // 255 c^(1/2.2), to a grey level of rounding.
    EXPECT_NEAR(p[0], 186, 1);
    EXPECT_NEAR(p[1], 136, 1);
    EXPECT_NEAR(p[2], 255, 1);
}

TEST_F(Render, the_time_of_each_pass_is_measured) {
    View view = front_view();
    view.items = {item_of(renderer_->add_mesh(sphere_mesh(1, {1, 1, 1})), {})};
    draw(view);
    const PassTimes times = renderer_->pass_times();
    EXPECT_GT(times.sum(), 0);
    EXPECT_GE(times.sum(), times.surface);
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
    view = front_view();
    view.time_s = std::numeric_limits<double>::infinity();
    EXPECT_NE(renderer_->render(view).error().find("View::time_s"), std::string::npos);
    view = front_view();
    view.floor_height_m = std::nan("");
    EXPECT_NE(renderer_->render(view).error().find("View::floor_height_m"), std::string::npos);
    view = front_view();
    view.grains.resize(2);  // shares out of their range are held to it
    view.grains[0].share = std::numeric_limits<float>::infinity();
    view.grains[1].share = std::numeric_limits<float>::quiet_NaN();
    EXPECT_TRUE(renderer_->render(view));
    EXPECT_FALSE(Renderer::create({.sample_count = 99}));
}

}  // namespace
}  // namespace bsoil::render::render_test
