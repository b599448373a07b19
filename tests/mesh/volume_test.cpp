/// Volumes that rays march through.
#include <algorithm>
#include <cmath>

#include "render_fixture.h"
#include "voxel_tiles.h"

namespace bsoil::render::volume_test {
namespace {

/// Voxels that are all one dark red, and hide by what `hides` says of them, 0..1.
VolumeData red_voxels(int nx, int ny, int nz, const std::function<double(int, int, int)>& hides) {
    VolumeData data{{nx, ny, nz}, {}};
    for (int z = 0; z < nz; ++z) {
        for (int y = 0; y < ny; ++y) {
            for (int x = 0; x < nx; ++x) {
                data.rgba.insert(data.rgba.end(), {150, 0, 0});
                data.rgba.push_back(static_cast<uint8_t>(std::lround(255 * hides(x, y, z))));
            }
        }
    }
    return data;
}

/// A cube of voxels of 0.1 m about the origin, as many along each side.
Volume centred(VolumeId id, int side) {
    Volume volume;
    volume.volume = id;
    volume.voxel_m = 0.1;
    volume.pose.position = Vec3{-0.05, -0.05, -0.05} * side;
    return volume;
}

bool is_red(const Image& image, int x, int y) {
    const uint8_t* p = image.pixel(x, y);
    return p[0] > 2 * p[1];
}

TEST_F(Render, the_outline_of_a_volume_is_that_of_its_mesh) {
    // A ball of soil of 0.8 m. Its grid is turned, as no one's axes are a picture's.
    constexpr int kSide = 24;
    test::VoxelTiles tiles(kSide, kSide, kSide);
    tiles.fill_shape(
        [](double x, double y, double z) { return std::hypot(x - 12, y - 12, z - 12) < 8; });
    GridFrame& frame = tiles.frame();
    frame.voxel_m = 0.1;
    frame.grid_to_world.rotation = {0.1, 0.3, 0.5, std::sqrt(1 - 0.35)};
    frame.grid_to_world.position = rotate(frame.grid_to_world.rotation, {-1.2, -1.2, -1.2});
    SurfaceMesher mesher(tiles);
    mesher.update();
    Mesh mesh;
    mesher.gather(mesh);
    View view = front_view();
    Item item = item_of(renderer_->add_mesh(mesh), {});
    item.label = 1;
    view.items = {item};
    const Result<Buffers> seen = renderer_->buffers(view);
    ASSERT_TRUE(seen) << seen.error();

    const auto id = renderer_->add_volume(red_voxels(kSide, kSide, kSide, [&](int x, int y, int z) {
        return static_cast<double>(tiles.volume(x, y, z));
    }));
    ASSERT_TRUE(id) << id.error();
    view.items.clear();
    view.volumes = {{*id, frame.grid_to_world, frame.voxel_m, 0.3 * frame.voxel_m, 0.5, true}};
    const Image image = draw(view);
    const auto is_soil = [&](int x, int y) {
        x = std::clamp(x, 0, 319), y = std::clamp(y, 0, 199);
        return seen->labels[static_cast<size_t>(y * 320 + x)] == 1;
    };
    // A voxel is 8 pixels wide there: so near to the mesh's outline they may differ, and nowhere
    // else.
    constexpr int kVoxelPixels = 8;
    int differing = 0, far = 0, soil = 0;
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 320; ++x) {
            soil += is_soil(x, y);
            if (is_soil(x, y) == is_red(image, x, y)) continue;
            ++differing;
            bool near = false;
            for (int j = -kVoxelPixels; j <= kVoxelPixels && !near; ++j) {
                for (int i = -kVoxelPixels; i <= kVoxelPixels && !near; ++i) {
                    near = i * i + j * j <= kVoxelPixels * kVoxelPixels &&
                           is_soil(x + i, y + j) != is_soil(x, y);
                }
            }
            far += !near;
        }
    }
    EXPECT_NEAR(soil, 3.14 * 64 * 64, 0.03 * 3.14 * 64 * 64);  // 0.8 m are 64 pixels
    EXPECT_EQ(far, 0);
    EXPECT_LT(differing, 2 * 3.14 * 64 * kVoxelPixels / 4) << "a quarter of it all around";
}

