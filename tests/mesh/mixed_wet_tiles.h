// Tiles with all that a mesh can show, for tests that compare two ways to mesh them.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "voxel_tiles.h"

namespace bsoil::test {

/// Two materials that mix and water, by the voxel's place.
class MixedWetTiles final : public SameTiles {
  public:
    using SameTiles::SameTiles;
    MaterialWeights weights_at(int x, int y, int z, int) const override {
        MaterialWeights weights{};
        weights[0] = static_cast<uint8_t>(8 * ((x + z / 3) % 5));
        weights[1] = static_cast<uint8_t>(8 * (y % 4 + 1));
        return weights;
    }
    bool has_water() const override { return true; }
    float saturation_at(int x, int y, int z) const override {
        return static_cast<float>((x + y + z) % 9) / 8;
    }
};

/// Random voxels: every case of every cell.
inline void fill_with_noise(VoxelTiles& tiles, std::mt19937& random, bool has_solid) {
    std::uniform_real_distribution<float> fill(-0.6f, 1.0f);
    std::uniform_int_distribution<int> material(0, 1);
    tiles.for_each_voxel([&](int x, int y, int z) {
        const float soil = std::max(0.0f, fill(random));
        tiles.volume(x, y, z) = soil;
        tiles.material(x, y, z) = static_cast<uint8_t>(material(random));
        if (has_solid) tiles.solid(x, y, z) = std::min(1 - soil, std::max(0.0f, fill(random)));
    });
}

inline void fill_with_hills(VoxelTiles& tiles, double phase) {
    const int nz = tiles.frame().size[2];
    tiles.fill_heights([&](double x, double y) {
        return 0.5 * nz + 0.3 * nz * std::sin(0.37 * x + phase) * std::cos(0.29 * y) -
               (x > 11 && x < 15 ? 9 : 0);
    });
    tiles.for_each_voxel([&](int x, int y, int z) {
        tiles.material(x, y, z) = static_cast<uint8_t>(z < 0.4 * nz + 0.1 * x);
    });
}

}  // namespace bsoil::test
