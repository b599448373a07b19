#include <cmath>

#include "../mesh/mesh_checks.h"
#include "../mesh/voxel_tiles.h"
#include "targets.h"

namespace bsoil::fuzz {

void fuzz_surface_mesher(Bytes bytes) {
    Choices choices(bytes);
    const int nx = 1 + choices.below(40), ny = 1 + choices.below(40), nz = 1 + choices.below(40);
    test::VoxelTiles tiles(nx, ny, nz);
    SurfaceMeshDef def;
    if (choices.flag()) def.layer = SurfaceMeshDef::Layer::terrain;
    SurfaceMesher mesher(tiles, def);
    Mesh mesh;
    std::vector<uint8_t> levels(
        static_cast<size_t>(mesher.tile_count_x()) * static_cast<size_t>(mesher.tile_count_y()), 0);
    for (int round = 0; round < 3; ++round) {
        for (int i = 0; i < 20 && !choices.at_end(); ++i) {
            const int x = choices.below(nx), y = choices.below(ny);
            const int low = choices.below(nz), high = choices.below(nz);
            const float soil = static_cast<float>(choices.below(256)) / 200;
            const float solid = static_cast<float>(choices.below(256)) / 255;
            for (int z = low; z <= high; ++z) {
                tiles.volume(x, y, z) = soil;
                tiles.solid(x, y, z) = std::min(solid, std::max(0.0f, 1 - soil));
                tiles.material(x, y, z) = static_cast<uint8_t>(choices.below(2));
            }
            tiles.touch(x, y);
        }
        for (uint8_t& level : levels) {
            level = static_cast<uint8_t>(choices.below(SurfaceMesher::kLevelMost + 1));
        }
        mesher.update(levels);
        mesher.gather(mesh);
        require(test::open_edge_count(mesh) == 0, "the surface is open");
        for (const auto* list : {&mesh.positions, &mesh.normals, &mesh.colors}) {
            for (const float value : *list) require(std::isfinite(value), "a vertex is not finite");
        }
    }
    SurfaceMesher fresh(tiles, def);
    fresh.update(levels);
    Mesh whole;
    fresh.gather(whole);
    require(whole.positions == mesh.positions && whole.indices == mesh.indices,
            "a mesh brought up to date differs from a new one");
}

}  // namespace bsoil::fuzz
