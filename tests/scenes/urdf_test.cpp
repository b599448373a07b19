// Robots out of URDF files as machines: joints, motors and limits, as rigid bodies and as a
// multibody.
#include <cmath>

#include "scene/rotations.h"
#include "urdf_texts.h"

namespace bsoil::scene::urdf_test {
namespace {

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

}  // namespace
}  // namespace bsoil::scene::urdf_test
