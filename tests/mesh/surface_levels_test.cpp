#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bsoil/surface_mesh.h"
#include "mesh_checks.h"
#include "voxel_tiles.h"

namespace bsoil::surface_levels_test {
namespace {

using test::enclosed_volume;
using test::open_edge_count;
using test::vertex;
using test::VoxelTiles;

/// Bumps of several wavelengths; some slopes steep, some columns empty.
double hills(double x, double y) {
    return 6 + 4 * std::sin(0.37 * x) * std::cos(0.29 * y) + 3 * std::sin(0.11 * x * y * 0.1) -
           (x > 11 && x < 15 ? 9 : 0);
}

/// Random levels, which the mesher lowers where neighbours would be too far apart.
std::vector<uint8_t> random_levels(const SurfaceMesher& mesher, std::mt19937& random) {
    // One or two seeds of full detail among coarse tiles, or any level anywhere.
    std::uniform_int_distribution<int> level(0, SurfaceMesher::kLevelMost), kind(0, 2);
    std::vector<uint8_t> levels;
    const int tile_count = mesher.tile_count_x() * mesher.tile_count_y();
    const bool is_mostly_coarse = kind(random) > 0;
    std::uniform_int_distribution<int> seed(0, tile_count);
    for (int t = 0; t < tile_count; ++t) {
        const bool is_coarse = is_mostly_coarse && seed(random) > 1;
        levels.push_back(
            static_cast<uint8_t>(is_coarse ? int{SurfaceMesher::kLevelMost} : level(random)));
    }
    return levels;
}

void expect_no_crack(int world_count) {
    std::mt19937 random(21);
    std::uniform_real_distribution<float> fill(-0.6f, 1.0f);
    std::uniform_int_distribution<int> side(1, 44), height(1, 20), kind(0, 3);
    constexpr int kSetCount = 20;
    int64_t pair_count = 0;
    std::array<int, SurfaceMesher::kLevelMost + 1> tile_counts{};
    for (int world = 0; world < world_count; ++world) {
        const int nx = side(random), ny = side(random), nz = height(random);
        VoxelTiles tiles(nx, ny, nz);
        SurfaceMeshDef def;
        switch (kind(random)) {
            case 0:  // all cases of all cells
                tiles.for_each_voxel([&](int x, int y, int z) {
                    const float soil = std::max(0.0f, fill(random));
                    tiles.volume(x, y, z) = soil;
                    tiles.solid(x, y, z) = std::min(1 - soil, std::max(0.0f, fill(random)));
                });
                break;
            case 1: {  // soil on rock that stands out of it
                const float phase = 10 * fill(random);
                tiles.fill_solid_heights([&](double x, double y) {
                    return 0.5 * nz + 0.4 * nz * std::sin(0.3 * x + phase) * std::cos(0.2 * y);
                });
                tiles.for_each_voxel([&](int x, int y, int z) {
                    const float soil = z < 0.6 * nz ? 1.0f : 0.0f;
                    tiles.volume(x, y, z) = std::max(0.0f, soil - tiles.solid(x, y, z));
                });
                break;
            }
            default:
                tiles.fill_heights(hills);
        }
        if (kind(random) == 0) def.layer = SurfaceMeshDef::Layer::terrain;
        SurfaceMesher mesher(tiles, def);
        Mesh mesh;
        for (int set = 0; set < kSetCount; ++set) {
            const std::vector<uint8_t> levels = random_levels(mesher, random);
            mesher.update(levels);
            mesher.gather(mesh);
            ASSERT_EQ(open_edge_count(mesh), 0) << "world " << world << " of " << nx << " x " << ny
                                                << " x " << nz << ", set " << set;
            for (int ty = 0; ty < mesher.tile_count_y(); ++ty) {
                for (int tx = 0; tx < mesher.tile_count_x(); ++tx) {
                    const int level = mesher.tile_level(tx, ty);
                    ++tile_counts[level];
                    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {-1, 1}}) {
                        const int x = tx + dx, y = ty + dy;
                        if (x < 0 || x >= mesher.tile_count_x() || y >= mesher.tile_count_y()) {
                            continue;
                        }
                        const int step = std::abs(level - mesher.tile_level(x, y));
                        ASSERT_LE(step, 1);
                        pair_count += step;
                    }
                }
            }
        }
    }
    // There were borders between levels to crack, and tiles of each level.
    EXPECT_GT(pair_count, 100 * world_count);
    for (const int count : tile_counts) EXPECT_GT(count, 10 * world_count);
}

