/// Textures of robots, from their files into the picture; and what is said of those that are not
/// there.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "bsoil/render/renderer.h"
#include "run/scene_models.h"
#include "urdf_texts.h"

namespace bsoil::scene::textures_test {
namespace {

using Rgb = std::array<int, 3>;
constexpr Rgb kRed{200, 60, 40}, kGreen{60, 200, 40}, kBlue{40, 60, 200}, kYellow{220, 200, 40};
constexpr Rgb kPaint{188, 0, 0};  // linear 0.5 0 0 as sRGB
/// Of 255: the picture keeps square roots of colours in 8 bits on its way.
constexpr int kTolerance = 4;

/// A PNG of four fields: blue and yellow above, red and green below.
std::string four_fields() {
    constexpr int kSide = 32;
    render::Image image;
    image.width = image.height = kSide;
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            const bool is_right = 2 * x >= kSide, is_lower = 2 * y >= kSide;
            const Rgb& c = is_lower ? (is_right ? kGreen : kRed) : (is_right ? kYellow : kBlue);
            for (const int v : c) image.rgba.push_back(static_cast<uint8_t>(v));
            image.rgba.push_back(255);
        }
    }
    const std::string path =
        (std::filesystem::temp_directory_path() /
         (std::string("bsoil_fields_") +
          testing::UnitTest::GetInstance()->current_test_info()->name() + ".png"))
            .string();
    EXPECT_TRUE(render::write_png(image, path));
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    std::filesystem::remove(path);
    return bytes;
}

/// A square of 2 m across x that is seen from +x: y to the right, z up.
const std::string kSquare =
    "mtllib m.mtl\nv 0 -1 -1\nv 0 1 -1\nv 0 1 1\nv 0 -1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "usemtl skin\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
std::string mtl(const std::string& name) { return "newmtl skin\nKd 1 1 1\nmap_Kd " + name + "\n"; }

const std::string kSquareDae = R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Z_UP</up_axis></asset>
<library_images><image id="i"><init_from>textures/fields.png</init_from></image></library_images>
<library_effects><effect id="e"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>i</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="c"><lambert><diffuse><texture texture="t" texcoord="UV"/></diffuse></lambert></technique>
</profile_COMMON></effect></library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 -1 -1 0 1 -1 0 1 1 0 -1 1</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="u"><float_array id="ua" count="8">0 0 1 0 1 1 0 1</float_array><technique_common>
<accessor source="#ua" count="4" stride="2"><param name="S" type="float"/><param name="T" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="2" material="mat"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#u" offset="1" set="0"/><p>0 0 1 1 2 2 0 0 2 2 3 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node id="n"><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="mat" target="#m"/></technique_common></bind_material>
</instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>)";

class Textures : public testing::Test {
  protected:
    void SetUp() override {
        auto created = render::Renderer::create();
        if (!created) GTEST_SKIP() << created.error();
        renderer_ = std::move(*created);
    }
    /// A picture of a robot with this visual, in its own colours whatever the light.
    render::Image shown(const std::string& visual, const std::string& keys = "") {
        notes_.clear();
        warnings_.clear();
        const auto scene = parse_scene_of(visual, keys);
        EXPECT_TRUE(scene) << scene.error();
        if (!scene) return {};
        warnings_ = scene->warnings;
        const auto meshes = add_body_meshes(*scene, *renderer_, notes_);
        render::View view;
        view.width = 320;
        view.height = 200;
        view.camera = {{10, 0, 0}, {}, {0, 0, 1}, 2 * std::atan(100.0 / 80 / 10)};
        render::Item item;
        item.mesh = meshes.at(0);
        item.emission = 1;
        view.items = {item};
        auto image = renderer_->render(view);
        EXPECT_TRUE(image) << image.error();
        return image ? *image : render::Image{};
    }
    static void expect_color(const render::Image& image, int x, int y, const Rgb& expected) {
        ASSERT_EQ(image.width, 320);
        const uint8_t* found = image.pixel(x, y);
        for (size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(found[c], expected[c], kTolerance)
                << "channel " << c << " at " << x << ", " << y;
        }
    }
    static void expect_four_fields(const render::Image& image) {
        expect_color(image, 120, 140, kRed);
        expect_color(image, 200, 140, kGreen);
        expect_color(image, 120, 60, kBlue);
        expect_color(image, 200, 60, kYellow);
    }
    /// The robot's red paint, and one line that says why.
    void expect_paint(const render::Image& image, const std::string& why) {
        expect_color(image, 120, 140, kPaint);
        expect_color(image, 200, 60, kPaint);
        std::vector<std::string> lines = notes_;
        lines.insert(lines.end(), warnings_.begin(), warnings_.end());
        ASSERT_EQ(lines.size(), 1u) << (lines.empty() ? "" : lines[0] + "\n" + lines.back());
        EXPECT_NE(lines[0].find(why), std::string::npos) << lines[0];
        EXPECT_EQ(lines[0].find('\n'), std::string::npos) << lines[0];
    }

    const Folder folder_;
    std::unique_ptr<render::Renderer> renderer_;
    std::vector<std::string> notes_, warnings_;

  private:
    Result<Scene> parse_scene_of(const std::string& visual, const std::string& keys) const {
        folder_.write("r.urdf", urdf(link("a", inertial("1") + kBox + visual)));
        return parse_scene(kWorld + kRobot + keys, folder_.scene_path());
    }
};

