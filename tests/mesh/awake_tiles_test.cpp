/// Ground that sleeps, drawn coarsely to the horizon, around the few tiles where a body digs.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "bsoil/body.h"
#include "bsoil/soil.h"
#include "bsoil/surface_mesh.h"
#include "mesh_checks.h"

namespace bsoil::awake_tiles_test {
namespace {

/// 64 m of ground in voxels of 0.1 m, 6400 tiles, and a blade that is drawn through its middle.
struct LargeGround {
    std::unique_ptr<Soil> soil;
    std::vector<ConvexShape> shapes;
    SoilBody blade;

    LargeGround() {
        SoilDef def;
        def.size_m = {64, 64, 1.6};
        def.voxel_m = 0.1;
        def.up = UpAxis::z;
        def.backend = Backend::cpu;
        auto made = Soil::create(def);
        EXPECT_TRUE(made) << made.error();
        soil = std::move(*made);
        EXPECT_TRUE(soil->fill(BoxFill{{{-33, -33, 0}, {33, 33, 0.8}}, {}}));
        blade.id = 1;
        ConvexShape box;
        box.half_extents_m = {0.15, 1.0, 0.4};
        shapes.push_back(box);
        blade.shapes = &shapes;
        blade.pose.position = {-1, 0, 0.9};
    }
    void step() {
        blade.linear_velocity_m_s = {1.5, 0, 0};
        blade.pose.position.x += 1.5 / 60;
        blade.center_of_mass_m = blade.pose.position;
        soil->step({&blade, 1});
    }
};

/// What an eye over the blade may see coarsely, at 1000 pixels for 50 degrees.
SurfaceDetail seen_from_above_the_blade() { return {{-4, -4, 3}, 3e-3, 1e-4}; }

TEST(AwakeTiles, meet_the_sleeping_ground_to_the_horizon_without_a_seam) {
    LargeGround ground;
    const SoilTiles tiles(*ground.soil);
    SurfaceMesher mesher(tiles);
    mesher.update(seen_from_above_the_blade());
    Mesh mesh;
    mesher.gather(mesh);
    const size_t at_rest = mesh.triangle_count();
    EXPECT_LT(at_rest, 60'000u);  // of 640 x 640 columns
    int built_most = 0;
    for (int step = 0; step < 60; ++step) {
        ground.step();
        const SurfaceMeshReport report = mesher.update(seen_from_above_the_blade());
        built_most = std::max(built_most, report.tile_built_count);
        if (step % 10 != 9) continue;
        mesher.gather(mesh);
        ASSERT_EQ(test::open_edge_count(mesh), 0) << step;
    }
    // The blade is in 3 x 2 tiles; what it pushes, what they touch and where levels change is
    // some more: 3 % of all.
    EXPECT_LT(built_most, 200);
    EXPECT_EQ(mesher.tile_level(40, 40), 0);
    EXPECT_EQ(mesher.tile_level(2, 2), SurfaceMesher::kLevelMost);
    EXPECT_EQ(mesher.tile_level(78, 60), SurfaceMesher::kLevelMost);
    EXPECT_LT(mesh.triangle_count(), at_rest + 40'000);
}

TEST(AwakeTiles, a_host_that_copies_what_changed_has_the_whole_mesh) {
    LargeGround ground;
    const SoilTiles tiles(*ground.soil);
    SurfaceMesher mesher(tiles);
    std::map<std::pair<int, int>, Mesh> copies;  // of a host's own renderer
    size_t copied = 0;
    for (int step = 0; step < 30; ++step) {
        const SurfaceMeshReport report = mesher.update(seen_from_above_the_blade());
        EXPECT_EQ(mesher.changed_tiles().size(), static_cast<size_t>(report.tile_built_count));
        mesher.visit_changed([&](int tx, int ty, const Mesh& mesh) {
            copies[{tx, ty}] = mesh;
            copied += step > 0;
        });
        ground.step();
    }
    EXPECT_GT(copied, 100u);
    EXPECT_LT(copied, 29u * 120u);
    mesher.update(seen_from_above_the_blade());
    mesher.visit_changed([&](int tx, int ty, const Mesh& mesh) { copies[{tx, ty}] = mesh; });
    for (int ty = 0; ty < mesher.tile_count_y(); ++ty) {
        for (int tx = 0; tx < mesher.tile_count_x(); ++tx) {
            const Mesh& copy = copies[{tx, ty}];
            ASSERT_EQ(copy.indices, mesher.tile_mesh(tx, ty).indices) << tx << ", " << ty;
            ASSERT_EQ(copy.positions, mesher.tile_mesh(tx, ty).positions) << tx << ", " << ty;
        }
    }
    mesher.update(seen_from_above_the_blade());
    EXPECT_TRUE(mesher.changed_tiles().empty());
}

}  // namespace
}  // namespace bsoil::awake_tiles_test
