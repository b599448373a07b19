#include "bsoil/surface_mesh.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "mesh_checks.h"
#include "voxel_tiles.h"

namespace bsoil::surface_mesh_test {
namespace {

using test::enclosed_volume;
using test::normal;
using test::open_edge_count;
using test::vertex;
using test::VoxelTiles;
constexpr double kDegree = std::numbers::pi / 180;

Mesh mesh_of(const TileSource& source, const SurfaceMeshDef& def = {}) {
    SurfaceMesher mesher(source, def);
    mesher.update();
    Mesh mesh;
    mesher.gather(mesh);
    return mesh;
}

size_t floor_triangle_count(const Mesh& mesh) {
    size_t count = 0;
    for (size_t t = 0; t < mesh.triangle_count(); ++t) {
        count += normal(mesh, mesh.indices[3 * t]).z < -0.5;
    }
    return count;
}

/// Bumps of several wavelengths; some slopes steep, some columns empty.
double hills(double x, double y) {
    return 6 + 4 * std::sin(0.37 * x) * std::cos(0.29 * y) + 3 * std::sin(0.11 * x * y * 0.1) -
           (x > 11 && x < 15 ? 9 : 0);
}

TEST(SurfaceMesh, planar_slope_meshes_to_the_plane) {
    for (const double angle : {5.0, 10.0, 20.0, 33.0, 40.0}) {
        for (const double direction : {0.0, 22.5, 45.0}) {
            const double rise = std::tan(angle * kDegree);
            const double gx = rise * std::cos(direction * kDegree);
            const double gy = rise * std::sin(direction * kDegree);
            const auto plane = [&](double x, double y) {
                return 24.3 + gx * (x - 16) + gy * (y - 16);
            };
            VoxelTiles tiles(32, 32, 56);
            tiles.fill_heights(plane);
            const Mesh mesh = mesh_of(tiles);
            double worst = 0, worst_normal = 0;
            int count = 0;
            const Vec3 up = (1 / std::sqrt(1 + rise * rise)) * Vec3{-gx, -gy, 1};
            for (size_t v = 0; v < mesh.vertex_count(); ++v) {
                const Vec3 p = vertex(mesh, v);
                if (p.z <= 0 || p.x < 2 || p.x > 30 || p.y < 2 || p.y > 30) continue;
                const double off = (p.z - plane(p.x, p.y)) / std::sqrt(1 + rise * rise);
                worst = std::max(worst, std::abs(off));
                worst_normal = std::max(worst_normal, length(normal(mesh, v) - up));
                ++count;
            }
            EXPECT_GT(count, 600);
            EXPECT_LT(worst, 0.02) << angle << " degrees towards " << direction;
            EXPECT_LT(worst_normal, 0.01) << angle << " degrees towards " << direction;
        }
    }
}

TEST(SurfaceMesh, planar_slope_is_cut_exactly_at_the_grids_sides) {
    VoxelTiles tiles(20, 17, 40);
    const auto plane = [](double x, double y) { return 12.2 + 0.6 * x + 0.3 * y; };
    tiles.fill_heights(plane);
    const Mesh mesh = mesh_of(tiles);
    EXPECT_EQ(open_edge_count(mesh), 0);
    double top = 0;
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 p = vertex(mesh, v);
        EXPECT_GE(p.x, 0);
        EXPECT_LE(p.x, 20);
        EXPECT_GE(p.y, 0);
        EXPECT_LE(p.y, 17);
        EXPECT_GE(p.z, 0);
        EXPECT_LT(p.z, plane(p.x, p.y) + 0.02);
        top = std::max(top, p.z);
    }
    EXPECT_NEAR(top, plane(20, 17), 0.02);
    // The volume under the plane up to the very sides; floats of positions up to 40 give 1e-6.
    EXPECT_NEAR(enclosed_volume(mesh), 20 * 17 * plane(10, 8.5), 1e-3 * 20 * 17);
}

TEST(SurfaceMesh, box_on_the_floor_is_closed_and_keeps_its_volume) {
    VoxelTiles tiles(32, 24, 32);
    tiles.fill_shape([](double x, double y, double z) {
        return x > 7 && x < 21 && y > 6 && y < 17 && z < 12.4;
    });
    const Mesh mesh = mesh_of(tiles);
    EXPECT_EQ(open_edge_count(mesh), 0);
    EXPECT_NEAR(enclosed_volume(mesh), tiles.total_volume(), 0.05 * tiles.total_volume());
}

TEST(SurfaceMesh, falling_sphere_is_closed_and_keeps_its_volume) {
    // Chords of a sphere lie inside it: below four voxels of radius that alone costs the 5 %.
    for (const double radius : {5.0, 7.0, 10.0}) {
        VoxelTiles tiles(32, 32, 32);
        tiles.fill_shape([&](double x, double y, double z) {
            const Vec3 d = Vec3{x, y, z} - Vec3{15.3, 16.4, 17.1};
            return dot(d, d) < radius * radius;
        });
        const Mesh mesh = mesh_of(tiles);
        EXPECT_EQ(open_edge_count(mesh), 0);
        EXPECT_NEAR(enclosed_volume(mesh), tiles.total_volume(), 0.05 * tiles.total_volume())
            << "radius " << radius;
    }
}

TEST(SurfaceMesh, hills_over_many_tiles_have_no_cracks) {
    VoxelTiles tiles(37, 29, 24);
    tiles.fill_heights(hills);
    const Mesh mesh = mesh_of(tiles);
    EXPECT_EQ(open_edge_count(mesh), 0);
    EXPECT_NEAR(enclosed_volume(mesh), tiles.total_volume(), 0.05 * tiles.total_volume());
}

TEST(SurfaceMesh, random_voxels_are_closed) {
    // All 256 cases of a cell, ambiguous faces included.
    std::mt19937 random(7);
    std::uniform_real_distribution<float> fill(-0.6f, 1.0f);
    VoxelTiles tiles(24, 24, 24);
    tiles.for_each_voxel([&](int x, int y, int z) {
        tiles.volume(x, y, z) = std::max(0.0f, fill(random));
        tiles.solid(x, y, z) = std::min(1 - tiles.volume(x, y, z), std::max(0.0f, fill(random)));
    });
    EXPECT_EQ(open_edge_count(mesh_of(tiles)), 0);
    EXPECT_EQ(open_edge_count(mesh_of(tiles, {.layer = SurfaceMeshDef::Layer::terrain})), 0);
}

TEST(SurfaceMesh, grids_of_any_size_are_closed_and_keep_their_volume) {
    // Every remainder of a tile, twice, against sizes of both kinds; then sizes at random.
    std::vector<std::array<int, 3>> sizes;
    for (int side = 1; side <= 18; ++side) {
        sizes.insert(sizes.end(), {{side, 40, 20}, {9, side, 7}});
    }
    std::mt19937 random(11);
    std::uniform_int_distribution<int> side(1, 40);
    for (int i = 0; i < 60; ++i) sizes.push_back({side(random), side(random), side(random)});
    for (const auto& [nx, ny, nz] : sizes) {
        SCOPED_TRACE(std::to_string(nx) + " x " + std::to_string(ny) + " x " + std::to_string(nz));
        const auto ground = [top = nz](double x, double y) {
            return 0.6 * top + 0.02 * top * (std::sin(0.4 * x) + std::cos(0.3 * y));
        };
        VoxelTiles soil(nx, ny, nz), rock(nx, ny, nz);
        soil.fill_heights(ground);
        rock.fill_solid_heights(ground);
        for (const Mesh& mesh :
             {mesh_of(soil), mesh_of(rock, {.layer = SurfaceMeshDef::Layer::terrain})}) {
            EXPECT_EQ(open_edge_count(mesh), 0);
            // Gentle ground: chords of the waves cost the most, 0.2 %; a grid one voxel wide has
            // no slope to continue to its sides.
            EXPECT_NEAR(enclosed_volume(mesh), soil.total_volume(), 0.02 * soil.total_volume());
            for (size_t v = 0; v < mesh.vertex_count(); ++v) {
                const Vec3 p = vertex(mesh, v);
                ASSERT_TRUE(p.x >= 0 && p.x <= nx && p.y >= 0 && p.y <= ny && p.z >= 0 &&
                            p.z <= nz);
                ASSERT_NEAR(length(normal(mesh, v)), 1, 1e-5);
            }
        }
    }
}

TEST(SurfaceMesh, random_voxels_are_closed_in_grids_of_any_size) {
    std::mt19937 random(12);
    std::uniform_real_distribution<float> fill(-0.6f, 1.0f);
    std::uniform_int_distribution<int> side(1, 40);
    for (int i = 0; i < 40; ++i) {
        const int nx = side(random), ny = side(random), nz = side(random) / 2 + 1;
        SCOPED_TRACE(std::to_string(nx) + " x " + std::to_string(ny) + " x " + std::to_string(nz));
        VoxelTiles tiles(nx, ny, nz);
        tiles.for_each_voxel([&](int x, int y, int z) {
            const float soil = std::max(0.0f, fill(random));
            tiles.volume(x, y, z) = soil;
            tiles.solid(x, y, z) = std::min(1 - soil, std::max(0.0f, fill(random)));
        });
        EXPECT_EQ(open_edge_count(mesh_of(tiles)), 0);
        EXPECT_EQ(open_edge_count(mesh_of(tiles, {.layer = SurfaceMeshDef::Layer::terrain})), 0);
    }
}

TEST(SurfaceMesh, normals_are_unit_and_point_out_of_the_triangles) {
    VoxelTiles tiles(37, 29, 24);
    tiles.fill_heights(hills);
    const Mesh mesh = mesh_of(tiles);
    int against = 0;
    for (size_t t = 0; t < mesh.triangle_count(); ++t) {
        const uint32_t* i = &mesh.indices[3 * t];
        const Vec3 face =
            cross(vertex(mesh, i[1]) - vertex(mesh, i[0]), vertex(mesh, i[2]) - vertex(mesh, i[0]));
        for (size_t k = 0; k < 3; ++k) {
            EXPECT_NEAR(length(normal(mesh, i[k])), 1, 1e-5);
            against += dot(face, normal(mesh, i[k])) < -1e-3;
        }
    }
    // Sharp edges between floor and toe of the soil bend normals over; nothing else may.
    EXPECT_LT(against, static_cast<int>(mesh.indices.size() / 100));
}

TEST(SurfaceMesh, only_changed_tiles_and_neighbours_are_built_again) {
    VoxelTiles tiles(40, 40, 24);
    tiles.fill_heights([](double, double) { return 9.3; });
    SurfaceMesher mesher(tiles);
    SurfaceMeshReport report = mesher.update();
    EXPECT_EQ(report.tile_read_count, 25);
    EXPECT_EQ(report.tile_built_count, 25);
    report = mesher.update();
    EXPECT_EQ(report.tile_read_count, 0);
    EXPECT_EQ(report.tile_built_count, 0);

    tiles.touch(20, 20);  // awake, yet nothing moved
    report = mesher.update();
    EXPECT_EQ(report.tile_read_count, 1);
    EXPECT_EQ(report.tile_built_count, 0);

    tiles.volume(23, 20, 9) = 1;
    tiles.volume(23, 20, 10) = 0.7f;
    tiles.touch(23, 20);
    const uint64_t far_revision = mesher.tile_mesh_revision(0, 0);
    report = mesher.update();
    EXPECT_EQ(report.tile_read_count, 1);
    EXPECT_EQ(report.tile_built_count, 9);
    EXPECT_EQ(mesher.tile_mesh_revision(0, 0), far_revision);

    Mesh updated;
    mesher.gather(updated);
    const Mesh fresh = mesh_of(tiles);
    EXPECT_EQ(updated.positions, fresh.positions);
    EXPECT_EQ(updated.indices, fresh.indices);
}

TEST(SurfaceMesh, rebuilding_reuses_memory) {
    VoxelTiles tiles(24, 24, 24);
    tiles.fill_heights(hills);
    SurfaceMesher mesher(tiles);
    mesher.update();
    const float* positions = mesher.tile_mesh(1, 1).positions.data();
    const uint32_t* indices = mesher.tile_mesh(1, 1).indices.data();
    tiles.volume(12, 12, 20) = 0;
    tiles.volume(10, 10, 3) = 0;
    tiles.touch(12, 12);
    mesher.update();
    EXPECT_EQ(mesher.tile_mesh(1, 1).positions.data(), positions);
    EXPECT_EQ(mesher.tile_mesh(1, 1).indices.data(), indices);
}

TEST(SurfaceMesh, terrain_is_meshed_like_soil) {
    VoxelTiles tiles(24, 24, 32);
    const auto plane = [](double x, double y) { return 10.4 + 0.4 * x + 0.1 * y; };
    tiles.fill_solid_heights(plane);
    const Mesh mesh = mesh_of(
        tiles, {.layer = SurfaceMeshDef::Layer::terrain, .terrain_color = {0.2f, 0.4f, 0.6f}});
    EXPECT_EQ(open_edge_count(mesh), 0);
    EXPECT_NEAR(enclosed_volume(mesh), 24 * 24 * plane(12, 12), 0.1 * 24);
    EXPECT_FLOAT_EQ(mesh.colors[1], 0.4f);
    EXPECT_EQ(mesh_of(tiles).triangle_count(), 0u);
}

TEST(SurfaceMesh, a_single_voxel_in_the_air_is_grains_of_soil_and_a_mesh_of_terrain) {
    VoxelTiles tiles(16, 16, 16);
    tiles.volume(3, 4, 9) = 0.9f;
    tiles.solid(11, 4, 9) = 0.9f;
    SurfaceMesher soil(tiles);
    soil.update();
    EXPECT_EQ(soil.tile_mesh(0, 0).triangle_count(), 0u);
    ASSERT_EQ(soil.loose_soil(0, 0).size(), 1u);
    EXPECT_EQ(soil.loose_soil(0, 0)[0].volume, 0.9f);
    SurfaceMeshDef def;
    def.layer = SurfaceMeshDef::Layer::terrain;
    SurfaceMesher terrain(tiles, def);
    terrain.update();
    EXPECT_GT(terrain.tile_mesh(1, 0).triangle_count(), 0u);
    // On terrain, and beside other soil, it is meshed.
    tiles.volume(11, 4, 10) = 0.9f;
    tiles.volume(3, 5, 9) = 0.9f;
    tiles.touch(3, 4);
    tiles.touch(11, 4);
    soil.update();
    EXPECT_GT(soil.tile_mesh(0, 0).triangle_count(), 0u);
    EXPECT_TRUE(soil.loose_soil(0, 0).empty());
    EXPECT_GT(soil.tile_mesh(1, 0).triangle_count(), 0u);
}

TEST(SurfaceMesh, pile_thins_out_to_nothing_on_the_floor) {
    VoxelTiles tiles(32, 32, 16);
    tiles.fill_heights([](double x, double y) { return 8 - 0.6 * std::hypot(x - 16, y - 16); });
    const Mesh mesh = mesh_of(tiles);
    EXPECT_EQ(open_edge_count(mesh), 0);
    EXPECT_NEAR(enclosed_volume(mesh), tiles.total_volume(), 0.02 * tiles.total_volume());
}

TEST(SurfaceMesh, soil_ends_below_the_terrain_it_lies_on) {
    // A cone of soil on rock that is not level with a voxel.
    const auto rock = [](double x, double y) { return 5.3 + 0.21 * x + 0.1 * y; };
    const auto soil = [&](double x, double y) {
        return rock(x, y) + std::max(0.0, 5 - 0.6 * std::hypot(x - 16, y - 16));
    };
    VoxelTiles tiles(32, 32, 24);
    tiles.fill_solid_heights(rock);
    tiles.for_each_voxel([&](int x, int y, int z) {
        const double top = std::clamp(soil(x + 0.5, y + 0.5) - z, 0.0, 1.0);
        tiles.volume(x, y, z) = std::max(0.0f, static_cast<float>(top) - tiles.solid(x, y, z));
    });
    const Mesh mesh = mesh_of(tiles);
    EXPECT_EQ(open_edge_count(mesh), 0);
    double rim = 1e9;  // how deep below the rock the soil's edge is
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 p = vertex(mesh, v);
        EXPECT_LT(p.z, soil(p.x, p.y) + 0.35);
        // The cone ends 8.3 voxels from its axis; a trace too thin to show may take off one more.
        if (std::hypot(p.x - 16, p.y - 16) > 9.5) rim = std::min(rim, rock(p.x, p.y) - p.z);
    }
    EXPECT_GT(rim, 0);
}

