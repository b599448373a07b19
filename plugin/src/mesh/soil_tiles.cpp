#include <algorithm>
#include <cmath>

#include "bsoil/surface_mesh.h"
#include "mesh/soil_color.h"

namespace bsoil {
namespace {

constexpr double kWeightStep = 17;  ///< 255 has fifteen of them: no one sees a finer one

/// Soil with this cohesion makes no dust [Pa]: half of what moist sand has. Nor does soil in whose
/// pores there is this share of water: it bridges the finest grains first.
constexpr double kDustCohesion = 500, kDustSaturation = 0.1;

using Shares = std::array<double, limits::kMaterialCapacity>;

/// By volume, of materials at the density that they are placed with.
Shares volume_shares(const Soil& soil, int x, int y, int z) {
    Shares shares = soil.material_shares(x, y, z);
    double sum = 0;
    for (size_t m = 0; m < soil.materials().size(); ++m) {
        sum += shares[m] /= soil.materials()[m].density_kg_m3;
    }
    for (double& share : shares) share /= sum > 0 ? sum : 1;
    return shares;
}

MaterialWeights weights_of(const Shares& shares) {
    MaterialWeights weights{};
    for (size_t m = 0; m < shares.size(); ++m) {
        const double steps = std::round(shares[m] * 255 / kWeightStep);
        weights[m] = static_cast<uint8_t>(steps * kWeightStep);
    }
    return weights;
}

/// What a mixture looks like: the mean of its materials, equation (2) of the Mevea thesis.
MaterialDef mean_material(const std::vector<MaterialDef>& materials, const Shares& shares) {
    const MaterialWeights weights = weights_of(shares);
    MaterialDef mean;
    mean.color = {};
    mean.density_kg_m3 = mean.compacted_density_kg_m3 = 0;
    bool has_range = false;
    float sum = 0;
    for (size_t m = 0; m < materials.size(); ++m) {
        mean.density_kg_m3 += shares[m] * materials[m].density_kg_m3;
        mean.compacted_density_kg_m3 +=
            shares[m] * std::max(materials[m].density_kg_m3, materials[m].compacted_density_kg_m3);
        has_range |= shares[m] > 0 && materials[m].has_density_range();
        sum += weights[m];
        for (size_t c = 0; c < 3; ++c) mean.color[c] += weights[m] * materials[m].color[c];
    }
    if (has_range) mean.loose_density_kg_m3 = mean.density_kg_m3;
    for (float& channel : mean.color) channel /= std::max(1.0f, sum);
    return mean;
}

}  // namespace

const GridFrame& SoilTiles::frame() const { return soil_.frame(); }

const std::vector<MaterialDef>& SoilTiles::materials() const { return soil_.materials(); }

uint64_t SoilTiles::tile_revision(int tx, int ty) const { return soil_.tile_revision(tx, ty); }

void TileSource::read_ahead(std::span<const std::array<int, 2>>) const {}

void SoilTiles::read_ahead(std::span<const std::array<int, 2>> tiles) const {
    soil_.read_ahead(tiles);
}

void SoilTiles::read_tile(int tx, int ty, std::vector<float>& volume, std::vector<float>& solid,
                          std::vector<uint8_t>& material) const {
    soil_.read_tile(tx, ty, volume, solid, material);
}

std::array<float, 3> SoilTiles::color_at(int x, int y, int z, int material) const {
    const VoxelSample sample = soil_.sample_matter(x, y, z);
    const Shares shares = volume_shares(soil_, x, y, z);
    const auto main = static_cast<size_t>(material);
    if (shares[main] >= 1 || shares[main] <= 0) {
        return mesh::worn_color(soil_.materials()[main], sample);
    }
    return mesh::worn_color(mean_material(soil_.materials(), shares), sample);
}

MaterialWeights SoilTiles::weights_at(int x, int y, int z, int material) const {
    const Shares shares = volume_shares(soil_, x, y, z);
    if (shares[static_cast<size_t>(material)] > 0) return weights_of(shares);
    return TileSource::weights_at(x, y, z, material);
}

Vec3 SoilTiles::velocity_m_s(int x, int y, int z) const { return soil_.velocity_m_s(x, y, z); }

GroundMotion SoilTiles::ground_motion(int x, int y) const { return soil_.ground_motion(x, y); }

bool TileSource::has_water() const { return false; }

float TileSource::saturation_at(int, int, int) const { return 0; }

bool SoilTiles::has_water() const {
    return std::ranges::any_of(soil_.materials(),
                               [](const MaterialDef& m) { return m.pore_water_fraction > 0; });
}

float SoilTiles::saturation_at(int x, int y, int z) const {
    return static_cast<float>(soil_.sample_matter(x, y, z).saturation);
}

Backend TileSource::backend() const { return Backend::cpu; }

Backend SoilTiles::backend() const {
    return soil_.backend_name() == "gl" ? Backend::gl : Backend::cpu;
}

Vec3 TileSource::velocity_m_s(int, int, int) const { return {}; }

GroundMotion TileSource::ground_motion(int, int) const { return {}; }

float SoilTiles::dust_at(int x, int y, int z, int material) const {
    const double wet = soil_.sample_matter(x, y, z).saturation / kDustSaturation;
    return static_cast<float>(std::max(0.0, 1 - wet)) * TileSource::dust_at(x, y, z, material);
}

float TileSource::dust_at(int, int, int, int material) const {
    const auto main = std::min(static_cast<size_t>(material), materials().size() - 1);
    return static_cast<float>(std::max(0.0, 1 - materials()[main].cohesion_pa / kDustCohesion));
}

std::array<float, 3> TileSource::color_at(int, int, int, int material) const {
    return materials()[static_cast<size_t>(material)].color;
}

MaterialWeights TileSource::weights_at(int, int, int, int material) const {
    MaterialWeights weights{};
    weights[static_cast<size_t>(material)] = 255;
    return weights;
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
