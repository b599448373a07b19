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
    inline return link(name, inertial(mass) + kBox);
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