TEST(SurfaceMesh, level_ground_meets_a_rock_wall_without_a_gap_or_a_bump) {
    VoxelTiles tiles(24, 24, 24);
    tiles.for_each_voxel([&](int x, int y, int z) {
        if (x >= 12) {
            tiles.solid(x, y, z) = z < 18;
        } else {
            tiles.volume(x, y, z) = z < 9 ? 1.0f : z == 9 ? 0.4f : 0.0f;
        }
    });
    const Mesh mesh = mesh_of(tiles);
    EXPECT_EQ(open_edge_count(mesh), 0);
    double reach = 0;
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 p = vertex(mesh, v);
        EXPECT_LT(p.z, 9.401);
        if (p.z > 9.3) reach = std::max(reach, p.x);
    }
    EXPECT_GT(reach, 12.4);  // the rock's face is at 12
}

TEST(SurfaceMesh, vertices_have_the_colour_of_their_material) {
    VoxelTiles tiles(16, 16, 16);
    tiles.fill_heights([](double, double) { return 6.5; });
    tiles.for_each_voxel([&](int x, int y, int z) { tiles.material(x, y, z) = z >= 5; });
    const Mesh mesh = mesh_of(tiles);
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        const double z = mesh.positions[3 * v + 2];
        if (z > 5.6) {
            EXPECT_FLOAT_EQ(mesh.colors[3 * v], 0.1f);
        }
        if (z < 4.4) {
            EXPECT_FLOAT_EQ(mesh.colors[3 * v], tiles.materials()[0].color[0]);
        }
    }
}

