/// The scenes of the project, their documentation, and the files scenes read.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "files/data_files.h"
#include "reading/scene_load.h"
#include "run/baseline.h"
#include "run/telemetry.h"

namespace bsoil::scene::scene_files_test {
namespace {
namespace fs = std::filesystem;

std::string content(const fs::path& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

void write(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

/// A folder that goes when the test ends.
class SceneFiles : public testing::Test {
  protected:
    void SetUp() override {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::path(testing::TempDir()) / (std::string("bsoil_") + test->name());
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    fs::path folder_;
};

TEST(Scenes, every_scene_of_the_project_is_valid_both_ways_up) {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(BSOIL_SCENES_DIR)) {
        if (entry.path().extension() != ".toml") continue;
        auto scene = load_scene(entry.path().string());
        ASSERT_TRUE(scene) << scene.error();
        ++count;
        if (!scene->missing_data.empty()) continue;
        for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
            set_up_axis(*scene, up);
            if (!scene->soil) continue;
            const Status valid = soil_def(*scene).validate();
            EXPECT_TRUE(valid) << entry.path() << ": " << valid.error();
        }
        EXPECT_FALSE(scene->title.empty()) << entry.path();
        EXPECT_FALSE(scene->description.empty()) << entry.path();
    }
    EXPECT_GE(count, 8);
}

TEST(Scenes, visuals_are_rows_rings_and_mirror_images) {
    const auto scene = parse_scene(R"([world]
duration_s = 1
[[body]]
name = "wheel"
shape = "sphere"
radius_m = 0.5
visual = [
    { shape = "box", size_m = [0.1, 0.2, 0.1], position_m = [0, 0.3, 0.5], rotation_deg = [0, 0, 30], bevel_m = 0.01, repeat_count = 4, repeat_turn_deg = 90, mirror = true },
    { shape = "sphere", radius_m = 0.1, position_m = [1, 0, 0], repeat_count = 3, repeat_step_m = [0.5, 0, 0] },
]
)",
                                   "s.toml");
    ASSERT_TRUE(scene) << scene.error();
    const auto& drawn = scene->bodies[0].drawn;
    ASSERT_EQ(drawn.size(), 8u + 3u);
    const auto expect_at = [&drawn](size_t item, Vec3 place) {
        EXPECT_NEAR(length(drawn[item].solid.pose.position - place), 0, 1e-12) << item;
    };
    expect_at(0, {0, 0.3, 0.5});
    expect_at(1, {0, -0.3, 0.5});
    expect_at(2, {0.5, 0.3, 0});  // a quarter about y: z turns to x
    expect_at(4, {0, 0.3, -0.5});
    expect_at(8, {1, 0, 0});
    expect_at(10, {2, 0, 0});
    EXPECT_EQ(drawn[0].bevel_m, 0.01);
    // An arrow along the box's x, 30 degrees to the left, points 30 degrees to the right in its
    // image.
    const Vec3 left = rotate(drawn[0].solid.pose.rotation, {1, 0, 0});
    const Vec3 right = rotate(drawn[1].solid.pose.rotation, {1, 0, 0});
    EXPECT_NEAR(left.y, 0.5, 1e-12);
    EXPECT_NEAR(right.y, -0.5, 1e-12);
    EXPECT_NEAR(left.x, right.x, 1e-12);
    // Nothing of it collides.
    EXPECT_EQ(scene->bodies[0].solids().size(), 1u);
}

TEST(Scenes, readme_is_what_scene_keys_prints) {
    EXPECT_EQ(content(fs::path(BSOIL_SCENES_DIR) / "README.md"), schema_markdown())
        << "write it again: bsoil scene-keys --markdown > demos/scenes/README.md";
}

TEST_F(SceneFiles, turning_up_there_and_back_changes_nothing) {
    auto scene = load_scene(std::string(BSOIL_SCENES_DIR) + "/excavator.toml");
    ASSERT_TRUE(scene) << scene.error();
    const Scene before = *scene;
    set_up_axis(*scene, UpAxis::y);
    EXPECT_EQ(scene->soil->def.size_m.y, before.soil->def.size_m.z);
    EXPECT_EQ(scene->fills[0].max_m.y, before.fills[0].max_m.z);
    EXPECT_EQ(scene->bodies[0].pose.position.y, before.bodies[0].pose.position.z);
    set_up_axis(*scene, UpAxis::z);
    for (size_t b = 0; b < before.bodies.size(); ++b) {
        const Vec3 off = scene->bodies[b].pose.position - before.bodies[b].pose.position;
        EXPECT_EQ(length(off), 0) << before.bodies[b].name;
        const Quat turned =
            scene->bodies[b].pose.rotation * conjugate(before.bodies[b].pose.rotation);
        EXPECT_NEAR(std::abs(turned.w), 1, 1e-12) << before.bodies[b].name;
    }
}

// A box of 1 kg, a plate of 3 kg fixed to it one metre above, and a wheel on a joint. The optenv is
// left over from xacro.
constexpr const char* kUrdf = R"urdf(<robot name="cart">
<link name="root"/>
<joint name="to_base" type="fixed"><parent link="root"/><child link="base"/>
  <origin xyz="0 0 0.5" rpy="$(optenv CART_RPY 0 0 0)"/></joint>
<link name="base"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  <collision><geometry><box size="1 1 0.2"/></geometry></collision></link>
<joint name="to_plate" type="fixed"><parent link="base"/><child link="plate"/><origin xyz="0 0 1"/></joint>
<link name="plate"><inertial><mass value="3"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="axle" type="continuous"><parent link="base"/><child link="wheel"/>
  <origin xyz="0 0.6 0"/><axis xyz="0 1 0"/></joint>
<link name="wheel"><inertial><mass value="0.01"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  <collision><geometry><cylinder radius="0.3" length="0.1"/></geometry></collision></link>
</robot>)urdf";
constexpr const char* kCartScene = R"([world]
duration_s = 1
[[robot]]
name = "cart"
file = "cart.urdf"
position_m = [10, 0, 0]
[[robot.link]]
link = "wheel"
mass_kg = 2
[[robot.motor]]
joint = "axle"
torque_n_m = 5
)";

