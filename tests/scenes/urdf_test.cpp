/// Robots out of URDF files: what they become, as rigid bodies and as a multibody, and what is
/// refused.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "reading/scene_load.h"
#include "robots/convex_parts.h"
#include "scene/rotations.h"
#include "world/bullet_scene.h"

namespace bsoil::scene {
namespace {

namespace fs = std::filesystem;

/// A folder that goes with the test, with files in it.
class Folder {
  public:
    Folder() {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        path_ = fs::temp_directory_path() / (std::string("bsoil_urdf_") + test->name());
        fs::remove_all(path_);
        fs::create_directories(path_);
    }
    ~Folder() { fs::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    void write(const std::string& name, const std::string& text) const {
        fs::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << text;
    }
    std::string scene_path() const { return (path_ / "s.toml").string(); }

  private:
    fs::path path_;
};

const std::string kWorld =
    "[world]\nduration_s = 9\nground_plane = false\nsolver_iterations = 50\n";
const std::string kStill = kWorld + "gravity_m_s2 = 0\n";
const std::string kRobot = "[[robot]]\nname = \"r\"\nfile = \"r.urdf\"\n";

std::string urdf(const std::string& content) {
    return "<?xml version=\"1.0\"?>\n<robot name=\"r\">\n" + content + "</robot>\n";
}
std::string link(const std::string& name, const std::string& content) {
    return "<link name=\"" + name + "\">" + content + "</link>\n";
}
/// A rod of 1 m along x from the link's frame.
std::string inertial(const std::string& mass, const std::string& moment = "1") {
    return "<inertial><origin xyz=\"0.5 0 0\"/><mass value=\"" + mass + "\"/><inertia ixx=\"" +
           moment + "\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>";
}
const std::string kBox =
    "<collision><origin xyz=\"0.5 0 0\"/><geometry><box size=\"1 0.1 "
    "0.1\"/></geometry></collision>";
std::string rod(const std::string& name, const std::string& mass = "2") {
    return link(name, inertial(mass) + kBox);
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& more = "") {
    return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + "\"/><origin xyz=\"1 0 0\"/><axis xyz=\"0 1 0\"/>" +
           more + "</joint>\n";
}
const std::string kLimits = "<limit lower=\"-1\" upper=\"2\" effort=\"500\" velocity=\"0.5\"/>";

Result<Scene> scene_of(const Folder& folder, const std::string& file, const std::string& scene) {
    folder.write("r.urdf", file);
    return parse_scene(scene, folder.scene_path());
}

void expect_error(const std::string& file, const std::string& scene, const std::string& text) {
    const Folder folder;
    const auto found = scene_of(folder, file, scene);
    ASSERT_FALSE(found) << "no error, wanted: " << text;
    EXPECT_NE(found.error().find(text), std::string::npos) << found.error();
}

void run_to(BulletScene& world, double t_s) {
    while (world.time_s() < t_s - 1e-9) world.substep();
}

class UrdfRobot : public testing::TestWithParam<const char*> {
  protected:
    std::string robot() const { return kRobot + "build = \"" + GetParam() + "\"\n"; }
    /// The world of a robot; the scene stays in the fixture.
    std::unique_ptr<BulletScene> world(const std::string& file, const std::string& scene) {
        auto found = scene_of(folder_, file, scene);
        EXPECT_TRUE(found) << found.error();
        if (!found) return nullptr;
        scene_ = std::move(*found);
        auto made = BulletScene::create(scene_);
        EXPECT_TRUE(made) << made.error();
        return made ? std::move(*made) : nullptr;
    }
    Folder folder_;
    Scene scene_;
};
INSTANTIATE_TEST_SUITE_P(BothWays, UrdfRobot, testing::Values("bodies", "multibody"),
                         [](const auto& way) { return std::string(way.param); });

TEST_P(UrdfRobot, arm_stands_where_the_joints_start) {
    // A quarter turn about y takes x to -z: the elbow is at (1, 0, 0), the hand 1 m below it.
    const auto w = world(urdf(rod("base") + rod("arm") + link("hand", inertial("1")) +
                              joint("elbow", "revolute", "base", "arm", kLimits) +
                              joint("wrist", "prismatic", "arm", "hand", kLimits)),
                         kStill + robot() + "fixed_base = true\n" +
                             "[[robot.joint]]\njoint = \"elbow\"\nstart_deg = 90\n"
                             "[[robot.joint]]\njoint = \"wrist\"\nstart_m = 0.25\n");
    ASSERT_TRUE(w);
    const Vec3 arm = w->find_body("r/arm")->pose().position;
    const Vec3 hand = w->find_body("r/hand")->pose().position;
    EXPECT_NEAR(length(arm - Vec3{1, 0, 0}), 0, 1e-5);
    EXPECT_NEAR(length(hand - Vec3{1, 0.25, -1}), 0, 1e-5);
    EXPECT_NEAR(w->joints()[0].position, 90 * kDegree, 1e-6);
    EXPECT_NEAR(w->joints()[1].position, 0.25, 1e-6);
}

TEST_P(UrdfRobot, pendulum_swings_with_its_period) {
    // A rod of 1 m about its end, small swing: T = 2 pi sqrt(I / (m g d)), I = m / 12 + m / 4.
    const auto w = world(
        urdf(link("world", "") + rod("arm", "2") + joint("pivot", "continuous", "world", "arm")),
        kWorld + robot() +
            "[[robot.link]]\nlink = \"arm\"\nmass_kg = 2\n"
            "[[robot.joint]]\njoint = \"pivot\"\nstart_deg = 85\n");
    ASSERT_TRUE(w);
    const double inertia = 2 * (1.0 + 0.01) / 12 + 2 * 0.25;
    const double period_s = 2 * 3.14159265 * std::sqrt(inertia / (2 * 9.81 * 0.5));
    run_to(*w, period_s / 2);  // the far side: 95 deg
    EXPECT_NEAR(w->joints()[0].position / kDegree, 95, 0.3);
    run_to(*w, period_s);
    EXPECT_NEAR(w->joints()[0].position / kDegree, 85, 0.3);
}

TEST_P(UrdfRobot, damping_of_a_joint_slows_a_falling_rod) {
    const auto w = world(urdf(link("world", "") + rod("arm", "2") +
                              joint("pivot", "continuous", "world", "arm",
                                    "<dynamics damping=\"50\" friction=\"0\"/>")),
                         kWorld + robot());
    ASSERT_TRUE(w);
    EXPECT_TRUE(scene_.warnings.empty());
    run_to(*w, 1);
    // c theta' = m g d cos(theta), inertia aside: theta = 2 atan(tanh(m g d t / 2 c)). The inertia,
    // 1.5 kg m2, costs about its time constant, 0.03 s, of the way.
    const double way = 2 * std::atan(std::tanh(2 * 9.81 * 0.5 / (2 * 50)));
    EXPECT_NEAR(w->joints()[0].position, way * (1 - 0.03), 0.01 * way);
}

TEST_P(UrdfRobot, friction_of_a_joint_holds_or_slows_a_rod) {
    const auto angle_after = [&](const char* friction) {
        const auto w = world(urdf(link("world", "") + rod("arm", "2") +
                                  joint("pivot", "continuous", "world", "arm",
                                        std::string("<dynamics friction=\"") + friction + "\"/>")),
                             kWorld + robot());
        run_to(*w, 0.2);
        return w->joints()[0].position;
    };
    EXPECT_NEAR(angle_after("12"), 0, 1e-4);  // the weight's moment is 9.81 N m
    // I theta'' = 9.81 - 4.9 N m while the rod is about level: I = 1 + 2 * 0.5^2 kg m2. Substeps of
    // 1/240 s add 2 %.
    EXPECT_NEAR(angle_after("4.905"), 0.5 * 4.905 / 1.5 * 0.2 * 0.2, 0.03 * 0.0654);
}

TEST_P(UrdfRobot, damping_of_a_slider_gives_a_falling_speed) {
    const auto w =
        world(urdf(link("world", "") + rod("box", "2") +
                   "<joint name=\"rail\" type=\"prismatic\"><parent link=\"world\"/><child "
                   "link=\"box\"/><axis xyz=\"0 0 1\"/><limit lower=\"-9\" upper=\"9\" "
                   "effort=\"1\" velocity=\"1\"/><dynamics damping=\"100\"/></joint>"),
              kWorld + robot());
    ASSERT_TRUE(w);
    run_to(*w, 1);
    // m g / c, reached with the time constant m / c.
    EXPECT_NEAR(w->joints()[0].position, -2 * 9.81 / 100 * (1 - 0.02), 0.002);
}

TEST_P(UrdfRobot, motor_follows_positions_within_its_velocity_and_stops_at_the_limit) {
    const auto w =
        world(urdf(rod("base") + rod("arm") + joint("j", "revolute", "base", "arm", kLimits)),
              kStill + robot() +
                  "fixed_base = true\n[[robot.motor]]\njoint = \"j\"\n"
                  "[[motion]]\njoint = \"r/j\"\ninterpolation = \"step\"\nkey = ["
                  "{ t_s = 0, position_deg = 40 }, { t_s = 4, position_deg = 170 }]\n");
    ASSERT_TRUE(w);
    run_to(*w, 1);  // 0.5 rad/s is the URDF's limit
    EXPECT_NEAR(w->joints()[0].position, 0.5, 0.01);
    run_to(*w, 3.5);
    EXPECT_NEAR(w->joints()[0].position, 40 * kDegree, 0.01);
    run_to(*w, 8);  // the upper limit is 2 rad
    EXPECT_NEAR(w->joints()[0].position, 2, 0.03);
}

TEST_P(UrdfRobot, motor_gives_no_more_than_its_effort) {
    // The rod's weight pulls with 2 kg x 9.81 x 0.5 m = 9.81 N m.
    for (const double torque_n_m : {8.0, 12.0}) {
        const auto w = world(
            urdf(rod("base") + rod("arm") + joint("j", "revolute", "base", "arm", kLimits)),
            kWorld + robot() + "fixed_base = true\n[[robot.motor]]\njoint = \"j\"\ntorque_n_m = " +
                std::to_string(torque_n_m) +
                "\n[[motion]]\njoint = \"r/j\"\nkey = [{ t_s = 0, position_deg = 0 }]\n");
        ASSERT_TRUE(w);
        run_to(*w, 1);
        if (torque_n_m < 9.81) {
            EXPECT_GT(w->joints()[0].position, 0.1);
        } else {
            EXPECT_NEAR(w->joints()[0].position, 0, 0.01);
        }
    }
}

TEST_P(UrdfRobot, mimic_follows_the_other_joint) {
    const auto w = world(
        urdf(rod("base") + rod("a") + rod("b") + joint("ja", "revolute", "base", "a", kLimits) +
             joint("jb", "revolute", "base", "b",
                   kLimits + "<mimic joint=\"ja\" multiplier=\"-0.5\" offset=\"0.1\"/>")),
        kStill + robot() +
            "fixed_base = true\n[[robot.motor]]\njoint = \"ja\"\n"
            "[[motion]]\njoint = \"r/ja\"\nkey = [{ t_s = 0, position_deg = 0 }, "
            "{ t_s = 3, position_deg = 60 }]\n");
    ASSERT_TRUE(w);
    EXPECT_NEAR(w->joints()[1].position, 0.1, 1e-6);
    run_to(*w, 4);
    EXPECT_NEAR(w->joints()[0].position, 60 * kDegree, 0.01);
    EXPECT_NEAR(w->joints()[1].position, -30 * kDegree + 0.1, 0.01);
}

TEST_P(UrdfRobot, planar_joint_keeps_its_plane_and_floating_lets_go) {
    // The plane is square to y: the plate falls in it. The floating one falls as well, base and
    // all.
    const auto w =
        world(urdf(rod("base") + rod("plate") + rod("loose") +
                   joint("p", "planar", "base", "plate") + joint("f", "floating", "base", "loose")),
              kWorld + robot() + "fixed_base = true\n");
    ASSERT_TRUE(w);
    run_to(*w, 0.5);
    for (const char* name : {"r/plate", "r/loose"}) {
        const Vec3 at = w->find_body(name)->pose().position;
        EXPECT_NEAR(at.z, -9.81 / 2 * 0.25, 0.03) << name;
        EXPECT_NEAR(at.y, 0, 1e-3) << name;
        EXPECT_NEAR(at.x, 1, 1e-3) << name;
    }
    EXPECT_NEAR(length(w->find_body("r/base")->pose().position), 0, 1e-6);
}

TEST_P(UrdfRobot, links_ignore_each_other_unless_told) {
    // Two plates one above the other slide on the base: with collisions the upper one rests on the
    // lower one, which the limit of its joint holds.
    const std::string slide = "<limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/>";
    const std::string low = "<limit lower=\"0\" upper=\"2\" effort=\"1\" velocity=\"1\"/>";
    const auto slider = [](const std::string& name, const std::string& child, const char* z,
                           const std::string& limits) {
        return "<joint name=\"" + name +
               "\" type=\"prismatic\"><parent link=\"base\"/><child link=\"" + child +
               "\"/><origin xyz=\"3 0 " + z + "\"/><axis xyz=\"0 0 1\"/>" + limits + "</joint>\n";
    };
    const std::string file =
        urdf(rod("base") + rod("lower") + rod("upper") + slider("jl", "lower", "0", low) +
             slider("ju", "upper", "0.5", slide));
    for (const bool collide : {false, true}) {
        const auto w = world(file, kWorld + robot() + "fixed_base = true\nself_collide = " +
                                       (collide ? "true\n" : "false\n"));
        ASSERT_TRUE(w);
        run_to(*w, 2);
        EXPECT_NEAR(w->find_body("r/upper")->pose().position.z, collide ? 0.1 : -1.5, 0.03);
    }
}

TEST_P(UrdfRobot, free_base_falls_with_its_links) {
    const auto w = world(urdf(rod("base") + rod("arm") + joint("j", "continuous", "base", "arm")),
                         kWorld + robot() + "position_m = [0, 0, 3]\n");
    ASSERT_TRUE(w);
    double start_j = 0, end_j = 0;
    const btVector3 g(0, 0, btScalar(-9.81));
    for (const SceneBody& body : w->bodies()) start_j += body.mechanical_energy_j(g);
    run_to(*w, 0.5);
    for (const SceneBody& body : w->bodies()) end_j += body.mechanical_energy_j(g);
    EXPECT_NEAR(w->find_body("r/arm")->pose().position.z, 3 - 9.81 / 2 * 0.25, 0.02);
    EXPECT_NEAR(start_j, 4 * 9.81 * 3, 1e-3);
    EXPECT_NEAR(end_j, start_j, 0.6);  // an explicit step of 1/240 s gains g^2 dt t / 2 a kg
}

TEST(Urdf, replaced_mass_has_the_moments_of_its_solids) {
    const Folder folder;
    const auto scene = scene_of(
        folder, urdf(rod("base", "0.03")),
        kWorld + kRobot + "[[robot.link]]\nlink = \"base\"\nmass_kg = 12\nfriction = 0.9\n");
    ASSERT_TRUE(scene) << scene.error();
    const BodyItem& body = scene->bodies[0];
    EXPECT_DOUBLE_EQ(body.mass_kg, 12);
    EXPECT_DOUBLE_EQ(body.friction, 0.9);
    ASSERT_TRUE(body.inertial);
    EXPECT_NEAR(body.inertial->frame.position.x, 0.5, 1e-9);
    const Vec3 m = body.inertial->moments_kg_m2;  // rising
    EXPECT_NEAR(m.x, 12 * (0.01 + 0.01) / 12, 1e-9);
    EXPECT_NEAR(m.y, 12 * (1 + 0.01) / 12, 1e-9);
    EXPECT_NEAR(m.z, 12 * (1 + 0.01) / 12, 1e-9);
}

TEST(Urdf, merged_inertias_follow_the_parallel_axis_theorem) {
    // two point masses of 3 kg, 2 m apart, by fixed joints of 1 m
    const auto point = [](const std::string& name) {
        return link(name,
                    "<inertial><mass value=\"3\"/><inertia ixx=\"0\" ixy=\"0\" ixz=\"0\" "
                    "iyy=\"0\" iyz=\"0\" izz=\"0\"/></inertial>");
    };
    const Folder folder;
    const auto scene =
        scene_of(folder,
                 urdf(point("a") + link("b", kBox) + point("c") + joint("ab", "fixed", "a", "b") +
                      joint("bc", "fixed", "b", "c")),
                 kWorld + kRobot);
    ASSERT_TRUE(scene) << scene.error();
    ASSERT_EQ(scene->bodies.size(), 1u);
    const BodyItem& body = scene->bodies[0];
    EXPECT_EQ(body.name, "r/a");
    EXPECT_NEAR(body.inertial->frame.position.x, 1, 1e-9);
    EXPECT_NEAR(body.inertial->moments_kg_m2.y, 6, 1e-6);
    EXPECT_NEAR(body.inertial->moments_kg_m2.z, 6, 1e-6);
    EXPECT_NEAR(body.parts[0].pose.position.x, 1.5, 1e-9);
}

// --- meshes

/// An open box (bin), outer size 1 x 1 x 0.6 m, walls and floor 0.1 m thick, open to +z.
std::string bin_obj() {
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
std::string mesh_link(const std::string& file, const std::string& scale = "1 1 1") {
    return link("bin", inertial("2") + "<collision><geometry><mesh filename=\"" + file +
                           "\" scale=\"" + scale + "\"/></geometry></collision>");
}
double hulls_m3(const Scene& scene) {
    double sum_m3 = 0;
    for (const ShapeItem& part : scene.bodies.at(0).parts) {
        sum_m3 += convex_hull(part.points_m).volume_m3;
    }
    return sum_m3;
}
constexpr double kBinHull = 0.6, kBinSolid = 0.6 - 0.8 * 0.8 * 0.5;  // [m3]

TEST(Urdf, mesh_becomes_hull_or_convex_parts_or_itself) {
    const Folder folder;
    folder.write("meshes/bin.obj", bin_obj());
    const auto with = [&](const std::string& keys, const std::string& scale = "1 1 1") {
        auto scene =
            scene_of(folder, urdf(mesh_link("meshes/bin.obj", scale)), kWorld + kRobot + keys);
        EXPECT_TRUE(scene) << scene.error();
        return scene ? *scene : Scene{};
    };
    EXPECT_NEAR(hulls_m3(with("")), kBinHull, 1e-3);
    EXPECT_NEAR(hulls_m3(with("", "2 -1 0.5")), kBinHull, 1e-3);
    EXPECT_NEAR(hulls_m3(with("collision = \"components\"\n")), kBinHull, 1e-3);
    const Scene parted = with("collision = \"decompose\"\n");
    EXPECT_NEAR(hulls_m3(parted), kBinSolid, 0.03 * kBinSolid);
    EXPECT_EQ(parted.bodies[0].parts.size(), 5u);
    const Scene exact = with("[[robot.link]]\nlink = \"bin\"\ncollision = \"mesh\"\nmass_kg = 5\n");
    ASSERT_TRUE(exact.bodies[0].parts[0].mesh);
    EXPECT_NEAR(mesh_volume_m3(*exact.bodies[0].parts[0].mesh), kBinSolid, 1e-6);
    const auto none =
        scene_of(folder, urdf(mesh_link("no.obj")), kWorld + kRobot + "collision = \"none\"\n");
    ASSERT_TRUE(none) << none.error();
    EXPECT_TRUE(none->bodies[0].is_ghost);
}

TEST(Urdf, thickened_plates_grow_outwards) {
    const Folder folder;
    folder.write("bin.obj", bin_obj());
    const auto scene = scene_of(folder, urdf(mesh_link("bin.obj")),
                                kWorld + kRobot +
                                    "[[robot.link]]\nlink = \"bin\"\ncollision = \"decompose\"\n"
                                    "thickness_m = 0.2\n");
    ASSERT_TRUE(scene) << scene.error();
    for (const ShapeItem& part : scene->bodies[0].parts) {
        for (const Vec3 p : part.points_m) {
            const bool inside = std::abs(p.x) < 0.399 && std::abs(p.y) < 0.399 && p.z > 0.101;
            EXPECT_FALSE(inside) << p.x << ' ' << p.y << ' ' << p.z;
        }
    }
}

TEST(Urdf, ball_lies_in_a_bin_of_parts_or_of_triangles) {
    const std::string ball =
        "[[body]]\nname = \"ball\"\nshape = \"sphere\"\nradius_m = 0.2\nmass_kg = 1\nposition_m = "
        "[0, 0, 0.5]\n";
    for (const char* collision : {"decompose", "mesh"}) {
        for (const char* base :
             {"fixed_base = true\n", ""}) {  // static, and falling onto the plane
            const Folder folder;
            folder.write("bin.obj", bin_obj());
            const auto scene = scene_of(folder, urdf(mesh_link("bin.obj")),
                                        "[world]\nduration_s = 9\n" + kRobot + base +
                                            "[[robot.link]]\nlink = \"bin\"\nmass_kg = 50\n"
                                            "collision = \"" +
                                            collision + "\"\n" + ball);
            ASSERT_TRUE(scene) << scene.error();
            const auto w = BulletScene::create(*scene);
            ASSERT_TRUE(w) << w.error();
            run_to(**w, 2);
            EXPECT_NEAR((*w)->find_body("ball")->pose().position.z, 0.3, 0.03) << collision << base;
        }
    }
}

TEST(Urdf, package_names_are_looked_for_above_the_file) {
    const Folder folder;
    folder.write("pkg/meshes/bin.obj", bin_obj());
    folder.write("pkg/urdf/r.urdf", urdf(mesh_link("package://pkg/meshes/bin.obj")));
    const auto scene = parse_scene(kWorld + "[[robot]]\nname = \"r\"\nfile = \"pkg/urdf/r.urdf\"\n",
                                   folder.scene_path());
    ASSERT_TRUE(scene) << scene.error();
    // a checkout under another name
    folder.write("other/meshes/bin.obj", bin_obj());
    folder.write("other/urdf/r.urdf", urdf(mesh_link("package://gone/meshes/bin.obj")));
    const auto renamed = parse_scene(
        kWorld + "[[robot]]\nname = \"r\"\nfile = \"other/urdf/r.urdf\"\n", folder.scene_path());
    EXPECT_TRUE(renamed) << renamed.error();
}

// --- hostile input

TEST(UrdfErrors, broken_files_name_the_file) {
    expect_error("", kWorld + kRobot, "r.urdf: not a valid URDF");
    expect_error("<robot name=\"r\"><link name=\"a\">", kWorld + kRobot, "r.urdf: ");
    expect_error("no xml at all", kWorld + kRobot, "r.urdf: not a valid URDF");
    expect_error(urdf(""), kWorld + kRobot, "r.urdf: ");
    expect_error(urdf(rod("a") + rod("a")), kWorld + kRobot, "'a' is not unique");
    expect_error(urdf(rod("a") + rod("b")), kWorld + kRobot, "wo root links found");
    expect_error(urdf(rod("a") + joint("j", "revolute", "a", "b", kLimits)), kWorld + kRobot,
                 "[j]");
    expect_error(urdf(rod("a") + rod("b") + joint("j", "revolute", "a", "b")), kWorld + kRobot,
                 "j");
    expect_error(urdf(rod("a") + rod("b") + joint("j", "screw", "a", "b")), kWorld + kRobot,
                 "screw");
}

TEST(UrdfErrors, a_xacro_file_is_told_apart) {
    expect_error("<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\"><xacro:a/></robot>",
                 kWorld + kRobot,
                 "is a xacro file, which has to be expanded into a URDF first: xacro ");
}

TEST(Urdf, a_file_that_xacro_has_expanded_is_a_urdf) {
    const Folder folder;
    const auto scene = scene_of(folder,
                                "<!-- <xacro:include filename='a'/> -->"
                                "<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\">" +
                                    rod("a") + "</robot>",
                                kWorld + kRobot);
    EXPECT_TRUE(scene) << scene.error();
}

TEST(UrdfErrors, damping_and_friction_are_not_negative) {
    for (const char* dynamics : {"<dynamics damping=\"-1\"/>", "<dynamics friction=\"-1\"/>"}) {
        expect_error(
            urdf(rod("a") + rod("b") + joint("j", "revolute", "a", "b", kLimits + dynamics)),
            kWorld + kRobot, "joint \"j\": damping ");
    }
}

TEST(Urdf, the_same_material_twice_is_no_fault) {
    const std::string red = "<material name=\"red\"><color rgba=\"1 0 0 1\"/></material>\n";
    const std::string visual =
        "<visual><geometry><sphere radius=\"0.5\"/></geometry><material name=\"red\"/></visual>";
    for (const std::string& again : {red, std::string("<!-- <material name='red'> -->") + red,
                                     std::string("<material name='red'/>")}) {
        const Folder folder;
        const auto scene = scene_of(
            folder, urdf(red + again + link("a", inertial("1") + kBox + visual)), kWorld + kRobot);
        ASSERT_TRUE(scene) << scene.error();
        ASSERT_EQ(scene->bodies.size(), 1u);
        ASSERT_EQ(scene->bodies[0].drawn.size(), 1u);
        EXPECT_EQ(scene->bodies[0].drawn[0].solid.color->x, 1);
        EXPECT_EQ(scene->bodies[0].drawn[0].solid.color->y, 0);
    }
}

TEST(Urdf, pictures_show_the_visuals_and_else_the_solids) {
    const Folder folder;
    folder.write("shell.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const auto scene = scene_of(
        folder,
        urdf(rod("a") +
             link("b", inertial("1") + kBox +
                           "<visual><origin xyz=\"0 0 2\"/><geometry><mesh "
                           "filename=\"shell.obj\" scale=\"2 2 2\"/></geometry></visual>") +
             link("c", inertial("1") + kBox +
                           "<visual><geometry><mesh filename=\"gone.obj\"/></geometry></visual>") +
             joint("ab", "fixed", "a", "b") + joint("ac", "revolute", "a", "c", kLimits)),
        kWorld + kRobot);
    ASSERT_TRUE(scene) << scene.error();
    ASSERT_EQ(scene->bodies.size(), 2u);
    // Of the links that became one body the first shows its solid, the second its visual.
    const std::vector<DrawnItem>& drawn = scene->bodies[0].drawn;
    ASSERT_EQ(drawn.size(), 2u);
    EXPECT_EQ(drawn[0].solid.shape, "box");
    EXPECT_TRUE(drawn[1].mesh_file.ends_with("shell.obj"));
    EXPECT_EQ(drawn[1].mesh_scale.x, 2);
    EXPECT_NEAR(length(drawn[1].solid.pose.position - Vec3{1, 0, 2}), 0, 1e-12);
    EXPECT_TRUE(scene->bodies[1].drawn.empty());
    ASSERT_EQ(scene->warnings.size(), 1u);
    EXPECT_NE(scene->warnings[0].find("a visual is not drawn: the mesh \"gone.obj\" is not there"),
              std::string::npos)
        << scene->warnings[0];
}

TEST(UrdfErrors, loops_are_refused) {
    const std::string links = rod("a") + rod("b") + rod("c");
    expect_error(urdf(links + joint("ab", "continuous", "a", "b") +
                      joint("bc", "continuous", "b", "c") + joint("ac", "continuous", "a", "c")),
                 kWorld + kRobot, "link \"c\" is the child of the joints \"ac\" and \"bc\"");
    expect_error(
        urdf(links + joint("bc", "continuous", "b", "c") + joint("cb", "continuous", "c", "b")),
        kWorld + kRobot, "do not hang on the root \"a\"");
}

TEST(UrdfErrors, loop_without_a_root_is_refused) {
    expect_error(urdf(rod("a") + rod("b") + rod("c") + joint("ab", "continuous", "a", "b") +
                      joint("bc", "continuous", "b", "c") + joint("ca", "continuous", "c", "a")),
                 kWorld + kRobot, "r.urdf: ");
}

TEST(UrdfErrors, masses_and_inertias_are_those_of_solids) {
    const auto two = [](const std::string& second) {
        return urdf(rod("a") + second + joint("j", "continuous", "a", "b"));
    };
    expect_error(two(rod("b", "0")), kWorld + kRobot,
                 "link \"b\" moves and has no mass: give it one with [[robot.link]]");
    expect_error(two(rod("b", "-3")), kWorld + kRobot, "link \"b\": the mass -3 kg is not within");
    expect_error(two(rod("b", "1e9")), kWorld + kRobot, "link \"b\": the mass");
    expect_error(two(rod("b", "nan")), kWorld + kRobot, "r.urdf: ");
    expect_error(two(link("b", kBox)), kWorld + kRobot, "link \"b\" moves and has no mass");
    expect_error(two(link("b", "")), kWorld + kRobot, "link \"b\" has neither mass nor solid");
    expect_error(two(link("b", inertial("1", "-1") + kBox)), kWorld + kRobot,
                 "link \"b\": its principal moments of inertia are -1, 1 and 1 kg m2: none may be");
    expect_error(two(link("b", inertial("1", "3") + kBox)), kWorld + kRobot,
                 "no solid has one that exceeds the sum of the other two");
}

TEST(UrdfErrors, placeholder_inertia_is_a_warning) {
    const Folder folder;  // 0.03 kg with 1 kg m2 would lie 5.8 m out
    const auto scene = scene_of(folder, urdf(rod("base", "0.03")), kWorld + kRobot);
    ASSERT_TRUE(scene) << scene.error();
    ASSERT_EQ(scene->warnings.size(), 1u);
    EXPECT_NE(scene->warnings[0].find("link \"base\": its inertia is that of 0.03 kg at 5.77 m"),
              std::string::npos)
        << scene->warnings[0];
}

TEST(UrdfErrors, solids_have_sizes) {
    const auto with = [](const std::string& geometry) {
        return urdf(link(
            "a", inertial("1") + "<collision><geometry>" + geometry + "</geometry></collision>"));
    };
    expect_error(with("<box size=\"1 0 1\"/>"), kWorld + kRobot, "link \"a\": the box 1 x 0 x 1 m");
    expect_error(with("<sphere radius=\"-1\"/>"), kWorld + kRobot, "link \"a\": the radius -1 m");
    expect_error(with("<cylinder radius=\"1\" length=\"1e7\"/>"), kWorld + kRobot,
                 "link \"a\": the cylinder");
}

TEST(UrdfErrors, meshes_are_there_and_finite) {
    expect_error(urdf(mesh_link("gone.stl")), kWorld + kRobot,
                 "link \"bin\": the mesh \"gone.stl\" is not there; looked for ");
    expect_error(urdf(mesh_link("package://p/gone.stl")), kWorld + kRobot, "/p/gone.stl, ");
    const Folder folder;
    const auto refused = [&](const std::string& name, const std::string& text,
                             const std::string& scale, const std::string& wanted) {
        folder.write(name, text);
        const auto scene = scene_of(folder, urdf(mesh_link(name, scale)), kWorld + kRobot);
        ASSERT_FALSE(scene) << name;
        EXPECT_NE(scene.error().find(wanted), std::string::npos) << scene.error();
    };
    refused("garbage.stl", "this is no mesh", "1 1 1", "garbage.stl: ");
    refused("garbage.dae", "<xml", "1 1 1", "garbage.dae: ");
    refused("empty.obj", "", "1 1 1", "empty.obj: ");
    refused("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "1 1 1", "its hull has no volume");
    refused("bin.obj", bin_obj(), "1 0 1", "the scale 1 0 1 is no scale");
    refused("bin.obj", bin_obj(), "1e9 1 1", "a vertex lies");
    // a binary STL of four triangles, one of whose vertices is no number
    std::string stl(84 + 4 * 50, '\0');
    const std::uint32_t count = 4;
    std::memcpy(&stl[80], &count, sizeof count);
    for (size_t t = 0; t < 4; ++t) {
        for (size_t v = 0; v < 3; ++v) {
            const float p[3] = {t == v ? 1.0f : 0.0f, v == 1 ? 1.0f : 0.0f,
                                t == 2 && v == 2 ? std::numeric_limits<float>::quiet_NaN() : 0.5f};
            std::memcpy(&stl[84 + t * 50 + 12 + v * 12], p, sizeof p);
        }
    }
    refused("nan.stl", stl, "1 1 1", "is not finite");
}

TEST(UrdfErrors, names_in_the_scene_are_those_of_the_file) {
    const std::string file = urdf(rod("a") + rod("b") + joint("j", "revolute", "a", "b", kLimits));
    expect_error(file, kWorld + kRobot + "[[robot.link]]\nlink = \"c\"\n",
                 "s.toml:9:8: the robot has no link \"c\"; it has a, b");
    expect_error(file, kWorld + kRobot + "[[robot.motor]]\njoint = \"k\"\n",
                 "s.toml:9:9: the robot has no joint \"k\"; it has j");
    expect_error(file, kWorld + kRobot + "[[robot.joint]]\njoint = \"k\"\n",
                 "the robot has no joint \"k\"");
    expect_error(file, kWorld + kRobot + "[[robot.joint]]\njoint = \"j\"\nstart_m = 1\n",
                 "\"j\" does not slide");
    expect_error(file, kWorld + kRobot + "[[robot.joint]]\njoint = \"j\"\nstart_deg = 170\n",
                 "joint \"j\" starts at 2.967, outside of its limits -1 .. 2");
    expect_error(file, kWorld + kRobot + "[[robot.motor]]\njoint = \"j\"\nforce_n = 1\n",
                 "\"j\" turns: `force_n` is not for it");
    expect_error(file,
                 kWorld + kRobot + "[[robot.link]]\nlink = \"a\"\nmoments_kg_m2 = [1, 1, 1]\n",
                 "need `mass_kg`");
    expect_error(
        file,
        kWorld + kRobot + "[[robot.link]]\nlink = \"a\"\nmass_kg = 1\nmoments_kg_m2 = [1, 1, 9]\n",
        "s.toml:11:17: a: its principal moments");
    expect_error(file, kWorld + kRobot + "[[robot.link]]\nlink = \"a\"\nmass_kg = -1\n",
                 "s.toml:10:11: ");
    expect_error(file, kWorld + kRobot + "collision = \"convex\"\n", "s.toml:8:13: ");
}

TEST(UrdfErrors, mimics_have_a_source_and_an_effort) {
    const auto file = [](const std::string& mimic, const std::string& limits) {
        return urdf(rod("a") + rod("b") + rod("c") + joint("j", "revolute", "a", "b", kLimits) +
                    joint("k", "revolute", "a", "c", limits + "<mimic joint=\"" + mimic + "\"/>"));
    };
    expect_error(file("l", kLimits), kWorld + kRobot,
                 "joint \"k\" mimics \"l\", which is not there");
    expect_error(file("k", kLimits), kWorld + kRobot, "joint \"k\" mimics itself");
    expect_error(file("j", "<limit lower=\"-1\" upper=\"2\" effort=\"0\" velocity=\"1\"/>"),
                 kWorld + kRobot, "neither an effort limit nor a [[robot.motor]]");
}

// --- convex parts

TEST(ConvexParts, bin_falls_into_its_plates) {
    TriangleMesh bin;
    const auto corners = [&](double r, double z) {
        for (const auto& [x, y] : {std::pair{-r, -r}, {r, -r}, {r, r}, {-r, r}}) {
            bin.vertices.push_back({x, y, z});
        }
    };
    corners(0.5, 0);
    corners(0.5, 0.6);
    corners(0.4, 0.6);
    corners(0.4, 0.1);
    const auto quad = [&](int a, int b, int c, int d) {
        bin.triangles.push_back({a, b, c});
        bin.triangles.push_back({a, c, d});
    };
    quad(3, 2, 1, 0);
    quad(12, 13, 14, 15);
    for (const int low : {0, 4, 8}) {
        for (int i = 0; i < 4; ++i) {
            const int j = (i + 1) % 4;
            quad(low + i, low + j, low + 4 + j, low + 4 + i);
        }
    }
    EXPECT_NEAR(mesh_volume_m3(bin), kBinSolid, 1e-12);
    const std::vector<ConvexHull> parts = convex_parts(bin, 20);
    double sum_m3 = 0;
    for (const ConvexHull& part : parts) sum_m3 += part.volume_m3;
    EXPECT_NEAR(sum_m3, kBinSolid, 0.03 * kBinSolid);
    // The floor and four walls: of equally good cuts the first is taken, whatever the rounding.
    EXPECT_EQ(parts.size(), 5u);
    EXPECT_LE(convex_parts(bin, 3).size(), 3u);
    EXPECT_TRUE(convex_parts({}, 3).empty());
}

}  // namespace
}  // namespace bsoil::scene