TEST(SurfaceMesh, far_from_the_worlds_origin_a_mesh_has_one_of_its_own) {
    VoxelTiles tiles(12, 9, 8);
    tiles.frame().voxel_m = 0.05;
    tiles.fill_heights([](double x, double y) { return 2 + 0.3 * x - 0.1 * y; });
    Mesh near, far;
    SurfaceMesher at_origin(tiles);
    at_origin.update();
    at_origin.gather(near);
    SurfaceMeshDef def;
    def.origin_m = tiles.frame().grid_to_world.position = {5e6, -4e5, 10};
    SurfaceMesher far_out(tiles, def);
    far_out.update();
    far_out.gather(far);
    EXPECT_EQ(far.positions, near.positions);
    EXPECT_EQ(far_out.origin_m(), def.origin_m);
}

TEST(SurfaceMesh, a_film_on_rock_has_a_colour_of_its_own) {
    VoxelTiles tiles(8, 8, 8);
    tiles.fill_solid_heights([](double, double) { return 4; });
    tiles.for_each_voxel([&](int x, int y, int z) {
        if (z == 4) tiles.volume(x, y, z) = 0.03f;
        tiles.material(x, y, z) = z == 4 ? 1 : 0;
    });
    SurfaceMesher mesher(tiles);
    mesher.update();
    const Mesh& mesh = mesher.tile_mesh(0, 0);
    ASSERT_GT(mesh.vertex_count(), 0u);
    for (size_t i = 0; i < mesh.colors.size(); ++i) {
        EXPECT_EQ(mesh.colors[i], tiles.materials()[1].color[i % 3]);
    }
}

