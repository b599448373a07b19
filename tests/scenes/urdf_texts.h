// Robots as texts for tests, and the folder that they are read from.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "reading/scene_load.h"
#include "world/bullet_scene.h"

namespace bsoil::scene {

/// A folder that goes with the test, with files in it.
class Folder {
  public:
    Folder() {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        path_ =
            std::filesystem::temp_directory_path() / (std::string("bsoil_urdf_") + test->name());
        std::filesystem::remove_all(path_);
        std::filesystem::create_directories(path_);
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    void write(const std::string& name, const std::string& text) const {
        std::filesystem::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << text;
    }
    std::string scene_path() const { return (path_ / "s.toml").string(); }

  private:
    std::filesystem::path path_;
};

inline const std::string kWorld =
    "[world]\nduration_s = 9\nground_plane = false\nsolver_iterations = 50\n";
inline const std::string kStill = kWorld + "gravity_m_s2 = 0\n";
inline const std::string kRobot = "[[robot]]\nname = \"r\"\nfile = \"r.urdf\"\n";

inline std::string urdf(const std::string& content) {
    return "<?xml version=\"1.0\"?>\n<robot name=\"r\">\n" + content + "</robot>\n";
}
inline std::string link(const std::string& name, const std::string& content) {
    return "<link name=\"" + name + "\">" + content + "</link>\n";
}
/// A rod of 1 m along x from the link's frame.
inline std::string inertial(const std::string& mass, const std::string& moment = "1") {
    return "<inertial><origin xyz=\"0.5 0 0\"/><mass value=\"" + mass + "\"/><inertia ixx=\"" +
           moment + "\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>";
}
inline const std::string kBox =
    "<collision><origin xyz=\"0.5 0 0\"/><geometry><box size=\"1 0.1 "
    "0.1\"/></geometry></collision>";
inline std::string rod(const std::string& name, const std::string& mass = "2") {
    return link(name, inertial(mass) + kBox);
}
inline std::string joint(const std::string& name, const std::string& type,
                         const std::string& parent, const std::string& child,
                         const std::string& more = "") {
    return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + "\"/><origin xyz=\"1 0 0\"/><axis xyz=\"0 1 0\"/>" +
           more + "</joint>\n";
}
inline const std::string kLimits =
    "<limit lower=\"-1\" upper=\"2\" effort=\"500\" velocity=\"0.5\"/>";

/// An open box (bin), outer size 1 x 1 x 0.6 m, walls and floor 0.1 m thick, open to +z.
inline std::string bin_obj() {
    std::string text;
    const auto corners = [&](double r, double z) {
        for (const auto& [x, y] : {std::pair{-r, -r}, {r, -r}, {r, r}, {-r, r}}) {
            text +=
                "v " + std::to_string(x) + ' ' + std::to_string(y) + ' ' + std::to_string(z) + '\n';
        }
    };
    corners(0.5, 0);    // 1..4
    corners(0.5, 0.6);  // 5..8
    corners(0.4, 0.6);  // 9..12
    corners(0.4, 0.1);  // 13..16
    text += "f 4 3 2 1\nf 13 14 15 16\n";
    for (const int low : {1, 5, 9}) {  // outside, rim, inside
        for (int i = 0; i < 4; ++i) {
            const int j = (i + 1) % 4;
            text += "f";
            for (const int v : {low + i, low + j, low + 4 + j, low + 4 + i}) {
                text += ' ' + std::to_string(v);
            }
            text += '\n';
        }
    }
    return text;
}
inline std::string mesh_link(const std::string& file, const std::string& scale = "1 1 1") {
    return link("bin", inertial("2") + "<collision><geometry><mesh filename=\"" + file +
                           "\" scale=\"" + scale + "\"/></geometry></collision>");
}

inline Result<Scene> scene_of(const Folder& folder, const std::string& file,
                              const std::string& scene) {
    folder.write("r.urdf", file);
    return parse_scene(scene, folder.scene_path());
}

inline void expect_error(const std::string& file, const std::string& scene,
                         const std::string& text) {
    const Folder folder;
    const auto found = scene_of(folder, file, scene);
    ASSERT_FALSE(found) << "no error, wanted: " << text;
    EXPECT_NE(found.error().find(text), std::string::npos) << found.error();
}

inline void run_to(BulletScene& world, double t_s) {
    while (world.time_s() < t_s - 1e-9) world.substep();
}

}  // namespace bsoil::scene