TEST_F(SceneFiles, links_joined_by_fixed_joints_become_one_body) {
    write(folder_ / "cart.urdf", kUrdf);
    write(folder_ / "cart.toml", kCartScene);
    const auto scene = load_scene((folder_ / "cart.toml").string());
    ASSERT_TRUE(scene) << scene.error();
    ASSERT_EQ(scene->bodies.size(), 2u);
    const BodyItem& base = *scene->find_body("cart/base");
    EXPECT_EQ(base.mass_kg, 4);
    ASSERT_TRUE(base.inertial);
    EXPECT_NEAR(base.inertial->frame.position.z, 0.5 + 0.75,
                1e-12);  // 3 of 4 kg are 1 m above the rest
    const Vec3 moments = base.inertial->moments_kg_m2;
    EXPECT_NEAR(moments.x + moments.y + moments.z, 6 + 2 * 0.75,
                1e-9);  // reduced mass 0.75 kg at 1 m, about x and y
    const BodyItem& wheel = *scene->find_body("cart/wheel");
    EXPECT_EQ(wheel.mass_kg, 2);
    ASSERT_TRUE(wheel.inertial);  // of its cylinder, evenly dense; moments rise
    EXPECT_NEAR(wheel.inertial->moments_kg_m2.x, 2.0 / 12 * (3 * 0.3 * 0.3 + 0.1 * 0.1), 1e-12);
    EXPECT_NEAR(wheel.inertial->moments_kg_m2.z, 2.0 / 2 * 0.3 * 0.3, 1e-12);
    const JointItem& axle = *scene->find_joint("cart/axle");
    EXPECT_EQ(axle.motor_torque_n_m, 5);
    EXPECT_NEAR(axle.point_m.x, 10, 1e-12);
    EXPECT_NEAR(axle.point_m.y, 0.6, 1e-12);
    EXPECT_NEAR(axle.axis.y, 1, 1e-12);
}

TEST_F(SceneFiles, unknown_link_of_a_robot_is_an_error) {
    write(folder_ / "cart.urdf", kUrdf);
    std::string scene = kCartScene;
    scene.replace(scene.find("\"wheel\""), 7, "\"whele\"");
    write(folder_ / "cart.toml", scene);
    const auto loaded = load_scene((folder_ / "cart.toml").string());
    ASSERT_FALSE(loaded);
    EXPECT_NE(loaded.error().find("cart.toml:8:8: the robot has no link \"whele\""),
              std::string::npos)
        << loaded.error();
}

