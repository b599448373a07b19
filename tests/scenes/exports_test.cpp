/// Moments of a scene as files, opened by programs that we did not write.
#include "run/exports.h"

#include <assimp/scene.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "bsoil/render/image.h"
#include "files/data_files.h"
#include "reading/scene_load.h"

namespace bsoil::scene::exports_test {
namespace {

namespace fs = std::filesystem;

constexpr double kBedM = 0.45, kSideM = 2.0;

/// Of this process alone: tests of one program run side by side.
fs::path folder() {
    return fs::temp_directory_path() / ("bsoil_exports_" + std::to_string(getpid()));
}

std::string path_of(const std::string& name) {
    fs::create_directories(folder());
    return (folder() / name).string();
}

/// Moist sand under a ball that stands in it; the ball is painted red.
class Exports : public testing::Test {
  public:
    ~Exports() override { fs::remove_all(folder()); }

  protected:
    void open(const std::string& up) {
        auto parsed = parse_scene(
            "[world]\nduration_s = 1\n"
            "[soil]\nsize_m = [2.0, 2.0, 1.2]\nvoxel_m = 0.05\nmaterial = \"moist_sand\"\n"
            "[[fill]]\nkind = \"box\"\nmin_m = [-1, -1, 0]\nmax_m = [1, 1, 0.45]\n"
            "[[fill]]\nkind = \"box\"\nmin_m = [0.2, -1, 0.45]\nmax_m = [1, 1, 0.6]\n"
            "[[body]]\nname = \"ball\"\nshape = \"sphere\"\nradius_m = 0.2\nmass_kg = 60\n"
            "position_m = [-0.5, 0.3, 0.65]\ncolor = [1, 0, 0]\n",
            "s.toml");
        ASSERT_TRUE(parsed) << parsed.error();
        scene_ = std::move(*parsed);
        set_up_axis(scene_, up == "y" ? UpAxis::y : UpAxis::z);
        auto made = SceneRun::create(scene_, {.backend = Backend::cpu});
        ASSERT_TRUE(made) << made.error();
        run_ = std::move(*made);
        for (int s = 0; s < 20; ++s) run_->step();
    }
    std::string exported(const std::string& name) {
        const std::string path = path_of(name);
        const auto written = export_run(*run_, path);
        EXPECT_TRUE(written) << written.error();
        said_ = written ? *written : "";
        return path;
    }