TEST(SurfaceLevels, two_thousand_sets_of_levels_have_no_crack) { expect_no_crack(100); }
TEST(SlowSurfaceLevels, ten_thousand_sets_of_levels_have_no_crack) { expect_no_crack(500); }

TEST(SurfaceLevels, a_mesh_brought_to_other_levels_equals_a_new_one) {
    std::mt19937 random(22);
    VoxelTiles tiles(70, 58, 24);
    tiles.fill_heights(hills);
    SurfaceMesher mesher(tiles);
    std::uniform_int_distribution<int> x(0, 69), y(0, 57);
    Mesh updated, fresh;
    for (int round = 0; round < 60; ++round) {
        const std::vector<uint8_t> levels = random_levels(mesher, random);
        const int changed_x = x(random), changed_y = y(random);
        for (int z = 0; z < 24; ++z) {
            tiles.volume(changed_x, changed_y, z) = z < round % 24 ? 1.0f : 0.0f;
        }
        tiles.touch(changed_x, changed_y);
        mesher.update(levels);
        mesher.gather(updated);
        SurfaceMesher other(tiles);
        other.update(levels);
        other.gather(fresh);
        ASSERT_EQ(updated.positions, fresh.positions) << round;
        ASSERT_EQ(updated.normals, fresh.normals) << round;
        ASSERT_EQ(updated.indices, fresh.indices) << round;
    }
}

TEST(SurfaceLevels, coarse_slope_is_the_same_plane) {
    const auto plane = [](double x, double y) { return 24.3 + 0.4 * (x - 32) + 0.2 * (y - 32); };
    VoxelTiles tiles(64, 64, 56);
    tiles.fill_heights(plane);
    SurfaceMesher mesher(tiles);
    std::vector<uint8_t> levels(64, 0);
    const double steepness = std::sqrt(1 + 0.4 * 0.4 + 0.2 * 0.2);
    for (uint8_t finest = 0; finest <= SurfaceMesher::kLevelMost; ++finest) {
        // One tile finer than the others: its borders have transitions.
        std::fill(levels.begin(), levels.end(), finest);
        if (finest > 0) levels[27] = static_cast<uint8_t>(finest - 1);
        mesher.update(levels);
        Mesh mesh;
        mesher.gather(mesh);
        EXPECT_EQ(open_edge_count(mesh), 0);
        for (size_t v = 0; v < mesh.vertex_count(); ++v) {
            const Vec3 p = vertex(mesh, v);
            const double side = 1 << finest;
            if (p.z <= 0 || std::min(p.x, p.y) < 2 * side || std::max(p.x, p.y) > 64 - 2 * side) {
                continue;
            }
            // 2 % of a voxel, as at full detail.
            ASSERT_LT(std::abs(p.z - plane(p.x, p.y)) / steepness, 0.02) << int{finest};
        }
        EXPECT_NEAR(enclosed_volume(mesh), tiles.total_volume(), 0.01 * tiles.total_volume());
    }
}

