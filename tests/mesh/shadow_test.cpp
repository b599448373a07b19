/// Shadows near and far.
#include <algorithm>
#include <cmath>

#include "render_fixture.h"
#include "shadow_cascades.h"

namespace bsoil::render::shadow_test {
namespace {

/// Ground of 2 km, seen from 10 m before the target and 300 m above it.
struct Plain {
    View view;
    MeshId box;

    explicit Plain(Renderer& renderer) {
        view = front_view();
        view.camera.eye = {0, 30, 60};
        view.camera.target = {0, 26, 50};
        view.camera.fov_rad = 1.2;
        view.to_sun = {1, 1, 0};
        const MeshId ground = renderer.add_mesh(box_mesh({1000, 0.1, 1000}, {0.6f, 0.6f, 0.6f}));
        box = renderer.add_mesh(box_mesh({1, 1, 1}, {0.6f, 0.6f, 0.6f}));
        view.items = {item_of(ground, {})};
    }
};

/// Pixels that another one is darker in by a third.
int darker_count(const Image& a, const Image& b) {
    int count = 0;
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            count += brightness(b, x, y) < 0.67 * brightness(a, x, y);
        }
    }
    return count;
}

TEST(ShadowCascades, the_sun_may_stand_along_any_upright) {
    const double third = std::sqrt(1.0 / 3);
    for (const glm::dvec3& up : {glm::dvec3(0, 1, 0), glm::dvec3(third), glm::dvec3(-third)}) {
        for (const ShadowCascade& cascade :
             make_cascades({glm::dvec3(0), glm::dvec3(0), up, up, 1, 1}, 256, kCascadesMost)) {
            for (int column = 0; column < 4; ++column) {
                for (int row = 0; row < 4; ++row) {
                    EXPECT_TRUE(std::isfinite(cascade.clip[column][row]));
                }
            }
        }
    }
}

TEST_F(Render, what_is_far_from_the_cameras_target_casts_shadows) {
    Plain plain(*renderer_);
    const Image bare = draw(plain.view);
    Pose far;
    far.position = {-20, 10, -90};  // 140 m beyond the target, 13 times as far as it is
    Item box = item_of(plain.box, far);
    // As high as a house, and 10 m wide.
    const MeshId house = renderer_->add_mesh(box_mesh({5, 10, 5}, {0.6f, 0.6f, 0.6f}));
    box.mesh = house;
    plain.view.items.push_back(box);
    const Image image = draw(plain.view);
    const int with_shadow = darker_count(bare, image);
    // A sun from behind the eye: the house hides its own shadow.
    plain.view.to_sun = {0.3, 1, 1.5};
    const Image other_bare = [&] {
        View without = plain.view;
        without.items.pop_back();
        return draw(without);
    }();
    const int without_shadow = darker_count(other_bare, draw(plain.view));
    // The shadow lies 20 m to the left, as large as the house: some 15 x 6 pixels.
    EXPECT_GT(with_shadow, without_shadow + 60);
}

TEST(Shadows, maps_reach_from_the_target_to_the_scenes_end) {
    ShadowScene scene;
    scene.sight_m = 10;
    scene.radius = 15;
    EXPECT_EQ(cascade_radii(scene, 3), (std::vector<double>{15}));
    scene.radius = 100;
    EXPECT_EQ(cascade_radii(scene, 3), (std::vector<double>{20, 100}));
    scene.radius = 2000;
    EXPECT_EQ(cascade_radii(scene, 3), (std::vector<double>{20, 200, 2000}));
    EXPECT_EQ(cascade_radii(scene, 2), (std::vector<double>{20, 2000}));
    EXPECT_EQ(cascade_radii(scene, 1), (std::vector<double>{20}));
}

TEST(Shadows, each_map_has_what_lies_within_its_reach) {
    ShadowScene scene;
    scene.target = {0, 0, -10};
    scene.center = {30, 0, -40};
    scene.sight_m = 10;
    scene.radius = 500;
    scene.to_sun = glm::normalize(glm::dvec3(1, 2, 1));
    scene.up = {0, 1, 0};
    const std::vector<ShadowCascade> cascades = make_cascades(scene, 1024, 3);
    ASSERT_EQ(cascades.size(), 3u);
    const auto is_within = [&](size_t map, glm::vec3 at) {
        const glm::vec4 clip = cascades[map].clip * glm::vec4(at, 1);
        return std::max({std::abs(clip.x), std::abs(clip.y), std::abs(clip.z)}) <= 1;
    };
    EXPECT_TRUE(is_within(0, {15, 0, -10}));
    EXPECT_FALSE(is_within(0, {-45, 0, 30}));
    EXPECT_TRUE(is_within(1, {-45, 0, 30}));
    EXPECT_FALSE(is_within(1, {300, 0, -300}));
    EXPECT_TRUE(is_within(2, {300, 0, -300}));
    EXPECT_NEAR(cascades[0].texel_m, 40.0 / 1024, 1e-9);
}

TEST_F(Render, shadows_near_the_target_do_not_change_with_the_size_of_the_scene) {
    Plain plain(*renderer_);
    Pose near;
    near.position = {0, 1.1, 42};
    plain.view.camera.eye = {0, 12, 60};
    plain.view.camera.target = {0, 0, 42};
    const Image bare = draw(plain.view);
    plain.view.items.push_back(item_of(plain.box, near));
    const int in_large = darker_count(bare, draw(plain.view));
    // Without a far item the scene is the box and a small ground.
    const MeshId small = renderer_->add_mesh(box_mesh({20, 0.1, 20}, {0.6f, 0.6f, 0.6f}));
    Pose here;
    here.position = {0, 0, 42};
    plain.view.items[0] = item_of(small, here);
    const int in_small = darker_count(bare, draw(plain.view));
    EXPECT_GT(in_large, 40);
    EXPECT_NEAR(in_large, in_small, 0.3 * in_small);
}

}  // namespace
}  // namespace bsoil::render::shadow_test
