#include "bsoil/surface_mesh.h"

namespace bsoil {

const GridFrame& SoilTiles::frame() const { return soil_.frame(); }

const std::vector<MaterialDef>& SoilTiles::materials() const { return soil_.materials(); }

uint64_t SoilTiles::tile_revision(int tx, int ty) const { return soil_.tile_revision(tx, ty); }

void SoilTiles::read_tile(int tx, int ty, std::vector<float>& volume, std::vector<float>& solid,
                          std::vector<uint8_t>& material) const {
    soil_.read_tile(tx, ty, volume, solid, material);
}

Vec3 SoilTiles::velocity_m_s(int x, int y, int z) const {
    return soil_.sample(x, y, z).velocity_m_s;
}

Vec3 TileSource::velocity_m_s(int, int, int) const { return {}; }

void SoilTiles::read_terrain(int tx, int ty, std::vector<float>& terrain) const {
    soil_.read_terrain(tx, ty, terrain);
}

void TileSource::read_terrain(int tx, int ty, std::vector<float>& terrain) const {
    std::vector<float> volume;
    std::vector<uint8_t> material;
    read_tile(tx, ty, volume, terrain, material);
}

}  // namespace bsoil