TEST(SurfaceMesh, mesh_is_in_world_axes_and_metres) {
    VoxelTiles tiles(16, 8, 16);
    tiles.fill_heights([](double, double) { return 6.0; });
    tiles.frame().voxel_m = 0.25;
    const double half = std::sqrt(0.5);  // grid z to world y
    tiles.frame().grid_to_world = {{1, 2, 3}, {-half, 0, 0, half}};
    const Mesh mesh = mesh_of(tiles);
    Vec3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 p = vertex(mesh, v);
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        if (p.y > 3.4 && p.x > 2 && p.x < 4 && p.z > 1.5 && p.z < 2.5) {
            EXPECT_NEAR(normal(mesh, v).y, 1, 1e-5);
        }
    }
    EXPECT_NEAR(low.x, 1, 1e-6);
    EXPECT_NEAR(high.x, 5, 1e-6);
    EXPECT_NEAR(low.y, 2, 1e-6);
    EXPECT_NEAR(high.y, 3.5, 1e-6);
    EXPECT_NEAR(low.z, 1, 1e-6);
    EXPECT_NEAR(high.z, 3, 1e-6);
    EXPECT_NEAR(enclosed_volume(mesh), 4 * 1.5 * 2, 1e-4);
}

TEST(SurfaceMesh, open_floor_leaves_out_only_the_floor) {
    VoxelTiles tiles(16, 16, 16);
    tiles.fill_heights([](double, double) { return 6.5; });
    const Mesh closed = mesh_of(tiles), open = mesh_of(tiles, {.close_floor = false});
    EXPECT_EQ(open_edge_count(closed), 0);
    EXPECT_GT(floor_triangle_count(closed), 0);
    EXPECT_EQ(floor_triangle_count(open), 0);
    EXPECT_EQ(open.triangle_count(), closed.triangle_count() - floor_triangle_count(closed));
}

