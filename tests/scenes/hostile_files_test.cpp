/// Small files that stand for far more than they hold: each gets an error that says what to change,
/// in a time and a memory that go with its bytes.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "files/data_files.h"
#include "files/text_file.h"
#include "reading/scene_load.h"
#include "robots/urdf_file.h"
#include "run/baseline.h"

namespace bsoil::scene::hostile_files_test {
namespace {

namespace fs = std::filesystem;

class HostileFiles : public testing::Test {
  protected:
    void SetUp() override {
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string write(const std::string& name, const std::string& bytes) const {
        const std::string path = (folder_ / name).string();
        std::ofstream(path, std::ios::binary) << bytes;
        return path;
    }
    static void expect_error(const std::string& found, const std::string& expected) {
        EXPECT_NE(found.find(expected), std::string::npos)
            << "expected: " << expected << "\nfound:    " << found.substr(0, 1000);
    }
    void expect_scene_error(const std::string& text, const std::string& expected) const {
        const auto scene = parse_scene(text, (folder_ / "s.toml").string());
        expect_error(scene ? "no error" : scene.error(), expected);
    }

    const fs::path folder_ =
        fs::temp_directory_path() / (std::string("bsoil_hostile_") +
                                     testing::UnitTest::GetInstance()->current_test_info()->name());
};

std::string repeated(const std::string& text, int count) {
    std::string out;
    for (int i = 0; i < count; ++i) out += text;
    return out;
}

const std::string kWorld = "[world]\nduration_s = 1.0\n";  // lines 1 and 2

TEST_F(HostileFiles, keys_of_many_parts_are_refused_with_their_place) {
    const std::string expected = "s.toml:3:32: a key has more than 16 parts with dots between them";
    expect_scene_error(kWorld + repeated("a.", 131'000) + "a = 1\n", expected);
    expect_scene_error(kWorld + repeated("a.", 16) + "a = 1\n", expected);
    expect_scene_error(kWorld + repeated("a.", 15) + "a = 1\n", "unknown key `a`");
    expect_scene_error(kWorld + "[" + repeated("a.", 100'000) + "a]\n", "more than 16 parts");
    expect_scene_error(kWorld + "[[" + repeated("a . ", 100'000) + "a]]\n", "more than 16 parts");
    expect_scene_error(kWorld + "x = {y = {" + repeated("\"a\".'b'.", 50'000) + "a = 1}}\n",
                       "more than 16 parts");
    expect_scene_error(kWorld + "x = \"\\\"\"\n" + repeated("a.", 100'000) + "a = 1\n",
                       "more than 16 parts");
    expect_scene_error(
        kWorld + "x = \"\"\"\n\\\"\"\" \"\"\"\"\"\n" + repeated("a.", 100'000) + "a = 1\n",
        "more than 16 parts");
}

TEST_F(HostileFiles, dots_that_are_no_part_of_a_key_are_not_counted) {
    const std::string dots = repeated("a.", 1000);
    for (const std::string& text :
         {"title = \"" + dots + "\"\n" + kWorld, "title = '" + dots + "'\n" + kWorld,
          "title = \"\"\"\n" + dots + "\n\"quoted\" \\\"\"\" end\"\"\"\"\n" + kWorld,
          "title = '''\n" + dots + "'' \n'''\n" + kWorld, kWorld + "# " + dots + "\n",
          kWorld + "[record]\nmoments_s = [" + repeated("0.5, ", 1000) + "]\n"}) {
        const auto scene = parse_scene(text, "s.toml");
        EXPECT_TRUE(scene) << scene.error();
    }
}

TEST_F(HostileFiles, what_toml_takes_for_granted_is_an_error_with_its_place) {
    for (const char* text :
         {"[[=a]]", "[^a]", "[[ .a]]", "x = 1979-05-27T\x01", "x = [0.2,} 0.3]"}) {
        expect_scene_error("title = 'a'\n" + std::string(text) + "\n", "s.toml:2:");
    }
}

// toml++ has undefined behaviour where it asks whether such a character is a blank.
TEST_F(HostileFiles, characters_beyond_ascii_belong_in_quotes_and_comments) {
    const std::string umlaut = "\xc3\xa4";
    for (const std::string& text :
         {umlaut, "x = " + umlaut, "x = 1" + umlaut, "x = [1 " + umlaut + "]", "[" + umlaut + "]",
          "x" + umlaut + " = 1"}) {
        expect_scene_error("# a\n" + text, "characters beyond ASCII must be in quotes");
    }
    for (const char* start : {"x = \"\"\"a\\\n", "x = \"\"\"\\ \n \r\n\t", "x = \"\"\"\\"}) {
        expect_scene_error(start + umlaut + "\"\"\"\n", "must be written as \\uXXXX");
    }
    for (const std::string& text :
         {"title = \"" + umlaut + "\"\n", "title = '" + umlaut + "'\n",
          "title = \"\"\"\n" + umlaut + " \\\n a\\n" + umlaut + "\"\"\"\n",
          "\xef\xbb\xbf# " + umlaut + "\n"}) {
        const auto scene = parse_scene(text + kWorld, "s.toml");
        EXPECT_TRUE(scene) << scene.error();
    }
}

TEST_F(HostileFiles, values_inside_each_other_are_refused) {
    for (const int depth : {1000, 100'000}) {
        expect_scene_error(kWorld + "x = " + repeated("[", depth) + "\n", "s.toml:3:");
        expect_scene_error(kWorld + "x = " + repeated("{a = ", depth) + "\n", "s.toml:3:");
        expect_scene_error(kWorld + "x = " + repeated("[{a.b.c = ", depth) + "\n", "s.toml:3:");
    }
}

TEST_F(HostileFiles, endless_and_huge_files_are_refused) {
    for (const char* file : {"/dev/zero", "/", "/nonexistent"}) {
        EXPECT_FALSE(load_scene(file));
        EXPECT_FALSE(read_urdf(file));
        EXPECT_FALSE(read_mesh(file));
    }
    expect_error(load_scene(write("s.toml", repeated("#\n", 5 << 20))).error(),
                 "must be at most 8 MiB");
}

TEST_F(HostileFiles, optenv_is_replaced_however_long_its_default) {
    const std::string robot =
        "<robot name=\"r\"><link name=\"$(optenv A b)\"/><link name=\"c\"/>"
        "<joint name=\"j\" type=\"fixed\"><parent link=\"$(optenv  B_2\tb)\"/>"
        "<child link=\"c\"/></joint></robot>";
    const auto model = read_urdf(write("r.urdf", robot));
    ASSERT_TRUE(model) << model.error();
    // Its end is far away, or not there at all.
    for (const std::string& end : {std::string(")-->"), std::string("-->")}) {
        const auto far =
            read_urdf(write("r.urdf", "<!--$(optenv A " + std::string(1 << 20, 'x') + end +
                                          "<robot name=\"r\"><link name=\"b\"/></robot>"));
        EXPECT_TRUE(far) << far.error().substr(0, 1000);
    }
    EXPECT_FALSE(read_urdf(write("r.urdf", repeated("$(optenv A ", 1 << 20))));
    EXPECT_FALSE(read_urdf(write("r.urdf", repeated("$(optenv A )", 1 << 20))));
    EXPECT_FALSE(read_urdf(write("r.urdf", "$(optenv" + std::string(1 << 20, ' '))));
}

TEST_F(HostileFiles, elements_inside_each_other_are_refused) {
    const auto nested = [](int depth) {
        return "<robot name=\"r\"><link name=\"a\"/>" + repeated("<b c=\"/>\">", depth) +
               repeated("</b>", depth) + "</robot>";
    };
    EXPECT_TRUE(read_urdf(write("r.urdf", nested(99))));
    expect_error(read_urdf(write("r.urdf", nested(100))).error(),
                 "elements must lie at most 100 deep inside each other");
    expect_error(read_urdf(write("r.urdf", repeated("<b>", 1 << 20))).error(), "at most 100 deep");
    // What looks like an end and is none.
    expect_error(
        read_urdf(write("r.urdf", "<!-- </b></b> --><robot name=\"r\">" +
                                      repeated("<b c='</b>'><!--</b>--><![CDATA[</b>]]>", 10'000)))
            .error(),
        "at most 100 deep");
    // What is a comment's end once a default has taken the place of its $(optenv).
    expect_error(
        read_urdf(write("r.urdf", "<!-- $(optenv A --)>" + repeated("<b>", 10'000))).error(),
        "at most 100 deep");
    expect_error(
        read_mesh(write("m.dae", "<COLLADA version=\"1.4.1\">" + repeated("<node>", 100'000)))
            .error(),
        "at most 100 deep");
}

/// A COLLADA file of one triangle and these nodes, the first of which is shown.
std::string collada(const std::string& nodes) {
    return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">)" +
           nodes +
           R"(</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

TEST_F(HostileFiles, nodes_that_stand_for_billions_are_refused) {
    const std::string leaf = "<node id=\"n0\"><instance_geometry url=\"#g\"/></node>";
    const auto doubled = [&](int levels) {
        std::string nodes = leaf;
        for (int i = 1; i <= levels; ++i) {
            const std::string twice = "<instance_node url=\"#n" + std::to_string(i - 1) + "\"/>";
            nodes += "<node id=\"n" + std::to_string(i) + "\">" + twice + twice + "</node>";
        }
        return collada(nodes);
    };
    const auto few = read_mesh(write("m.dae", doubled(3)));
    ASSERT_TRUE(few) << few.error();
    EXPECT_EQ(few->triangles.size(), 1u + 2 + 4 + 8);
    expect_error(read_mesh(write("m.dae", doubled(40))).error(), "write the nodes out");
    const std::string loop =
        "<node id=\"a\"><instance_node url=\"#b\"/></node>"
        "<node id=\"b\"><instance_node url=\"#a\"/></node>";
    expect_error(read_mesh(write("m.dae", collada(loop))).error(), "for themselves");
}

// Parsers do not agree where such a declaration ends, and so on what is a comment.
TEST_F(HostileFiles, declarations_whose_end_is_not_clear_are_refused) {
    const std::string wanted = "leave it out";
    for (const std::string start :
         {"<?x > <!-- ?>", "<?x '>' ?>", "<?x", "<!DOCTYPE a \"> <!-- \">",
          "<!DOCTYPE a [ <!ENTITY b \">\"> <!-- ]>", "<!DOCTYPE a '> <![CDATA[ '>"}) {
        SCOPED_TRACE(start);
        expect_error(read_mesh(write("m.dae", start + "<COLLADA/>")).error(), wanted);
        expect_error(read_urdf(write("r.urdf", start + "<robot name=\"r\"/>")).error(), wanted);
    }
    EXPECT_TRUE(read_urdf(write("r.urdf",
                                "<?xml version='1.0'?><!DOCTYPE robot SYSTEM \"r.dtd\">"
                                "<robot name=\"r\"><link name=\"a\"/></robot>")));
}

TEST_F(HostileFiles, meshes_are_of_the_three_formats) {
    expect_error(read_mesh(write("m.x", "xof 0303txt 0032\n")).error(),
                 "must end in .obj, .stl or .dae");
    EXPECT_FALSE(read_mesh(write("m.obj", collada(""))));
}

/// A PNG of so many grey pixels, with `data` for its pixels; the checks of its parts are not read.
std::string png(uint32_t width, uint32_t height, const std::string& data) {
    const auto big_endian = [](uint32_t v) {
        std::string bytes;
        for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(v >> shift & 255);
        return bytes;
    };
    const auto part = [&](const std::string& name, const std::string& content) {
        return big_endian(static_cast<uint32_t>(content.size())) + name + content + big_endian(0);
    };
    return std::string("\x89PNG\r\n\x1a\n", 8) +
           part("IHDR", big_endian(width) + big_endian(height) + std::string("\x08\0\0\0\0", 5)) +
           part("IDAT", data) + part("IEND", "");
}

TEST_F(HostileFiles, pictures_of_too_many_pixels_are_refused_before_they_are_read) {
    const std::array<std::array<uint32_t, 2>, 4> sizes{
        {{32767, 32767}, {8194, 8193}, {40000, 10}, {16'777'215, 2}}};
    for (const auto& [width, height] : sizes) {
        const auto map = read_height_map(write("m.png", png(width, height, "x")), 0, 1);
        const std::string size = std::to_string(width) + " x " + std::to_string(height);
        expect_error(map.error(),
                     size + " pixels; a side may have 32768, both together 8193 x 8193");
    }
    EXPECT_FALSE(read_height_map(write("m.png", png(100, 100, "x")), 0, 1));
}

TEST_F(HostileFiles, textures_of_too_many_pixels_and_damaged_ones_are_refused) {
    for (const auto& [width, height] : {std::array{4097u, 1u}, {1u, 4097u}, {16'777'215u, 9u}}) {
        expect_error(read_texture(write("t.png", png(width, height, "x"))).error(),
                     std::to_string(width) + " x " + std::to_string(height) +
                         " pixels; a side of a texture must have at most 4096");
    }
    EXPECT_FALSE(read_texture(write("t.png", png(4096, 4096, "x"))));
    EXPECT_FALSE(read_texture(write("t.png", png(0, 7, "x"))));
    expect_error(read_texture(write("t.png", png(3, 3, ""))).error(), "without data");
    expect_error(read_texture(write("t.png", "\xff\xd8\xff")).error(), "is no PNG");
    for (const char* file : {"/dev/zero", "/", "/nonexistent"}) EXPECT_FALSE(read_texture(file));
}

TEST_F(HostileFiles, skins_of_meshes_have_a_place_for_each_vertex) {
    // No place, one that is no number, and a texture that no material has.
    const std::string square = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt nan 1e39\n";
    write("m.mtl", "newmtl a\nmap_Kd " + std::string(5000, 'x') + "\nnewmtl b\nmap_Kd\n");
    for (const char* faces :
         {"usemtl a\nf 1/1 2/2 3/2\nusemtl b\nf 1/1 2/2 3/1\nusemtl c\nf 1 2 3\n", "f 1 2 3\n"}) {
        MeshSkin skin;
        const auto mesh = read_mesh(write("m.obj", square + faces), &skin);
        ASSERT_TRUE(mesh) << mesh.error();
        EXPECT_EQ(skin.places.size(), mesh->vertices.size());
        ASSERT_EQ(skin.textures.size(), mesh->triangles.size());
        for (const int t : skin.textures) EXPECT_LT(t, static_cast<int>(skin.names.size()));
        for (const auto& [u, v] : skin.places) EXPECT_TRUE(std::isfinite(u) && std::isfinite(v));
    }
}

TEST_F(HostileFiles, height_maps_of_any_bytes_and_none_are_refused) {
    for (const char* text : {"", "x", "\x89PNG\r\n\x1a\n", "\xff\xd8\xff"}) {
        EXPECT_FALSE(read_height_map(write("m.png", text), 0, 1)) << text;
    }
    for (const char* file : {"/dev/zero", "/", "/nonexistent"}) {
        EXPECT_FALSE(read_height_map(file, 0, 1)) << file;
    }
}

// A chunk is longer than its file, and what its reader then goes on with is another without data.
TEST_F(HostileFiles, pictures_that_end_within_a_chunk_are_refused) {
    const std::string whole = png(3, 3, "x");
    const size_t pixels = whole.find("IDAT");
    const std::string long_one =
        "\xad\xad\xad\xad"
        "tEXt" +
        std::string(80, '\xad');
    const std::string before = whole.substr(0, pixels - 4);
    for (const std::string& bytes :
         {whole.substr(0, pixels + 4), whole.substr(0, whole.size() - 12),
          before + long_one + png(3, 3, "").substr(before.size())}) {
        for (const std::string& error : {read_height_map(write("m.png", bytes), 0, 1).error(),
                                         read_texture(write("m.png", bytes)).error()}) {
            expect_error(error, "ends before its last chunk does");
        }
    }
}

TEST_F(HostileFiles, pictures_with_an_empty_chunk_are_refused) {
    expect_error(read_height_map(write("m.png", png(3, 3, "")), 0, 1).error(),
                 "without data; save the picture anew");
}

TEST_F(HostileFiles, baselines_are_json_of_a_few_levels) {
    expect_error(read_baseline(write("b.json", repeated("[", 1 << 20))).error(), "at most 16 deep");
    expect_error(read_baseline(write("b.json", "{\"end\": " + repeated("{\"a\": ", 17))).error(),
                 "at most 16 deep");
    for (const char* text : {"", "{", "[]", "7", "\"steps\"", "{\"steps\": \"many\"}",
                             "{\"steps\": -1}", "{\"steps\": 1e300}", "{\"steps\": [1]}"}) {
        EXPECT_FALSE(read_baseline(write("b.json", text))) << text;
    }
    EXPECT_TRUE(read_baseline(write("b.json", "{\"steps\": 20, \"end\": {}}")));
    EXPECT_FALSE(read_baseline((folder_ / "missing").string()));
}

std::string soil(const std::string& size_m, const std::string& voxel_m) {
    return "[soil]\nsize_m = " + size_m + "\nvoxel_m = " + voxel_m + "\n";  // lines 3 to 5
}

TEST_F(HostileFiles, grids_of_too_many_columns_name_the_cure) {
    expect_scene_error(kWorld + soil("[9999, 9999, 512]", "1"),
                       "s.toml:3:1: size_m / voxel_m is 9999 x 9999 columns, 1e+08 together; must "
                       "be at most 6.71e+07: take larger voxels or a smaller box");
}

TEST_F(HostileFiles, terrain_of_too_much_noise_names_the_cure) {
    const std::string rough = "amplitude_m = 100\noctaves = 12\noverhang_m = 1\n";
    expect_scene_error(
        kWorld + soil("[2000, 2000, 50]", "1") + "[[terrain]]\nkind = \"hills\"\n" + rough,
        "s.toml:6:1: its noise would be computed");
    expect_scene_error(kWorld + soil("[2000, 2000, 50]", "1") + "[[terrain]]\nkind = \"caves\"\n",
                       "s.toml:6:1: its noise would be computed");
    // Level enough for its size.
    const auto level = parse_scene(kWorld + soil("[2000, 2000, 50]", "1") +
                                       "[[terrain]]\nkind = \"hills\"\namplitude_m = 0.5\n",
                                   "s.toml");
    EXPECT_TRUE(level) << level.error();
}

// A page whose prose was written by hand, on a disk that is full; and by a link to it.
TEST_F(HostileFiles, page_that_cannot_be_replaced_stays_as_it_was) {
    const std::string page = write("page.md", "prose");
    const fs::path part = page + ".part";
    fs::create_symlink("/dev/full", part);
    const Status full = replace_file(page, "tables");
    ASSERT_FALSE(full);
    expect_error(full.error(), "look whether the disk is full");
    EXPECT_EQ(*read_file(page, 100), "prose");
    EXPECT_FALSE(fs::is_symlink(part));
    const std::string link = (folder_ / "link.md").string();
    fs::create_symlink(page, link);
    EXPECT_TRUE(replace_file(link, "tables"));
    EXPECT_EQ(*read_file(page, 100), "tables");
    EXPECT_TRUE(fs::is_symlink(link));
    EXPECT_FALSE(replace_file((folder_ / "no_folder" / "page.md").string(), "tables"));
}

}  // namespace
}  // namespace bsoil::scene::hostile_files_test
