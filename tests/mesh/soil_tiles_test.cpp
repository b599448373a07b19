#include <gtest/gtest.h>

#include "bsoil/surface_mesh.h"
#include "mesh_checks.h"

namespace bsoil {
namespace {

TEST(SoilTiles, box_of_soil_meshes_to_its_own_volume_with_either_axis_up) {
    for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
        SoilDef def;
        def.size_m = up == UpAxis::y ? Vec3{2, 1, 1.5} : Vec3{2, 1.5, 1};
        def.up = up;
        def.backend = Backend::cpu;
        Result<std::unique_ptr<Soil>> soil = Soil::create(def);
        ASSERT_TRUE(soil) << soil.error();
        // Level ground to 0.42 m over the whole grid: a partial voxel on top.
        const Vec3 top = up == UpAxis::y ? Vec3{2, 0.42, 2} : Vec3{2, 2, 0.42};
        const Status filled = (*soil)->fill(BoxFill{{{-2, -2, -2}, top}, {}});
        ASSERT_TRUE(filled) << filled.error();
        const SoilTiles tiles(**soil);
        SurfaceMesher mesher(tiles);
        mesher.update();
        Mesh mesh;
        mesher.gather(mesh);
        EXPECT_EQ(test::open_edge_count(mesh), 0);
        EXPECT_NEAR(test::enclosed_volume(mesh), 2 * 1.5 * 0.42, 0.01);
        double highest = 0;
        for (size_t v = 0; v < mesh.vertex_count(); ++v) {
            const Vec3 p = test::vertex(mesh, v);
            highest = std::max(highest, up == UpAxis::y ? p.y : p.z);
        }
        // Whether a voxel is inside is found by sampling: a quarter of 5 cm.
        EXPECT_NEAR(highest, 0.42, 0.0125);
    }
}

}  // namespace
}  // namespace bsoil