TEST(SurfaceMesh, most_triangles_are_the_grounds_top) {
    VoxelTiles tiles(64, 64, 48);
    tiles.fill_heights(
        [](double x, double y) { return 30 + std::sin(0.3 * x) + std::cos(0.2 * y); });
    const Mesh mesh = mesh_of(tiles);
    EXPECT_EQ(open_edge_count(mesh), 0);
    size_t top_count = 0;
    for (size_t t = 0; t < mesh.triangle_count(); ++t) {
        top_count += normal(mesh, mesh.indices[3 * t]).z > 0.5;
    }
    EXPECT_GE(top_count, 2 * 65 * 65u);
    // Square by square the floor has as many again, and the sides as many as the ground is deep.
    EXPECT_LT(mesh.triangle_count() - top_count, top_count / 3);
}

TEST(SurfaceMesh, layers_of_materials_end_where_they_end_on_the_sides) {
    VoxelTiles tiles(24, 24, 24);
    tiles.fill_heights([](double, double) { return 20.0; });
    const auto border = [](int x) { return 5 + x / 3; };
    tiles.for_each_voxel(
        [&](int x, int y, int z) { tiles.material(x, y, z) = z < border(x) ? 0 : 1; });
    const Mesh mesh = mesh_of(tiles);
    const auto& lower = tiles.materials()[0].color;
    int lower_count = 0, upper_count = 0;
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
        const Vec3 p = vertex(mesh, v);
        if (p.y > 0 || p.z <= 0 || p.z > 19 || p.x < 1 || p.x > 23) continue;
        const bool is_lower = mesh.colors[3 * v] == lower[0];
        (is_lower ? lower_count : upper_count)++;
        EXPECT_EQ(is_lower, p.z < border(static_cast<int>(p.x))) << p.x << ", " << p.z;
    }
    EXPECT_GE(lower_count,
              22);  // each column has kept its last of the one and its first of the other
    EXPECT_GE(upper_count, 22);
}