std::string visual(const std::string& geometry, const std::string& material = "") {
    return "<visual><geometry>" + geometry + "</geometry>" +
           (material.empty() ? "" : "<material name=\"m\">" + material + "</material>") +
           "</visual>";
}
std::string mesh(const std::string& file) { return "<mesh filename=\"" + file + "\"/>"; }
const std::string kPaintTag = "<color rgba=\"0.7297 0 0 1\"/>";  // 0.5 linear, by a gamma of 2.2

TEST_F(Textures, that_mesh_files_name_are_drawn) {
    folder_.write("meshes/m.obj", kSquare);
    folder_.write("meshes/m.dae", kSquareDae);
    folder_.write("meshes/textures/fields.png", four_fields());
    for (const char* name : {"textures/fields.png", "textures\\fields.png"}) {
        folder_.write("meshes/m.mtl", mtl(name));
        expect_four_fields(shown(visual(mesh("meshes/m.obj"))));
        EXPECT_TRUE(notes_.empty()) << notes_[0];
    }
    expect_four_fields(shown(visual(mesh("meshes/m.dae"))));
    EXPECT_TRUE(notes_.empty()) << notes_[0];
    // The robot's colour, and the scene's, take their place.
    const auto painted = shown(visual(mesh("meshes/m.dae"), kPaintTag));
    expect_color(painted, 120, 140, kPaint);
    const auto repainted =
        shown(visual(mesh("meshes/m.dae")), "[[robot.link]]\nlink = \"a\"\ncolor = [0.5, 0, 0]\n");
    expect_color(repainted, 120, 140, kPaint);
}

TEST_F(Textures, of_a_urdf_lie_on_meshes_and_solids) {
    folder_.write("m.obj", kSquare);
    folder_.write("m.mtl", mtl("other.png"));
    folder_.write("fields.png", four_fields());
    const std::string texture = "<texture filename=\"fields.png\"/>";
    expect_four_fields(shown(visual(mesh("m.obj"), texture)));
    expect_four_fields(shown(visual(mesh("m.obj"), kPaintTag + texture)));
    expect_four_fields(shown(visual("<box size=\"2 2 2\"/>", texture)));
    EXPECT_TRUE(notes_.empty() && warnings_.empty());
    // Round it once, its left and right edges meet at +x, in front of the camera.
    const auto round = shown(visual("<cylinder radius=\"1\" length=\"2\"/>", texture));
    expect_color(round, 130, 140, kGreen);
    expect_color(round, 190, 60, kBlue);
}

TEST_F(Textures, that_are_missing_or_damaged_leave_the_colour_and_a_line) {
    folder_.write("m.obj", kSquare);
    folder_.write("m.mtl", mtl("gone.png"));
    const auto with = [](const std::string& file) {
        return visual(mesh("m.obj"), kPaintTag + "<texture filename=\"" + file + "\"/>");
    };
    expect_paint(shown(with("lost.png")), "the texture \"lost.png\" is not there; looked for");
    folder_.write("cut.png", four_fields().substr(0, 60));
    expect_paint(shown(with("cut.png")), "cut.png: ");
    folder_.write("empty.png", "");
    expect_paint(shown(with("empty.png")), "empty.png: is no PNG");
    folder_.write("photo.jpg", "\xff\xd8\xff\xe0 JFIF");
    expect_paint(shown(with("photo.jpg")), "photo.jpg: is no PNG");
    folder_.write("bare.obj", "v 0 -1 -1\nv 0 1 -1\nv 0 1 1\nv 0 -1 1\nf 1 2 3\nf 1 3 4\n");
    folder_.write("fields.png", four_fields());
    expect_paint(shown(visual(mesh("bare.obj"), kPaintTag + "<texture filename=\"fields.png\"/>")),
                 "bare.obj: has no places for the texture");

    // Named by the mesh: the body's own colour is left.
    const auto image = shown(visual(mesh("m.obj")));
    ASSERT_EQ(notes_.size(), 1u);
    EXPECT_NE(notes_[0].find("m.obj: the texture \"gone.png\" is not there"), std::string::npos)
        << notes_[0];
    ASSERT_EQ(image.width, 320);
    const uint8_t* grey = image.pixel(120, 140);
    EXPECT_NEAR(grey[0], grey[2], kTolerance);
    EXPECT_GT(grey[0], 100);
}

TEST(SceneCamera, that_looks_straight_down_has_north_on_top) {
    for (const std::string up : {"z", "y"}) {
        SCOPED_TRACE(up);
        Scene scene;
        scene.world.up = up;
        scene.camera.eye_m = up == "y" ? Vec3{1, 9, -2} : Vec3{1, 2, 9};
        scene.camera.target_m = up == "y" ? Vec3{1, 0, -2} : Vec3{1, 2, 0};
        const render::Camera camera = scene_camera(scene);
        const Vec3 sight = camera.target - camera.eye;
        const Vec3 north = up == "y" ? Vec3{0, 0, -1} : Vec3{0, 1, 0};
        EXPECT_NEAR(dot(sight, camera.up), -9, 1e-4);
        EXPECT_NEAR(dot(sight, north), 9e-3, 1e-6);
        EXPECT_NEAR(length(cross(sight, camera.up)), 9e-3, 1e-6);  // not in one line
    }
}

}  // namespace
}  // namespace bsoil::scene::textures_test
