/// URDF files as others publish them, on soil. Skipped where the data folder is absent.
#include <gtest/gtest.h>

#include <cmath>

#include "files/data_files.h"
#include "reading/scene_load.h"
#include "run/scene_run.h"

namespace bsoil::scene::urdf_files_test {
namespace {

struct PublishedFile {
    const char* name;
    const char* file;
    double height_m;  ///< of the root link's frame at the start
    const char* build;
    const char* keys = "";  ///< what the scene has to say of it
    double lowest_m = 0.2;  ///< of any moving body after half a second
};

// The gripper's meshes of r2d2 are not among the published files.
constexpr const char* kWithoutGrippers =
    "[[robot.link]]\nlink = \"left_gripper\"\ncollision = \"none\"\n"
    "[[robot.link]]\nlink = \"right_gripper\"\ncollision = \"none\"\n"
    "[[robot.link]]\nlink = \"left_tip\"\ncollision = \"none\"\n"
    "[[robot.link]]\nlink = \"right_tip\"\ncollision = \"none\"\n";

const PublishedFile kFiles[] = {
    {"block", "bullet3/block.urdf", 0.5, "bodies"},
    {"block_as_multibody", "bullet3/block.urdf", 0.5, "multibody"},
    {"cube", "bullet3/cube.urdf", 0.95, "bodies"},
    {"cube_as_multibody", "bullet3/cube.urdf", 0.95, "multibody"},
    {"plane", "bullet3/plane.urdf", 0, "bodies"},
    {"plane_as_multibody", "bullet3/plane.urdf", 0, "multibody"},
    {"terrain", "bullet3/terrain.urdf", 0.1, "bodies"},
    {"wheel", "bullet3/wheel.urdf", 0.5, "bodies"},
    {"wheel_as_multibody", "bullet3/wheel.urdf", 0.5, "multibody"},
    {"husky", "bullet3/husky/husky.urdf", 0.58, "bodies"},
    {"husky_as_multibody", "bullet3/husky/husky.urdf", 0.58, "multibody"},
    {"r2d2", "bullet3/r2d2.urdf", 0.95, "bodies", kWithoutGrippers},
    {"r2d2_as_multibody", "bullet3/r2d2.urdf", 0.95, "multibody", kWithoutGrippers},
};

class PublishedUrdf : public testing::TestWithParam<PublishedFile> {};
INSTANTIATE_TEST_SUITE_P(Bullet3, PublishedUrdf, testing::ValuesIn(kFiles),
                         [](const auto& file) { return std::string(file.param.name); });

TEST_P(PublishedUrdf, stands_on_soil) {
    const PublishedFile& given = GetParam();
    const std::string path = std::string(BSOIL_SCENES_DIR) + "/s.toml";
    const std::string file = std::string("data:") + given.file;
    if (find_file(file, path).empty()) {
        GTEST_SKIP() << file << ": set BULLETSOIL_DATA";
    }
    const auto scene = parse_scene(
        "[world]\nduration_s = 0.5\n[soil]\nsize_m = [2.4, 2.4, 0.8]\nvoxel_m = 0.06\n"
        "[[fill]]\nkind = \"box\"\nmin_m = [-2, -2, 0]\nmax_m = [2, 2, 0.42]\n"
        "[[robot]]\nname = \"r\"\nfile = \"" +
            file + "\"\nbuild = \"" + given.build + "\"\nposition_m = [0, 0, " +
            std::to_string(given.height_m) + "]\n" + given.keys,
        path);
    ASSERT_TRUE(scene) << scene.error();
    auto run = SceneRun::create(*scene, {.backend = Backend::cpu});
    ASSERT_TRUE(run) << run.error();
    while (!(*run)->finished()) (*run)->step();
    EXPECT_EQ((*run)->soil().totals().units, (*run)->totals_at_start().units);
    EXPECT_TRUE((*run)->action().refused().empty()) << (*run)->action().refused().front().reason;
    for (const SceneBody& body : (*run)->bullet().bodies()) {
        ASSERT_TRUE(is_finite(body.pose())) << body.name;
        if (body.item->mass_kg <= 0 || body.item->is_ghost) continue;
        EXPECT_GT(body.pose().position.z, given.lowest_m) << body.name;
        EXPECT_LT(length(body.pose().position), 2) << body.name;
    }
}

}  // namespace
}  // namespace bsoil::scene::urdf_files_test
