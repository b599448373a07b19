// What the links of a URDF file become: masses, moments, solids, pictures.
#include <cmath>

#include "robots/convex_parts.h"
#include "urdf_texts.h"

namespace bsoil::scene::urdf_bodies_test {
namespace {

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

TEST(Urdf, a_file_that_xacro_has_expanded_is_a_urdf) {
    const Folder folder;
    const auto scene = scene_of(folder,
                                "<!-- <xacro:include filename='a'/> -->"
                                "<robot name=\"r\" xmlns:xacro=\"http://ros.org/wiki/xacro\">" +
                                    rod("a") + "</robot>",
                                kWorld + kRobot);
    EXPECT_TRUE(scene) << scene.error();
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

// --- meshes

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

}  // namespace
}  // namespace bsoil::scene::urdf_bodies_test
