// URDF files that cannot be: what is wrong with them, and where.
#include <cstring>
#include <limits>

#include "urdf_texts.h"

namespace bsoil::scene::urdf_errors_test {
namespace {

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
                 "is a xacro file, which must be expanded into a URDF first: xacro ");
}

TEST(UrdfErrors, damping_and_friction_are_not_negative) {
    for (const char* dynamics : {"<dynamics damping=\"-1\"/>", "<dynamics friction=\"-1\"/>"}) {
        expect_error(
            urdf(rod("a") + rod("b") + joint("j", "revolute", "a", "b", kLimits + dynamics)),
            kWorld + kRobot, "joint \"j\": damping ");
    }
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
                 "link \"b\" moves and has no mass; give it one with [[robot.link]]");
    expect_error(two(rod("b", "-3")), kWorld + kRobot, "link \"b\": the mass -3 kg must be 0");
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
    refused("bin.obj", bin_obj(), "1 0 1", "the scale 1 0 1 must be finite and not 0");
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
    refused("nan.stl", stl, "1 1 1", "must be finite");
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

// A rigid body's constraint cannot hold a link, and was left out or was one of another kind.
TEST(UrdfErrors, links_of_a_multibody_have_no_joints_of_the_scene) {
    const std::string robot = urdf(rod("a") + rod("b") + joint("j", "revolute", "a", "b", kLimits));
    const std::string box =
        "[[body]]\nname = \"box\"\nshape = \"box\"\nsize_m = [1, 1, 1]\nmass_kg = 1\nposition_m = "
        "[0, 0, 3]\n";
    const auto joined = [](const std::string& parent, const std::string& child) {
        return "[[joint]]\nname = \"own\"\nkind = \"fixed\"\nparent = \"" + parent +
               "\"\nchild = \"" + child + "\"\npoint_m = [0, 0, 0]\n";
    };
    for (const auto& [parent, child] :
         {std::pair{"r/a", "box"}, {"box", "r/b"}, {"world", "r/a"}}) {
        const std::string link = std::string(parent).starts_with("r/") ? parent : child;
        expect_error(robot,
                     kWorld + kRobot + "build = \"multibody\"\n" + box + joined(parent, child),
                     "\"" + link + "\" is a link of a multibody, which a [[joint]] cannot hold");
    }
}
}  // namespace
}  // namespace bsoil::scene::urdf_errors_test
