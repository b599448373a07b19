#include "bsoil/surface_mesh.h"
#include "mesh/soil_color.h"

namespace bsoil {

const GridFrame& SoilTiles::frame() const { return soil_.frame(); }

const std::vector<MaterialDef>& SoilTiles::materials() const { return soil_.materials(); }

uint64_t SoilTiles::tile_revision(int tx, int ty) const { return soil_.tile_revision(tx, ty); }

void SoilTiles::read_tile(int tx, int ty, std::vector<float>& volume, std::vector<float>& solid,
                          std::vector<uint8_t>& material) const {
    soil_.read_tile(tx, ty, volume, solid, material);
}

std::array<float, 3> SoilTiles::color_at(int x, int y, int z, int material) const {
    const MaterialDef& main = soil_.materials()[static_cast<size_t>(material)];
    return mesh::worn_color(main, soil_.sample(x, y, z));
}

Vec3 SoilTiles::velocity_m_s(int x, int y, int z) const {
    return soil_.sample(x, y, z).velocity_m_s;
}

Vec3 TileSource::velocity_m_s(int, int, int) const { return {}; }

std::array<float, 3> TileSource::color_at(int, int, int, int material) const {
    return materials()[static_cast<size_t>(material)].color;
}

void SoilTiles::read_terrain(int tx, int ty, std::vector<float>& terrain) const {
    soil_.read_terrain(tx, ty, terrain);
}

void TileSource::read_terrain(int tx, int ty, std::vector<float>& terrain) const {
    std::vector<float> volume;
    std::vector<uint8_t> material;
    read_tile(tx, ty, volume, terrain, material);
}

}  // namespace bsoil
