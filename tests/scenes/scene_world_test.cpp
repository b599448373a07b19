/// Scenes as Bullet worlds, without soil: bodies, joints, motors.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "reading/scene_load.h"
#include "robots/convex_hull.h"
#include "run/scene_run.h"
#include "scene/rotations.h"
#include "scene/terrain_noise.h"
#include "world/bullet_scene.h"
#include "world/soil_filling.h"

namespace bsoil::scene::scene_world_test {
namespace {

Scene parsed(const std::string& text) {
    auto scene = parse_scene(text, "s.toml");
    EXPECT_TRUE(scene) << scene.error();
    return scene ? *scene : Scene{};
}

std::unique_ptr<BulletScene> world_of(const Scene& scene) {
    auto world = BulletScene::create(scene);
    EXPECT_TRUE(world) << world.error();
    return world ? std::move(*world) : nullptr;
}

void run_to(BulletScene& world, double t_s) {
    while (world.time_s() < t_s - 1e-9) world.substep();
}

const std::string kNoGravity = "[world]\nduration_s = 9\ngravity_m_s2 = 0\nground_plane = false\n";
const std::string kArm =
    "[[body]]\nname = \"arm\"\nshape = \"box\"\nsize_m = [1, 0.1, 0.1]\nmass_kg = 10\nposition_m = "
    "[0.5, 0, 0]\n";

TEST(SceneWorld, hinge_turns_right_handed_and_follows_its_keys) {
    const Scene scene =
        parsed(kNoGravity + kArm +
               "[[joint]]\nname = \"j\"\nkind = \"hinge\"\nparent = \"world\"\nchild = \"arm\"\n"
               "point_m = [0, 0, 0]\naxis = [0, 0, 1]\nmotor_torque_n_m = 1000\n"
               "[[motion]]\njoint = \"j\"\nkey = [{ t_s = 0, position_deg = 0 }, "
               "{ t_s = 2, position_deg = 270 }]\n");
    const auto world = world_of(scene);
    run_to(*world, 1);
    EXPECT_NEAR(world->joints()[0].position / kDegree, 135, 0.5);
    run_to(*world, 3);
    EXPECT_NEAR(world->joints()[0].position / kDegree, 270, 0.1)
        << "turns are counted beyond half a turn";
    const Vec3 at = world->find_body("arm")->pose().position;
    EXPECT_NEAR(at.x, 0, 5e-3);
    EXPECT_NEAR(at.y, -0.5, 5e-3);
}

TEST(SceneWorld, a_lever_overrules_the_keys_until_it_is_let_go) {
    const Scene scene =
        parsed(kNoGravity + kArm +
               "[[joint]]\nname = \"j\"\nkind = \"hinge\"\nparent = \"world\"\nchild = \"arm\"\n"
               "point_m = [0, 0, 0]\naxis = [0, 0, 1]\nmotor_torque_n_m = 1000\n"
               "[[motion]]\njoint = \"j\"\nkey = [{ t_s = 0, velocity_deg_s = 10 }]\n");
    const auto world = world_of(scene);
    world->set_lever(0, -90 * kDegree);
    run_to(*world, 1);
    EXPECT_NEAR(world->joints()[0].position / kDegree, -90, 0.5);
    world->set_lever(0, {});
    run_to(*world, 2);
    EXPECT_NEAR(world->joints()[0].position / kDegree, -80, 0.5);
    world->set_lever(7, 1);  // no such joint
    // Without keys it holds where it was let go.
    const Scene bare =
        parsed(kNoGravity + kArm +
               "[[joint]]\nname = \"j\"\nkind = \"hinge\"\nparent = \"world\"\nchild = \"arm\"\n"
               "point_m = [0, 0, 0]\naxis = [0, 0, 1]\nmotor_torque_n_m = 1000\n");
    const auto held = world_of(bare);
    held->set_lever(0, 90 * kDegree);
    run_to(*held, 0.5);
    held->set_lever(0, {});
    run_to(*held, 1);
    EXPECT_NEAR(held->joints()[0].position / kDegree, 45, 1);
    EXPECT_TRUE(world->joints()[0].has_motor());
}

TEST(SceneWorld, hinge_stops_at_its_limit) {
    const Scene scene =
        parsed(kNoGravity + kArm +
               "[[joint]]\nname = \"j\"\nkind = \"hinge\"\nparent = \"world\"\nchild = \"arm\"\n"
               "point_m = [0, 0, 0]\naxis = [0, 0, 1]\nmotor_torque_n_m = 10\nlower_deg = "
               "-10\nupper_deg = 40\n"
               "[[motion]]\njoint = \"j\"\nkey = [{ t_s = 0, velocity_deg_s = 90 }]\n");
    const auto world = world_of(scene);
    run_to(*world, 2);
    EXPECT_NEAR(world->joints()[0].position / kDegree, 40, 1);
}

TEST(SceneWorld, weak_motor_does_not_lift_the_arm) {
    // the arm's weight pulls with 10 kg x 9.81 x 0.5 m = 49 N m about the hinge
    for (const double torque_n_m : {40.0, 60.0}) {
        const Scene scene = parsed(
            "[world]\nduration_s = 9\nground_plane = false\nsolver_iterations = 50\n" + kArm +
            "[[joint]]\nname = \"j\"\nkind = \"hinge\"\nparent = \"world\"\nchild = \"arm\"\n"
            "point_m = [0, 0, 0]\naxis = [0, -1, 0]\nmotor_torque_n_m = " +
            std::to_string(torque_n_m) +
            "\n[[motion]]\njoint = \"j\"\nkey = [{ t_s = 0, position_deg = 0 }]\n");
        const auto world = world_of(scene);
        run_to(*world, 0.5);
        const double fallen_deg = -world->joints()[0].position / kDegree;
        if (torque_n_m < 49) {
            EXPECT_GT(fallen_deg, 5);
        } else {
            EXPECT_NEAR(fallen_deg, 0, 0.5);
        }
    }
}

TEST(SceneWorld, slider_follows_its_keys_along_the_axis) {
    const Scene scene =
        parsed(kNoGravity + kArm +
               "[[joint]]\nname = \"j\"\nkind = \"slider\"\nparent = \"world\"\nchild = \"arm\"\n"
               "point_m = [0, 0, 0]\naxis = [0, 0, 1]\nmotor_force_n = 5000\n"
               "[[motion]]\njoint = \"j\"\nkey = [{ t_s = 0, offset_m = 0 }, { t_s = 1, offset_m = "
               "0.4 }]\n");
    const auto world = world_of(scene);
    run_to(*world, 2);
    EXPECT_NEAR(world->joints()[0].position, 0.4, 2e-3);
    EXPECT_NEAR(world->find_body("arm")->pose().position.z, 0.4, 2e-3);
}

TEST(SceneWorld, suspension_carries_the_weight_and_its_motor_rolls_forward) {
    std::string text =
        "[world]\nduration_s = 9\nsolver_iterations = 50\n"
        "[[body]]\nname = \"chassis\"\nshape = \"box\"\nsize_m = [2, 1, 0.2]\nmass_kg = "
        "400\nposition_m = [0, 0, 0.4]\n";
    for (const auto& [name, x, y] :
         {std::tuple{"a", 0.8, 0.7}, {"b", 0.8, -0.7}, {"c", -0.8, 0.7}, {"d", -0.8, -0.7}}) {
        const std::string n = name,
                          at = "[" + std::to_string(x) + ", " + std::to_string(y) + ", 0.4]";
        text +=
            "[[body]]\nname = \"" + n +
            "\"\nshape = \"cylinder\"\nradius_m = 0.4\nheight_m = 0.2\naxis = \"y\"\nmass_kg = 20\n"
            "friction = 1\nposition_m = " +
            at + "\n[[joint]]\nname = \"j" + n +
            "\"\nkind = \"suspension\"\nparent = \"chassis\"\nchild = \"" + n +
            "\"\npoint_m = " + at +
            "\naxis = [0, 1, 0]\nspring_axis = [0, 0, 1]\nstiffness_n_m = 20e3\ndamping_n_s_m = "
            "2e3\n"
            "motor_torque_n_m = 200\n[[motion]]\njoint = \"j" +
            n + "\"\nkey = [{ t_s = 2, velocity_deg_s = 0 }, { t_s = 3, velocity_deg_s = 90 }]\n";
    }
    const Scene scene = parsed(text);
    const auto world = world_of(scene);
    run_to(*world, 2);
    const Pose rest = world->find_body("chassis")->pose();
    // 100 kg on each spring of 20 kN/m: 4.9 cm. Bullet's margins and soft contacts take a few
    // millimetres.
    EXPECT_NEAR(rest.position.z, 0.4 - 100 * 9.81 / 20e3, 8e-3);
    EXPECT_NEAR(rest.position.x, 0, 5e-3);
    run_to(*world, 5);
    const double way_m = world->find_body("chassis")->pose().position.x - rest.position.x;
    EXPECT_NEAR(way_m, 0.4 * 90 * kDegree * 2.5, 0.1);  // half a second lost to the ramp
}

TEST(SceneWorld, kinematic_body_moves_with_the_velocity_of_its_keys) {
    const Scene scene = parsed(
        kNoGravity +
        "[[body]]\nname = \"a\"\nshape = \"box\"\nsize_m = [1, 1, 1]\nkinematic = true\n"
        "[[motion]]\nbody = \"a\"\ninterpolation = \"linear\"\n"
        "key = [{ t_s = 0, position_m = [0, 0, 0] }, { t_s = 2, position_m = [1, 0, 0] }]\n");
    const auto world = world_of(scene);
    run_to(*world, 1);
    EXPECT_NEAR(world->find_body("a")->pose().position.x, 0.5, 1e-5);
    EXPECT_NEAR(world->find_body("a")->body->getLinearVelocity().x(), 0.5, 1e-3);
}

TEST(SceneWorld, compound_has_its_centre_of_mass_where_its_parts_put_it) {
    const Scene scene = parsed(
        kNoGravity +
        "[[body]]\nname = \"a\"\nshape = \"compound\"\nmass_kg = 4\nposition_m = [5, 0, 0]\n"
        "[[body.part]]\nshape = \"box\"\nsize_m = [1, 1, 1]\nmass_kg = 1\n"
        "[[body.part]]\nshape = \"sphere\"\nradius_m = 0.5\nposition_m = [0, 0, 2]\nmass_kg = 3\n");
    const auto world = world_of(scene);
    const SceneBody& body = *world->find_body("a");
    EXPECT_NEAR(body.frame_to_center.position.z, 1.5, 1e-5);
    EXPECT_NEAR(body.body->getWorldTransform().getOrigin().z(), 1.5, 1e-5);
    EXPECT_NEAR(body.pose().position.x, 5, 1e-5);
    EXPECT_NEAR(body.pose().position.z, 0, 1e-5);
}

TEST(SceneWorld, bodies_of_a_group_pass_through_each_other) {
    for (const bool grouped : {false, true}) {
        std::string text = "[world]\nduration_s = 9\n";
        for (const double z : {0.5, 1.6}) {
            text += "[[body]]\nname = \"" + std::to_string(z) +
                    "\"\nshape = \"box\"\nsize_m = [1, 1, 1]\nmass_kg = 1\nposition_m = [0, 0, " +
                    std::to_string(z) + "]\n" + (grouped ? "group = \"g\"\n" : "");
        }
        const Scene scene = parsed(text);
        const auto world = world_of(scene);
        run_to(*world, 2);
        EXPECT_NEAR(world->bodies()[1].pose().position.z, grouped ? 0.5 : 1.5, 0.02);
    }
}

TEST(SceneWorld, both_ways_up_give_the_same_motion) {
    Scene scene = parsed(
        "[world]\nduration_s = 9\n[[body]]\nname = \"a\"\nshape = \"box\"\nsize_m = [1, 0.6, "
        "0.4]\nmass_kg = 3\n"
        "position_m = [0, 0, 2]\nrotation_deg = [20, 30, 40]\nvelocity_m_s = [1, 0.5, "
        "0]\nangular_velocity_deg_s = [0, 90, 0]\n");
    const auto z_up = world_of(scene);
    run_to(*z_up, 0.5);  // in flight: impacts would multiply the rounding of the turn
    Scene turned = scene;
    set_up_axis(turned, UpAxis::y);
    const auto y_up = world_of(turned);
    run_to(*y_up, 0.5);
    const Vec3 a = z_up->bodies()[0].pose().position, b = y_up->bodies()[0].pose().position;
    EXPECT_NEAR(a.x, b.x, 1e-5);
    EXPECT_NEAR(a.z, b.y, 1e-5);
    EXPECT_NEAR(a.y, -b.z, 1e-5);
}

TEST(SceneWorld, same_scene_gives_the_same_bits) {
    const auto scene = load_scene(std::string(BSOIL_SCENES_DIR) + "/excavator.toml");
    ASSERT_TRUE(scene) << scene.error();
    const auto a = world_of(*scene), b = world_of(*scene);
    run_to(*a, 2);
    run_to(*b, 2);
    for (size_t i = 0; i < a->bodies().size(); ++i) {
        const Pose p = a->bodies()[i].pose(), q = b->bodies()[i].pose();
        EXPECT_EQ(length(p.position - q.position), 0) << a->bodies()[i].name;
    }
}

TEST(SceneWorld, wind_is_turned_with_the_scene) {
    Scene scene =
        parsed("[world]\nduration_s = 9\n[soil]\nsize_m = [2, 3, 1]\nwind_m_s = [1, 2, 3]\n");
    set_up_axis(scene, UpAxis::y);
    EXPECT_EQ(length(scene.soil->def.wind_m_s - Vec3{1, 3, -2}), 0);
    set_up_axis(scene, UpAxis::z);
    EXPECT_EQ(length(scene.soil->def.wind_m_s - Vec3{1, 2, 3}), 0);
}

// Its rows follow the second level axis: y, and z, which looks the other way.
TEST(SceneWorld, height_map_is_turned_and_not_mirrored) {
    Scene scene = parsed("[world]\nduration_s = 9\n[soil]\nsize_m = [2, 3, 1]\nvoxel_m = 0.1\n");
    FillItem hill;
    hill.kind = "height_map";
    hill.height_map.width = 2;
    hill.height_map.height = 3;
    hill.height_map.heights_m = {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F};
    scene.fills.push_back(hill);
    Scene turned = scene;
    set_up_axis(turned, UpAxis::y);
    auto z_up = Soil::create(soil_def(scene)), y_up = Soil::create(soil_def(turned));
    ASSERT_TRUE(z_up && y_up);
    ASSERT_TRUE(fill_soil(scene, **z_up) && fill_soil(turned, **y_up));
    for (const double x : {-0.85, 0.05, 0.95}) {
        for (const double y : {-1.35, -0.45, 0.75, 1.45}) {
            const auto height_m = [](const Soil& soil, Vec3 at) {
                return surface_height_m(soil, at);
            };
            EXPECT_NEAR(height_m(**y_up, {x, 0.5, -y}), height_m(**z_up, {x, y, 0.5}), 1e-3)
                << x << ' ' << y;
        }
    }
    set_up_axis(turned, UpAxis::z);
    EXPECT_EQ(turned.fills[0].height_map.heights_m, hill.height_map.heights_m);
}

// Without soil a step of the run is made of whole steps of Bullet, so that the run's time is
// Bullet's; one whose soil is taken away keeps its step.
TEST(SceneWorld, time_without_soil_is_that_of_bullet) {
    for (const auto& [substep_s, step_s] :
         {std::pair{0.005, 0.015}, {0.01, 0.02}, {1.0 / 240, 1.0 / 60}, {0.05, 0.05}}) {
        const Scene scene =
            parsed(fmt::format("[world]\nduration_s = 1\nsubstep_s = {}\n", substep_s));
        auto run = SceneRun::create(scene, {.backend = Backend::cpu});
        ASSERT_TRUE(run) << run.error();
        EXPECT_NEAR((*run)->step_s(), step_s, 1e-12);
        for (int i = 0; i < 5; ++i) (*run)->step();
        EXPECT_NEAR((*run)->bullet().time_s(), (*run)->time_s(), 1e-9) << substep_s;
        EXPECT_NEAR((*run)->time_s(), 5 * step_s, 1e-9);
    }
}

TEST(SceneWorld, terrain_is_the_same_both_ways_up) {
    TerrainItem terrain;
    terrain.kind = "caves";
    terrain.overhang_m = 0.3;
    const DensityFunction z_up = terrain_density(terrain, UpAxis::z, {1, 2, 3});
    const DensityFunction y_up = terrain_density(terrain, UpAxis::y, {1, 3, -2});
    for (const Vec3 p : {Vec3{0.3, 0.4, 0.5}, {2.2, -1.1, 3.6}, {-1.7, 0.9, 3.1}}) {
        EXPECT_DOUBLE_EQ(z_up(p), y_up({p.x, p.z, -p.y}));
    }
    EXPECT_LT(z_up({0, 0, 50}), 0);
}

TEST(ConvexHull, cube_has_its_volume_and_outward_triangles) {
    std::vector<Vec3> points;
    for (int i = 0; i < 8; ++i) {
        points.push_back({2.0 * (i & 1), 1.0 * (i >> 1 & 1), 3.0 * (i >> 2)});
    }
    points.push_back({1, 0.5, 1});  // inside
    const ConvexHull hull = convex_hull(points);
    EXPECT_NEAR(hull.volume_m3, 6, 1e-4);
    EXPECT_EQ(hull.surface.vertices.size(), 8u);
    EXPECT_EQ(hull.surface.triangles.size(), 12u);
    for (const auto& [a, b, c] : hull.surface.triangles) {
        const auto& v = hull.surface.vertices;
        EXPECT_GT(dot(cross(v[b] - v[a], v[c] - v[a]), v[a] - Vec3{1, 0.5, 1.5}), 0);
    }
    EXPECT_TRUE(
        convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}).surface.triangles.empty());
}

}  // namespace
}  // namespace bsoil::scene::scene_world_test
