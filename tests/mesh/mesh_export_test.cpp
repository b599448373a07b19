#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "bsoil/surface_mesh.h"
#include "temporary_file.h"

namespace bsoil::mesh_export_test {
namespace {

Mesh one_triangle() {
    Mesh mesh;
    mesh.positions = {0, 0, 0, 1, 0, 0, 0, 2, 0};
    mesh.normals = {0, 0, 1, 0, 0, 1, 0, 0, 1};
    mesh.colors = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    mesh.indices = {0, 1, 2};
    return mesh;
}

std::string read_all(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

TEST(MeshExport, obj_lists_vertices_normals_and_faces) {
    const TemporaryFile file("triangle.obj");
    ASSERT_TRUE(write_obj(one_triangle(), file.path()));
    EXPECT_EQ(read_all(file.path()),
              "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 2 0 0 0 1\n"
              "vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nf 1//1 2//2 3//3\n");
}

TEST(MeshExport, obj_has_all_digits_of_the_coordinates) {
    Mesh mesh = one_triangle();
    mesh.positions = {10012.342f, -0.05f, 4321.0625f, 1, 0, 0, 0, 2, 0};
    const TemporaryFile file("far.obj");
    ASSERT_TRUE(write_obj(mesh, file.path()));
    std::istringstream text(read_all(file.path()));
    std::string v, x, y, z;
    text >> v >> x >> y >> z;
    EXPECT_EQ(std::stof(x), 10012.342f);
    EXPECT_EQ(std::stof(y), -0.05f);
    EXPECT_EQ(std::stof(z), 4321.0625f);
}

TEST(MeshExport, ply_has_the_size_its_header_promises) {
    const TemporaryFile file("triangle.ply");
    ASSERT_TRUE(write_ply(one_triangle(), file.path()));
    const std::string text = read_all(file.path());
    const std::string end = "end_header\n";
    EXPECT_NE(text.find("element vertex 3\n"), std::string::npos);
    EXPECT_EQ(text.size() - text.find(end) - end.size(), 3 * 27u + 13u);
}

TEST(MeshExport, a_path_that_cannot_be_written_is_named) {
    const std::string path = "/no/such/folder/mesh.obj";
    const Status obj = write_obj(one_triangle(), path), ply = write_ply(one_triangle(), path);
    ASSERT_FALSE(obj);
    ASSERT_FALSE(ply);
    EXPECT_NE(obj.error().find(path), std::string::npos);
    EXPECT_NE(ply.error().find(path), std::string::npos);
}

TEST(MeshExport, meshes_without_all_of_their_numbers_are_refused) {
    const TemporaryFile file("part.obj");
    const auto refusal = [&](const Mesh& mesh) {
        const Status obj = write_obj(mesh, file.path()), ply = write_ply(mesh, file.path());
        return obj || ply || std::filesystem::exists(file.path()) ? "" : obj.error();
    };
    Mesh mesh = one_triangle();
    mesh.colors.clear();
    EXPECT_NE(refusal(mesh).find("Mesh::colors has 0 numbers"), std::string::npos);
    mesh = one_triangle();
    mesh.normals.pop_back();
    EXPECT_NE(refusal(mesh).find("Mesh::normals"), std::string::npos);
    mesh = one_triangle();
    mesh.indices[1] = 3;
    EXPECT_NE(refusal(mesh).find("Mesh::indices has 3"), std::string::npos);
    mesh.indices.pop_back();
    EXPECT_NE(refusal(mesh).find("Mesh::indices has 2"), std::string::npos);
    EXPECT_TRUE(Mesh().validate());
}

TEST(MeshExport, append_shifts_indices) {
    Mesh mesh = one_triangle();
    mesh.append(one_triangle());
    EXPECT_EQ(mesh.vertex_count(), 6u);
    EXPECT_EQ(mesh.indices, (std::vector<uint32_t>{0, 1, 2, 3, 4, 5}));
}

}  // namespace
}  // namespace bsoil::mesh_export_test
