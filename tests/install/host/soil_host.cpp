// A host of the soil alone, without Bullet, and of the pictures: a mesh of a heap, a file of one
// pixel.
#include <bsoil/render/image.h>
#include <bsoil/soil.h>
#include <bsoil/surface_mesh.h>
#include <bsoil/version.h>

#include <cstdio>
#include <cstring>

int main() {
    if (std::strcmp(bsoil::version(), BSOIL_VERSION) != 0 ||
        bsoil::version_number() != BSOIL_VERSION_NUMBER) {
        return 3;
    }
    bsoil::SoilDef def;
    def.size_m = {1, 1, 1};
    auto soil = bsoil::Soil::create(def);
    if (!soil) return std::printf("%s\n", soil.error().c_str()), 2;
    if (!(*soil)->fill(bsoil::CylinderFill{{0, 0, 0}, 0.2, 0.4, "dry_sand"})) return 2;
    (*soil)->step({});
    const bsoil::SoilTiles tiles(**soil);
    bsoil::SurfaceMesher mesher(tiles);
    mesher.update();
    bsoil::Mesh mesh;
    mesher.gather(mesh);
    std::printf("%zu triangles\n", mesh.triangle_count());
    const bsoil::render::Image pixel{1, 1, {194, 168, 115, 255}};
    return mesh.triangle_count() > 0 && bsoil::render::write_png(pixel, "pixel.png") ? 0 : 1;
}