    Scene scene_;
    std::unique_ptr<SceneRun> run_;
    std::string said_;
};

/// Volume inside the triangles of a mesh (divergence theorem) [m3].
double volume_of(const aiMesh& mesh) {
    double six = 0;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        const auto at = [&](unsigned corner) {
            const aiVector3D& v = mesh.mVertices[mesh.mFaces[f].mIndices[corner]];
            return Vec3{v.x, v.y, v.z};
        };
        six += dot(at(0), cross(at(1), at(2)));
    }
    return six / 6;
}

double soil_volume_m3(const Soil& soil) {
    double voxels = 0;
    const int* size = soil.frame().size;
    for (int z = 0; z < size[2]; ++z) {
        for (int y = 0; y < size[1]; ++y) {
            for (int x = 0; x < size[0]; ++x) voxels += soil.sample(x, y, z).volume;
        }
    }
    return voxels * std::pow(soil.frame().voxel_m, 3);
}

TEST_F(Exports, assimp_reads_the_gltf_with_nodes_places_and_colours) {
    for (const std::string up : {"z", "y"}) {
        SCOPED_TRACE(up);
        open(up);
        Assimp::Importer importer;
        const aiScene* read = importer.ReadFile(exported("moment.glb"), 0);
        ASSERT_NE(read, nullptr) << importer.GetErrorString();
        ASSERT_EQ(read->mNumMeshes, 2u);
        const aiNode* soil = read->mRootNode->FindNode("soil");
        const aiNode* ball = read->mRootNode->FindNode("ball");
        ASSERT_TRUE(soil && ball);
        const aiMesh& soil_mesh = *read->mMeshes[soil->mMeshes[0]];
        EXPECT_TRUE(soil_mesh.HasVertexColors(0));
        EXPECT_TRUE(soil_mesh.HasNormals());
        // The mesh is closed: what it holds is the soil, to a hundredth.
        const double soil_m3 = soil_volume_m3(run_->soil());
        EXPECT_NEAR(volume_of(soil_mesh), soil_m3, 0.01 * soil_m3);
        // glTF's y is up: the ball is where it is in the world, turned so where z was up.
        aiMatrix4x4 place;
        for (const aiNode* node = ball; node; node = node->mParent) {
            place = node->mTransformation * place;
        }
        const Vec3 at = run_->bullet().find_body("ball")->pose().position;
        EXPECT_NEAR(static_cast<double>(place.b4), up == "z" ? at.z : at.y, 1e-5);
        EXPECT_NEAR(static_cast<double>(place.a4), at.x, 1e-5);
        const aiColor4D& red = read->mMeshes[ball->mMeshes[0]]->mColors[0][0];
        EXPECT_EQ(red.r, 1);
        EXPECT_EQ(red.g, 0);
    }
}

TEST_F(Exports, the_gltf_of_nothing_has_no_empty_lists) {
    auto parsed = parse_scene(
        "[world]\nduration_s = 1\n[soil]\nsize_m = [0.8, 0.8, 0.4]\nvoxel_m = 0.1\n", "s.toml");
    ASSERT_TRUE(parsed) << parsed.error();
    scene_ = std::move(*parsed);
    auto made = SceneRun::create(scene_, {.backend = Backend::cpu});
    ASSERT_TRUE(made) << made.error();
    run_ = std::move(*made);
    std::ifstream file(exported("nothing.glb"), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(bytes.find("[]"), std::string::npos) << bytes;
    EXPECT_EQ(bytes.find("byteLength"), std::string::npos) << bytes;
    EXPECT_NE(bytes.find("\"world\""), std::string::npos) << bytes;
    uint32_t length = 0;
    ASSERT_GE(bytes.size(), 12u);
    std::memcpy(&length, bytes.data() + 8, 4);
    EXPECT_EQ(length, bytes.size());
}

TEST_F(Exports, textures_are_in_the_gltf) {
    // A square with a texture, and a box of one colour beside it.
    std::ofstream(path_of("square.obj"))
        << "mtllib square.mtl\nv 0 -1 -1\nv 0 1 -1\nv 0 1 1\nv 0 -1 1\nvt 0 0\nvt 1 0\nvt 1 1\n"
           "vt 0 1\nusemtl skin\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    std::ofstream(path_of("square.mtl")) << "newmtl skin\nKd 1 1 1\nmap_Kd fields.png\n";
    render::Image image;
    image.width = image.height = 8;
    for (int pixel = 0; pixel < 64; ++pixel) {
        image.rgba.insert(image.rgba.end(), {static_cast<uint8_t>(4 * pixel), 60, 40, 255});
    }
    ASSERT_TRUE(render::write_png(image, path_of("fields.png")));
    auto parsed = parse_scene(
        "[world]\nduration_s = 1\n"
        "[[body]]\nname = \"sign\"\nshape = \"box\"\nsize_m = [1, 1, 1]\ncolor = [0, 0.5, 0]\n"
        "visual = [{ shape = \"mesh\", file = \"square.obj\" },\n"
        "          { shape = \"box\", size_m = [0.2, 0.2, 0.2] }]\n",
        path_of("s.toml"));
    ASSERT_TRUE(parsed) << parsed.error();
    scene_ = std::move(*parsed);
    auto made = SceneRun::create(scene_, {.backend = Backend::cpu});
    ASSERT_TRUE(made) << made.error();
    run_ = std::move(*made);
    Assimp::Importer importer;
    const aiScene* read = importer.ReadFile(exported("sign.glb"), 0);
    ASSERT_NE(read, nullptr) << importer.GetErrorString();
    EXPECT_EQ(said_, "");
    ASSERT_EQ(read->mNumTextures, 1u);
    EXPECT_EQ(read->mTextures[0]->mHeight, 0u);  // a file, of this length
    EXPECT_EQ(read->mTextures[0]->mWidth, fs::file_size(path_of("fields.png")));
    ASSERT_EQ(read->mNumMeshes, 2u);
    const aiMesh& square = *read->mMeshes[0];
    const aiMesh& box = *read->mMeshes[1];
    EXPECT_EQ(square.mNumFaces, 2u);
    EXPECT_EQ(box.mNumFaces, 12u);
    EXPECT_TRUE(box.HasVertexColors(0));
    ASSERT_TRUE(square.HasTextureCoords(0));
    EXPECT_FALSE(square.HasVertexColors(0));
    aiString file;
    EXPECT_EQ(read->mMaterials[square.mMaterialIndex]->GetTexture(aiTextureType_DIFFUSE, 0, &file),
              aiReturn_SUCCESS);
    EXPECT_EQ(read->mMaterials[box.mMaterialIndex]->GetTextureCount(aiTextureType_DIFFUSE), 0u);
    // The lower left corner of the square is that of the texture; the importer counts from below.
    for (unsigned corner = 0; corner < 6; ++corner) {
        const unsigned v = square.mFaces[corner / 3].mIndices[corner % 3];
        const aiVector3D &at = square.mVertices[v], &place = square.mTextureCoords[0][v];
        EXPECT_NEAR(place.x, (at.y + 1) / 2, 1e-6f);
        EXPECT_NEAR(place.y, (at.z + 1) / 2, 1e-6f);
    }
}

TEST_F(Exports, assimp_reads_obj_and_ply_as_one_mesh_of_the_same_triangles) {
    open("z");
    unsigned triangle_counts[2] = {};
    for (const int i : {0, 1}) {
        Assimp::Importer importer;
        const aiScene* read = importer.ReadFile(exported(i == 0 ? "moment.obj" : "moment.ply"), 0);
        ASSERT_NE(read, nullptr) << importer.GetErrorString();
        for (unsigned m = 0; m < read->mNumMeshes; ++m) {
            triangle_counts[i] += read->mMeshes[m]->mNumFaces;
        }
    }
    EXPECT_GT(triangle_counts[0], 3000u);
    EXPECT_EQ(triangle_counts[0], triangle_counts[1]);
}

TEST_F(Exports, heights_as_a_picture_come_back_as_the_same_ground) {
    for (const std::string up : {"z", "y"}) {
        SCOPED_TRACE(up);
        open(up);
        const std::string picture = exported("moment.png");
        double low = 0, high = 0;
        ASSERT_EQ(std::sscanf(said_.c_str(), "min_height_m = %lf, max_height_m = %lf", &low, &high),
                  2)
            << said_;
        std::ostringstream text;
        text << "[world]\nduration_s = 1\nup = \"" << up
             << "\"\n[soil]\nsize_m = " << (up == "y" ? "[2.0, 1.2, 2.0]" : "[2.0, 2.0, 1.2]")
             << "\nvoxel_m = 0.05\n"
             << "material = \"moist_sand\"\n[[fill]]\nkind = \"height_map\"\nfile = \"" << picture
             << "\"\nmin_height_m = " << low << "\nmax_height_m = " << high << "\n";
        const std::string scene_path = picture + ".toml";
        std::ofstream(scene_path) << text.str();
        auto again = load_scene(scene_path);
        ASSERT_TRUE(again) << again.error();
        auto ground = SceneRun::create(*again, {.backend = Backend::cpu});
        ASSERT_TRUE(ground) << ground.error();
        // A height map is stretched from edge to edge: half a voxel at the rim, where the step of
        // 0.15 m makes the most of it.
        double sum = 0;
        for (int y = 0; y < 40; ++y) {
            for (int x = 0; x < 40; ++x) {
                sum += std::abs((*ground)->soil().surface_height_m(x, y) -
                                run_->soil().surface_height_m(x, y));
            }
        }
        EXPECT_LT(sum / 1600, 0.003);
    }
}

TEST_F(Exports, the_ascii_grid_has_north_on_top_and_heights_in_the_world) {
    open("z");
    std::ifstream file(exported("moment.asc"));
    std::string key;
    double ncols = 0, nrows = 0, x = 0, y = 0, cell = 0, none = 0;
    file >> key >> ncols >> key >> nrows >> key >> x >> key >> y >> key >> cell >> key >> none;
    EXPECT_EQ(ncols, 40);
    EXPECT_EQ(nrows, 40);
    EXPECT_NEAR(x, -kSideM / 2, 1e-9);
    EXPECT_NEAR(y, -kSideM / 2, 1e-9);
    EXPECT_EQ(cell, 0.05);
    std::vector<double> heights(std::istream_iterator<double>(file), {});
    ASSERT_EQ(heights.size(), 1600u);
    EXPECT_NEAR(heights[39], 0.6, 0.01);  // north-east: on the step
    EXPECT_NEAR(heights[0], kBedM, 0.01);
    for (const size_t row : {3u, 20u}) {
        EXPECT_NEAR(heights[row * 40 + 7], run_->soil().surface_height_m(7, 39 - int(row)), 1e-5);
    }
    // The same ground with y up: the step is in the east, rows go along z.
    open("y");
    std::ifstream other(exported("moment.asc"));
    for (int word = 0; word < 12; ++word) other >> key;
    heights.assign(std::istream_iterator<double>(other), {});
    ASSERT_EQ(heights.size(), 1600u);
    EXPECT_NEAR(heights[39], 0.6, 0.01);
    EXPECT_NEAR(heights[0], kBedM, 0.01);
    EXPECT_NEAR(heights[3 * 40 + 7], run_->soil().surface_height_m(3, 7), 1e-5);
}

TEST_F(Exports, an_ascii_grid_of_a_grid_that_is_turned_is_refused) {
    // By half a turn, too: east would be west.
    for (const double yaw_deg : {30.0, 90.0, 180.0, -180.0}) {
        const auto scene = parse_scene(
            "[world]\nduration_s = 1\n[soil]\nsize_m = [0.8, 0.8, 0.4]\nvoxel_m = 0.1\nyaw_deg = " +
                std::to_string(yaw_deg) + "\n",
            "s.toml");
        ASSERT_TRUE(scene) << scene.error();
        auto made = SceneRun::create(*scene, {.backend = Backend::cpu});
        ASSERT_TRUE(made) << made.error();
        const auto written = export_run(**made, path_of("turned.asc"));
        ASSERT_FALSE(written) << yaw_deg;
        EXPECT_NE(written.error().find("turned"), std::string::npos) << written.error();
    }
}

/// What a program prints; empty where it is missing or fails.
std::string text_of(const std::string& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

std::string output_of(const std::string& command) {
    const std::string out = path_of("output.txt"), errors = path_of("errors.txt");
    const int exit_code = std::system((command + " > '" + out + "' 2> '" + errors + "'").c_str());
    EXPECT_EQ(exit_code, 0) << command << ": " << text_of(errors);
    return text_of(out);
}

TEST_F(Exports, the_voxels_are_an_image_of_vtk) {
    open("y");
    const std::string path = exported("moment.vti");
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    const std::string bytes = text.str();
    const size_t raw = bytes.find("encoding=\"raw\">\n_");
    ASSERT_NE(raw, std::string::npos);
    // Six arrays, each behind its length: five of 4-byte numbers, one with three parts, one of
    // bytes.
    const size_t voxels = 40 * 40 * 24;
    EXPECT_EQ(bytes.size() - (raw + 17),
              6 * 8 + voxels * (4 * 4 + 12 + 1) +
                  std::string("\n  </AppendedData>\n</VTKFile>\n").size());
    // Debian's Python, where another one comes first in the path.
    std::string python;
    for (const char* name : {"python3", "/usr/bin/python3"}) {
        const std::string has_vtk =
            std::string(name) + " -c 'import vtkmodules.vtkIOXML' 2>/dev/null";
        if (python.empty() && std::system(has_vtk.c_str()) == 0) python = name;
    }
    if (python.empty()) {
        GTEST_SKIP() << "VTK does not read it here: python3-vtk9 is not installed";
    }
    const std::string sum =
        output_of(python +
                  " -c \"from vtkmodules.vtkIOXML import vtkXMLImageDataReader as R; r = R(); "
                  "r.SetFileName('" +
                  path +
                  "'); r.Update(); d = r.GetOutput(); a = d.GetCellData().GetArray('volume'); "
                  "print(sum(a.GetValue(i) for i in range(a.GetNumberOfTuples())))\"");
    ASSERT_FALSE(sum.empty());
    const double soil_m3 = soil_volume_m3(run_->soil());
    EXPECT_NEAR(std::stod(sum) * std::pow(0.05, 3), soil_m3, 1e-4 * soil_m3);
}

/// True where the build lacks a library, which the error has to name with its package.
bool is_left_out(const Result<std::string>& written, const std::string& package) {
    return !written && written.error().find("built without") != std::string::npos &&
           written.error().find(package) != std::string::npos;
}

TEST_F(Exports, gdal_reads_the_geotiff_with_heights_in_their_places) {
    for (const std::string up : {"z", "y"}) {
        SCOPED_TRACE(up);
        open(up);
        const std::string path = path_of("moment_" + up + ".tif");
        const auto written = export_run(*run_, path);
        if (is_left_out(written, "libtiff-dev")) {
            GTEST_SKIP() << written.error();
        }
        ASSERT_TRUE(written) << written.error();
        if (std::system("command -v gdal_translate >/dev/null") != 0) {
            GTEST_SKIP() << "nobody reads it here: gdal-bin is not installed";
        }
        EXPECT_NE(output_of("gdalinfo '" + path + "'").find("BulletSoil world"), std::string::npos);
        // East, north and height of the middle of each column.
        std::istringstream rows(output_of("gdal_translate -q -of XYZ '" + path + "' /vsistdout/"));
        const Soil& soil = run_->soil();
        int count = 0;
        for (double east = 0, north = 0, height = 0; rows >> east >> north >> height; ++count) {
            const Vec3 at = up == "y" ? Vec3{east, height, -north} : Vec3{east, north, height};
            const Vec3 grid = soil.frame().to_grid(at);
            const int x = static_cast<int>(std::floor(grid.x)),
                      y = static_cast<int>(std::floor(grid.y));
            EXPECT_NEAR(grid.x - x, 0.5, 1e-6);
            EXPECT_NEAR(grid.z * 0.05, soil.surface_height_m(x, y), 1e-6);  // floats
        }
        EXPECT_EQ(count, 40 * 40);
    }
    EXPECT_FALSE(export_run(*run_, "/no/such/folder/moment.tif"));
}

TEST_F(Exports, openvdb_finds_the_voxels_of_soil) {
    open("y");
    const std::string path = path_of("moment.vdb");
    const auto written = export_run(*run_, path);
    if (is_left_out(written, "libopenvdb-dev")) {
        GTEST_SKIP() << written.error();
    }
    ASSERT_TRUE(written) << written.error();
    EXPECT_FALSE(export_run(*run_, "/no/such/folder/moment.vdb"));
    if (std::system("command -v vdb_print >/dev/null") != 0) {
        GTEST_SKIP() << "nobody reads it here: libopenvdb-tools is not installed";
    }
    int filled = 0;
    const Soil& soil = run_->soil();
    for (int z = 0; z < 24; ++z) {
        for (int y = 0; y < 40; ++y) {
            for (int x = 0; x < 40; ++x) filled += soil.sample(x, y, z).volume > 0;
        }
    }
    // One line a grid: name, type, lowest and highest voxel, count of those that are not empty.
    const std::string text = output_of("vdb_print '" + path + "'");
    for (const std::string name : {"volume", "density", "velocity", "material"}) {
        EXPECT_NE(text.find(name), std::string::npos) << text;
    }
    EXPECT_NE(output_of("vdb_print -l '" + path + "'").find(std::to_string(filled)),
              std::string::npos)
        << text;
}

TEST_F(Exports, other_endings_are_refused_and_the_known_ones_named) {
    open("z");
    const auto written = export_run(*run_, "/tmp/moment.fbx");
    ASSERT_FALSE(written);
    for (const std::string& ending : export_endings()) {
        EXPECT_NE(written.error().find(ending), std::string::npos) << written.error();
    }
    EXPECT_FALSE(export_run(*run_, "/no/such/folder/moment.glb"));
}

}  // namespace
}  // namespace bsoil::scene::exports_test