TEST(SurfaceLevels, levels_follow_the_distance_and_change_only_what_they_must) {
    VoxelTiles tiles(256, 256, 16);
    tiles.fill_heights([](double, double) { return 9.3; });
    SurfaceMesher mesher(tiles);
    SurfaceDetail detail{{4, 4, 9}, 2.0 / 64};  // cells of two voxels from 64 voxels on
    const SurfaceMeshReport first = mesher.update(detail);
    EXPECT_EQ(first.tile_built_count, 32 * 32);
    EXPECT_EQ(mesher.tile_level(7, 0), 0);
    EXPECT_EQ(mesher.tile_level(10, 0), 1);
    EXPECT_EQ(mesher.tile_level(20, 0), 2);
    EXPECT_EQ(mesher.tile_level(31, 31), 3);
    EXPECT_EQ(mesher.update(detail).tile_built_count, 0);
    detail.eye_m.x += 2;  // trembles
    EXPECT_EQ(mesher.update(detail).tile_built_count, 0);
    detail.eye_m.x += 40;
    const SurfaceMeshReport moved = mesher.update(detail);
    EXPECT_GT(moved.tile_built_count, 0);
    EXPECT_LT(moved.tile_built_count, 32 * 32 / 2);
    EXPECT_EQ(moved.tile_read_count, 0);
    tiles.volume(250, 250, 10) = 1;
    tiles.touch(250, 250);
    EXPECT_LE(mesher.update(detail).tile_built_count, 25);
}

TEST(SurfaceLevels, thin_soil_on_rock_is_seen_from_afar) {
    VoxelTiles tiles(64, 64, 40);
    const auto rock = [](double x, double y) { return 18.3 + 0.1 * x + 3 * std::sin(0.2 * y); };
    tiles.fill_solid_heights(rock);
    tiles.for_each_voxel([&](int x, int y, int z) {
        const double top = std::clamp(rock(x + 0.5, y + 0.5) + 0.7 - z, 0.0, 1.0);
        tiles.volume(x, y, z) = std::max(0.0f, static_cast<float>(top) - tiles.solid(x, y, z));
    });
    for (uint8_t level = 0; level <= SurfaceMesher::kLevelMost; ++level) {
        SurfaceMesher mesher(tiles);
        mesher.update(std::vector<uint8_t>(64, level));
        Mesh mesh;
        mesher.gather(mesh);
        EXPECT_EQ(open_edge_count(mesh), 0);
        double area = 0;  // of its top, seen from above
        for (size_t t = 0; t < mesh.triangle_count(); ++t) {
            const uint32_t* i = &mesh.indices[3 * t];
            const Vec3 a = vertex(mesh, i[0]);
            const Vec3 twice = cross(vertex(mesh, i[1]) - a, vertex(mesh, i[2]) - a);
            if (twice.z > 0) area += 0.5 * twice.z;
        }
        EXPECT_NEAR(area, 64 * 64, 0.01 * 64 * 64) << int{level};
    }
}

// Leach and Marais (2015), 6.1: "The view of the terrain is from the corner, and spans the entire
// terrain", 79,886 triangles for 512 x 512 columns and 103,700 for 1024 x 1024, at full detail near
// the eye.
void expect_triangles_at_most(int side, size_t budget) {
    VoxelTiles tiles(side, side, 32);
    tiles.fill_heights([](double x, double y) {
        return 16 + 8 * std::sin(0.021 * x) * std::cos(0.017 * y) +
               2 * std::sin(0.11 * x + 0.07 * y);
    });
    SurfaceMesher mesher(tiles, {.close_floor = false});
    const SurfaceDetail detail{{0, 0, 40}, 2.0 / 100};
    mesher.update(detail);
    size_t triangle_count = 0, full_count = 0;
    for (int ty = 0; ty < mesher.tile_count_y(); ++ty) {
        for (int tx = 0; tx < mesher.tile_count_x(); ++tx) {
            triangle_count += mesher.tile_mesh(tx, ty).triangle_count();
            full_count += mesher.tile_level(tx, ty) == 0;
        }
    }
    testing::Test::RecordProperty("triangles_" + std::to_string(side),
                                  static_cast<int>(triangle_count));
    EXPECT_LE(triangle_count, budget) << side;
    EXPECT_GT(full_count, 100u);
}

TEST(SurfaceLevels, large_ground_takes_fewer_triangles_than_clip_maps) {
    expect_triangles_at_most(512, 80000);
}
TEST(SlowSurfaceLevels, larger_ground_takes_fewer_triangles_than_clip_maps) {
    expect_triangles_at_most(1024, 104000);
}

}  // namespace
}  // namespace bsoil::surface_levels_test
