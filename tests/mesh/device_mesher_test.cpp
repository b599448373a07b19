/// OpenGL gives the mesh that the CPU gives, bit for bit.
#include "mesh/device_mesher.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "bsoil/surface_mesh.h"
#include "device/kernel_set.h"
#include "mesh/mesh_kernels.h"
#include "mesh/tile_mesher.h"
#include "mesh_checks.h"
#include "mixed_wet_tiles.h"
#include "voxel_tiles.h"

namespace bsoil::device_mesher_test {
namespace {

using mesh::DeviceMesher;
using mesh::GridColumns;
using mesh::TileLevels;
using test::fill_with_hills;
using test::fill_with_noise;
using test::MixedWetTiles;
using test::VoxelTiles;

/// Empty where the meshes are equal bit for bit, else what differs.
std::string difference(const Mesh& a, const Mesh& b) {
    if (a.indices != b.indices) return "triangles";
    if (a.positions != b.positions) return "positions";
    if (a.normals != b.normals) return "normals";
    if (a.colors != b.colors) return "colours";
    if (a.weights != b.weights) return "weights";
    if (a.wetness != b.wetness) return "wetness";
    return a.palette == b.palette ? "" : "palette";
}

/// A world of its own for each number: sizes, frame, voxels.
VoxelTiles make_world(std::mt19937& random, int number, int side_most, int height_most) {
    std::uniform_int_distribution<int> side(1, side_most), height(1, height_most);
    VoxelTiles tiles(side(random), side(random), height(random));
    tiles.frame().voxel_m = 0.03;
    tiles.frame().grid_to_world = {{12.3, -4.5, 6.7}, {0.5, -0.5, 0.5, 0.5}};
    if (number % 3 == 0) fill_with_noise(tiles, random, number % 2 == 0);
    if (number % 3 != 0) fill_with_hills(tiles, number);
    return tiles;
}

GridColumns columns_of(const VoxelTiles& tiles) {
    GridColumns grid;
    for (int axis = 0; axis < 3; ++axis) grid.size[axis] = tiles.frame().size[axis];
    for (int axis = 0; axis < 2; ++axis) grid.tile_count[axis] = (grid.size[axis] + 7) / 8;
    std::vector<float> volume, solid;
    std::vector<uint8_t> material;
    for (int ty = 0; ty < grid.tile_count[1]; ++ty) {
        for (int tx = 0; tx < grid.tile_count[0]; ++tx) {
            tiles.read_tile(tx, ty, volume, solid, material);
            mesh::find_soil_runs(volume, solid, material, grid.size[2], grid.tiles.emplace_back());
        }
    }
    return grid;
}

/// The kernels on a device, against TileMesher on the same columns.
class AnyMeshDevice : public testing::TestWithParam<const char*> {
  protected:
    std::unique_ptr<device::Device> make_device() const {
        const std::string name = GetParam();
        if (name != "gl") {
            return device::create_cpu_device(device::mesh_kernel_set(), name.back() - '0');
        }
        auto made = device::create_gl_device(device::mesh_kernel_set(), true);
        EXPECT_TRUE(made) << made.error();
        return made ? std::move(*made) : nullptr;
    }
};

TEST_P(AnyMeshDevice, meshes_tiles_of_every_level_as_the_cpu_does) {
    std::mt19937 random(31);
    size_t triangle_count = 0;
    for (int world = 0; world < 12; ++world) {
        const VoxelTiles tiles = make_world(random, world, 30, 70);
        const GridColumns grid = columns_of(tiles);
        const SurfaceMeshDef def{.close_floor = world % 4 != 1};
        const mesh::VertexWriter writer(tiles, def);
        mesh::TileMesher host(writer, def.close_floor);
        auto made = make_device();
        ASSERT_TRUE(made);
        DeviceMesher on_device(std::move(made), tiles, def);
        for (uint8_t level = 0; level <= TileLevels::kMost; ++level) {
            TileLevels levels(grid.tile_count[0], grid.tile_count[1]);
            levels.take(std::vector<uint8_t>(grid.tiles.size(), level));
            std::vector<Mesh> meshes(grid.tiles.size());
            std::vector<mesh::TileJob> jobs;
            for (size_t t = 0; t < meshes.size(); ++t) {
                const int tile = static_cast<int>(t), count_x = grid.tile_count[0];
                jobs.push_back({tile % count_x, tile / count_x, &meshes[t]});
            }
            const Status built = on_device.build(grid, levels, jobs);
            ASSERT_TRUE(built) << built.error();
            for (const mesh::TileJob& job : jobs) {
                Mesh expected;
                host.build(grid, levels, job.tx, job.ty, expected);
                ASSERT_EQ(difference(*job.mesh, expected), "")
                    << "world " << world << ", level " << int{level} << ", tile " << job.tx << ", "
                    << job.ty;
                triangle_count += expected.triangle_count();
            }
        }
    }
    EXPECT_GT(triangle_count, 100'000u);
}

INSTANTIATE_TEST_SUITE_P(MeshKernels, AnyMeshDevice, testing::Values("cpu1", "cpu2", "gl"),
                         [](const auto& device) { return device.param; });

/// A SurfaceMesher on OpenGL, or none where there is no OpenGL 4.5.
std::unique_ptr<SurfaceMesher> gl_mesher(const TileSource& source, SurfaceMeshDef def) {
    def.backend = Backend::gl;
    auto mesher = std::make_unique<SurfaceMesher>(source, def);
    return mesher->backend_name() == "gl" ? std::move(mesher) : nullptr;
}

TEST(GlSurfaceMesher, follows_changes_and_levels_as_the_cpu_does) {
    std::mt19937 random(32);
    std::uniform_int_distribution<int> level(0, SurfaceMesher::kLevelMost);
    int gl_count = 0, built_count = 0;
    for (int world = 0; world < 6; ++world) {
        VoxelTiles tiles = make_world(random, world, 60, 40);
        const MixedWetTiles mixed(tiles);
        SurfaceMesher host(mixed);
        const auto on_gl = gl_mesher(mixed, {});
        if (!on_gl) GTEST_SKIP() << "no OpenGL 4.5";
        const auto* size = tiles.frame().size;
        std::uniform_int_distribution<int> x(0, size[0] - 1), y(0, size[1] - 1);
        std::vector<uint8_t> levels(static_cast<size_t>(host.tile_count_x() * host.tile_count_y()),
                                    0);
        for (int round = 0; round < 6; ++round) {
            const int changed_x = x(random), changed_y = y(random);
            for (int z = 0; z < size[2]; ++z) {
                tiles.volume(changed_x, changed_y, z) = z < round * 5 ? 1.0f : 0.0f;
            }
            tiles.touch(changed_x, changed_y);
            for (uint8_t& wanted : levels) {
                if (round > 2) wanted = static_cast<uint8_t>(level(random));
            }
            host.update(levels);
            const SurfaceMeshReport report = on_gl->update(levels);
            gl_count += report.tile_gl_count;
            built_count += report.tile_built_count;
            Mesh a, b;
            host.gather(a);
            on_gl->gather(b);
            ASSERT_EQ(difference(a, b), "") << "world " << world << ", round " << round;
            ASSERT_EQ(test::open_edge_count(b), 0);
        }
    }
    EXPECT_EQ(gl_count, built_count);
    EXPECT_GT(gl_count, 300);
}

TEST(GlSurfaceMesher, meshes_again_only_what_changed) {
    VoxelTiles tiles(80, 80, 24);
    fill_with_hills(tiles, 0);
    const auto mesher = gl_mesher(tiles, {});
    if (!mesher) GTEST_SKIP() << "no OpenGL 4.5";
    EXPECT_EQ(mesher->update().tile_gl_count, 100);
    EXPECT_EQ(mesher->update().tile_gl_count, 0);
    for (const int x : {44, 45}) tiles.volume(x, 44, 20) = 0.7f;
    tiles.touch(44, 44);
    EXPECT_EQ(mesher->update().tile_gl_count, 9);
}

TEST(GlSurfaceMesher, terrain_is_meshed_as_on_the_cpu) {
    std::mt19937 random(33);
    VoxelTiles tiles(37, 21, 18);
    fill_with_noise(tiles, random, true);
    SurfaceMeshDef def;
    def.layer = SurfaceMeshDef::Layer::terrain;
    SurfaceMesher host(tiles, def);
    const auto on_gl = gl_mesher(tiles, def);
    if (!on_gl) GTEST_SKIP() << "no OpenGL 4.5";
    host.update();
    on_gl->update();
    Mesh a, b;
    host.gather(a);
    on_gl->gather(b);
    EXPECT_EQ(difference(a, b), "");
    EXPECT_GT(a.triangle_count(), 1000u);
}

TEST(GlSurfaceMesher, says_where_it_meshes) {
    VoxelTiles tiles(8, 8, 8);
    const SurfaceMesher by_default(tiles);
    EXPECT_EQ(by_default.backend_name(), "cpu");
    EXPECT_FALSE(by_default.backend_reason().empty());
    const auto on_gl = gl_mesher(tiles, {});
    if (!on_gl) GTEST_SKIP() << "no OpenGL 4.5";
    EXPECT_NE(on_gl->backend_reason().find("OpenGL 4.5"), std::string::npos);
}

}  // namespace
}  // namespace bsoil::device_mesher_test