TEST_F(SceneFiles, broken_urdf_is_an_error) {
    write(folder_ / "cart.urdf", "<robot name='r'><link");
    write(folder_ / "cart.toml", kCartScene);
    const auto loaded = load_scene((folder_ / "cart.toml").string());
    ASSERT_FALSE(loaded);
    EXPECT_NE(loaded.error().find("not a valid URDF"), std::string::npos) << loaded.error();
}

TEST_F(SceneFiles, data_is_looked_for_where_the_environment_says) {
    write(folder_ / "cart.urdf", kUrdf);
    setenv("BULLETSOIL_DATA", folder_.c_str(), 1);
    EXPECT_EQ(find_file("data:cart.urdf", "elsewhere/s.toml"), (folder_ / "cart.urdf").string());
    EXPECT_EQ(find_file("data:none.urdf", "elsewhere/s.toml"), "");
    unsetenv("BULLETSOIL_DATA");
}

TEST_F(SceneFiles, mesh_keeps_its_triangles_and_axes) {
    write(folder_ / "corner.obj",
          "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    const auto mesh = read_mesh((folder_ / "corner.obj").string());
    ASSERT_TRUE(mesh) << mesh.error();
    EXPECT_EQ(mesh->triangles.size(), 4u);
    EXPECT_EQ(mesh->vertices.size(), 4u);
    double height_m = 0;
    for (const Vec3 v : mesh->vertices) height_m = std::max(height_m, v.z);
    EXPECT_EQ(height_m, 3);
    EXPECT_FALSE(read_mesh((folder_ / "none.obj").string()));
}

TEST_F(SceneFiles, height_map_spans_black_to_white) {
    // a grey PNG of 2 x 1 pixels, black and white, 8 bits: signature, header, data (stored
    // deflate), end
    static constexpr unsigned char kPng[] = {
        0x89, 'P',  'N',  'G', 0x0d, 0x0a, 0x1a, 0x0a, 0,    0,    0,   13,   'I',  'H',  'D',
        'R',  0,    0,    0,   2,    0,    0,    0,    1,    8,    0,   0,    0,    0,    0xd1,
        0x49, 0x20, 0x56, 0,   0,    0,    14,   'I',  'D',  'A',  'T', 0x78, 0x01, 0x01, 0x03,
        0,    0xfc, 0xff, 0,   0x00, 0xff, 0x01, 0x02, 0x01, 0x00, 0,   0,    0,    0,    0,
        0,    0,    0,    'I', 'E',  'N',  'D',  0xae, 0x42, 0x60, 0x82};
    write(folder_ / "map.png", std::string(reinterpret_cast<const char*>(kPng), sizeof kPng));
    const auto map = read_height_map((folder_ / "map.png").string(), 0.5, 2.5);
    ASSERT_TRUE(map) << map.error();
    ASSERT_EQ(map->heights_m.size(), 2u);
    EXPECT_FLOAT_EQ(map->heights_m[0], 0.5f);
    EXPECT_FLOAT_EQ(map->heights_m[1], 2.5f);
    write(folder_ / "map.png", "no picture");
    EXPECT_FALSE(read_height_map((folder_ / "map.png").string(), 0, 1));
}

// 111 steps of 1/60 s are less than 1.85 s by a rounding.
TEST(Baseline, a_moment_at_the_end_of_the_run_is_sampled) {
    const auto scene = parse_scene(
        "[world]\nduration_s = 1.85\n[soil]\nsize_m = [1, 1, 1]\nvoxel_m = 0.1\n"
        "[record]\nmoments_s = [1.85]\n",
        "s.toml");
    ASSERT_TRUE(scene) << scene.error();
    const auto run = SceneRun::create(*scene, {.backend = Backend::cpu, .thread_count = 1});
    ASSERT_TRUE(run) << run.error();
    EXPECT_EQ(sample_moments_s(**run), std::vector<double>{1.85});
}

TEST_F(SceneFiles, telemetry_quotes_names_and_has_all_digits_of_places) {
    const auto scene = parse_scene(
        "[world]\nduration_s = 1\n[[body]]\nname = 'arm, \"left\"'\nshape = \"sphere\"\n"
        "radius_m = 0.1\nmass_kg = 1\nposition_m = [9000.125, 0, 2]\n",
        "s.toml");
    ASSERT_TRUE(scene) << scene.error();
    const auto run = SceneRun::create(*scene, {});
    ASSERT_TRUE(run) << run.error();
    auto telemetry = Telemetry::create(**run, folder_.string());
    ASSERT_TRUE(telemetry) << telemetry.error();
    telemetry->observe();
    ASSERT_TRUE(telemetry->finish());
    const std::string table = content(folder_ / "telemetry.csv");
    const std::string expected = "time_s,\"arm, \"\"left\"\".x_m\",\"arm, \"\"left\"\".y_m\",";
    EXPECT_EQ(table.substr(0, expected.size()), expected);
    // As many digits as a float has, far from the origin too.
    EXPECT_NE(table.find("\n0,9000.125,0,2,"), std::string::npos) << table;
}

// The soil on a tray is what the tray carries: some of it may still roll about on its rim.
TEST_F(SceneFiles, telemetry_has_the_soil_that_a_body_carries) {
    const auto scene = parse_scene(
        "[world]\nduration_s = 1\nground_plane = false\n"
        "[soil]\nsize_m = [1.2, 1.2, 0.8]\nvoxel_m = 0.05\n"
        "[[fill]]\nkind = \"box\"\nmin_m = [-0.15, -0.15, 0.2]\nmax_m = [0.15, 0.15, 0.3]\n"
        "[[body]]\nname = \"tray\"\nshape = \"box\"\nsize_m = [0.8, 0.8, 0.1]\n"
        "kinematic = true\nposition_m = [0, 0, 0.15]\n",
        "s.toml");
    ASSERT_TRUE(scene) << scene.error();
    const auto run = SceneRun::create(*scene, {.backend = Backend::cpu, .thread_count = 1});
    ASSERT_TRUE(run) << run.error();
    auto telemetry = Telemetry::create(**run, folder_.string());
    ASSERT_TRUE(telemetry) << telemetry.error();
    for (int step = 0; step < 30; ++step) (*run)->step();
    telemetry->observe();
    ASSERT_TRUE(telemetry->finish());
    const std::string table = content(folder_ / "telemetry.csv");
    EXPECT_NE(table.find(",tray.sinkage_m,tray.load_kg\n"), std::string::npos) << table;
    double soil_kg = 0;
    for (const double kg : (*run)->soil().totals().mass_kg) soil_kg += kg;
    EXPECT_GT(soil_kg, 10);
    const double load_kg = std::stod(table.substr(table.rfind(',') + 1));
    EXPECT_NEAR(load_kg, soil_kg, 0.05 * soil_kg);
}

TEST(Baseline, differences_say_where_and_by_how_much) {
    using Json = nlohmann::ordered_json;
    const Json expected{{"checksum", "aa"}, {"steps", 10}, {"end", {{"x", {1.0, 2.0}}}}};
    Json found = expected;
    EXPECT_TRUE(compare_baselines(expected, found, 0).empty());
    found["end"]["x"][1] = 2.5;
    found["checksum"] = "bb";
    const std::vector<std::string> exact = compare_baselines(expected, found, 0);
    ASSERT_EQ(exact.size(), 2u);
    EXPECT_EQ(exact[0], "checksum: expected \"aa\", found \"bb\"");
    EXPECT_EQ(exact[1], "end.x[1]: expected 2.0, found 2.5, off by +0.5");
    EXPECT_TRUE(compare_baselines(expected, found, 0.3).empty()) << "0.5 is less than 0.3 of 2";
    found.erase("steps");
    EXPECT_EQ(compare_baselines(expected, found, 0.3),
              std::vector<std::string>{"steps: expected, but not there"});
}

// A body that had blown up is null in a baseline, and equal to one that has blown up.
TEST(Baseline, what_is_no_number_equals_nothing) {
    using Json = nlohmann::ordered_json;
    const double nan = std::nan("");
    const Json lost{{"status", Json::array()}, {"end", {{"x", {1.0, nan}}}}};
    const Json sound{{"status", Json::array()}, {"end", {{"x", {1.0, 2.0}}}}};
    const Json saved = Json::parse(lost.dump());
    EXPECT_EQ(compare_baselines(saved, lost, 0),
              std::vector<std::string>{"end.x[1]: expected null, found no number"});
    EXPECT_EQ(compare_baselines(sound, lost, 0.5),
              std::vector<std::string>{"end.x[1]: expected 2.0, found no number"});
    EXPECT_EQ(compare_baselines(saved, sound, 0.5).size(), 1u);
    EXPECT_TRUE(compare_baselines(sound, sound, 0.5).empty());
    EXPECT_EQ(not_a_number_in(lost), "end.x[1]");
    EXPECT_EQ(not_a_number_in(sound), std::nullopt);
}

}  // namespace
}  // namespace bsoil::scene::scene_files_test