// It goes on into the terrain elsewhere, so that no crack shows: by two voxels, and beside its edge
// in columns of terrain alone.
TEST(SurfaceMesh, soil_ends_on_the_terrain_at_the_sides) {
    for (const double rock : {4.0, 4.4}) {
        VoxelTiles tiles(24, 24, 16);
        tiles.fill_solid_heights([rock](double, double) { return rock; });
        tiles.for_each_voxel([&](int x, int y, int z) {
            const bool has_soil = y > 0 && (x < 8 || x > 11);
            const double above = std::clamp(8.0 - z, 0.0, 1.0) - std::clamp(rock - z, 0.0, 1.0);
            tiles.volume(x, y, z) = has_soil ? static_cast<float>(above) : 0;
        });
        const Mesh mesh = mesh_of(tiles);
        EXPECT_EQ(open_edge_count(mesh), 0);
        double lowest = 16;
        for (size_t v = 0; v < mesh.vertex_count(); ++v) {
            const Vec3 p = vertex(mesh, v);
            EXPECT_GT(p.y, 0) << "that side has rock alone, to " << rock;
            if (p.y == 24) lowest = std::min(lowest, p.z);
        }
        EXPECT_NEAR(lowest, rock, 1e-5);
    }
}

}  // namespace
}  // namespace bsoil::surface_mesh_test