TEST_F(Render, a_volume_is_hidden_by_what_is_nearer_and_hides_what_is_farther) {
    const auto id = renderer_->add_volume(red_voxels(10, 10, 10, [](int, int, int) { return 1; }));
    ASSERT_TRUE(id) << id.error();
    View view = front_view();
    const MeshId box = renderer_->add_mesh(box_mesh({0.25, 0.25, 0.1}, {0.1f, 0.6f, 0.1f}));
    const auto with_box_at = [&](double z, bool with_volume) {
        Pose pose;
        pose.position = {0, 0, z};
        view.items = {item_of(box, pose)};
        view.volumes.clear();
        if (with_volume) view.volumes = {centred(*id, 10)};
        if (with_volume) view.volumes[0].sight_m = 0.02;
        return draw(view);
    };
    // Before the volume: the box is as it is without one, and the volume is beside it.
    const Image before = with_box_at(0.8, true), alone = with_box_at(0.8, false);
    for (int y = 90; y < 110; ++y) {
        for (int x = 150; x < 170; ++x) {
            for (int c = 0; c < 3; ++c) {
                ASSERT_EQ(before.pixel(x, y)[c], alone.pixel(x, y)[c]) << x << ", " << y;
            }
        }
    }
    EXPECT_TRUE(is_red(before, 160 + 32, 100));
    // Behind it, and inside of it: nothing of it is seen.
    EXPECT_TRUE(is_red(with_box_at(-0.8, true), 160, 100));
    EXPECT_TRUE(is_red(with_box_at(0, true), 160, 100));
    // Half way out of its front face: the box, and only there.
    const Image half_out = with_box_at(0.45, true);
    EXPECT_FALSE(is_red(half_out, 160, 100));
    EXPECT_TRUE(is_red(half_out, 160 + 30, 100));
    EXPECT_FALSE(is_red(half_out, 160 + 60, 100));
}

TEST_F(Render, what_comes_through_a_volume_falls_with_its_depth_whatever_the_steps) {
    // Light through d of what hides by 1 / s per metre: exp(-d / s). Far away a pixel is wider than
    // a voxel, and steps are longer.
    const auto id = renderer_->add_volume(red_voxels(10, 10, 10, [](int, int, int) { return 1; }));
    ASSERT_TRUE(id) << id.error();
    const Mesh white = box_mesh({4, 4, 0.1}, {1, 1, 1});
    for (const double away : {5.0, 10.0, 60.0}) {
        for (const double sight : {0.5, 1.0, 4.0}) {
            View view = front_view();
            view.camera.eye = {0, 0, away};
            Item wall = item_of(renderer_->add_mesh(white), {});
            wall.pose.position = {0, 0, -2};
            wall.emission = 1;
            view.items = {wall};
            view.volumes = {centred(*id, 10)};
            view.volumes[0].sight_m = sight;
            view.volumes[0].is_shaded = false;
            const Image image = draw(view);
            const double left = std::exp(-1.0 / sight);
            // Blue is the wall's alone. Mixed are the numbers of the screen.
            EXPECT_NEAR(image.pixel(160, 100)[2] / 255.0, left, 0.02)
                << away << " m away, sight " << sight;
        }
    }
}

TEST_F(Render, empty_voxels_hide_nothing_and_removed_volumes_are_gone) {
    View view = front_view();
    view.items = {item_of(renderer_->add_mesh(sphere_mesh(0.5, {0, 1, 0})), {})};
    const Image without = draw(view);
    const auto id = renderer_->add_volume(red_voxels(20, 20, 20, [](int, int, int) { return 0; }));
    ASSERT_TRUE(id) << id.error();
    const auto differing = [&](const Image& image) {
        int count = 0;
        for (size_t i = 0; i < image.rgba.size(); ++i) {
            count += std::abs(image.rgba[i] - without.rgba[i]) > 8;
        }
        return count;
    };
    view.volumes = {centred(*id, 20)};
    // The sun's map covers the volume's box too: shadows' edges may differ by its texels.
    EXPECT_LT(differing(draw(view)), 100);
    // One voxel amid empty ones is found by the rays that meet it.
    ASSERT_TRUE(renderer_->set_volume(*id, red_voxels(20, 20, 20, [](int x, int y, int z) {
        return x == 9 && y == 18 && z == 3;
    })));
    view.volumes[0].sight_m = 0.01;
    const Image one = draw(view);
    int red = 0;
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 320; ++x) red += is_red(one, x, y);
    }
    EXPECT_GT(red, 30);  // 8 x 8 pixels
    EXPECT_LT(red, 250);
    renderer_->remove_volume(*id);
    EXPECT_LT(differing(draw(view)), 100);
    EXPECT_FALSE(renderer_->set_volume({99}, VolumeData{}));
    EXPECT_NE(renderer_->add_volume(VolumeData{{4, 4, 4000}, {}}).error().find("VolumeData::size"),
              std::string::npos);
    EXPECT_NE(renderer_->add_volume(VolumeData{{4, 4, 4}, {1, 2}}).error().find("VolumeData::rgba"),
              std::string::npos);
    view.volumes[0].sight_m = 0;
    EXPECT_NE(renderer_->render(view).error().find("Volume::sight_m"), std::string::npos);
    view.volumes[0].sight_m = 0.01;
    view.volumes[0].pose.rotation.y = NAN;  // rays went nowhere
    const Result<Image> turned = renderer_->render(view);
    ASSERT_FALSE(turned);
    EXPECT_NE(turned.error().find("Volume::pose"), std::string::npos);
}

}  // namespace
}  // namespace bsoil::render::volume_test
