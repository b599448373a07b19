/// A grid of voxels in memory, for tests and benchmarks of the mesher.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "bsoil/surface_mesh.h"

namespace bsoil::test {

/// Voxels of soil and terrain with a frame of its own.
class VoxelTiles final : public TileSource {
  public:
    VoxelTiles(int nx, int ny, int nz) {
        frame_.size[0] = nx;
        frame_.size[1] = ny;
        frame_.size[2] = nz;
        frame_.voxel_m = 1;
        materials_.resize(2);
        materials_[1].color = {0.1f, 0.2f, 0.3f};
        const auto count = static_cast<size_t>(nx) * static_cast<size_t>(ny * nz);
        volume_.assign(count, 0);
        solid_.assign(count, 0);
        material_.assign(count, 0);
        revisions_.assign(static_cast<size_t>(tiles(nx) * tiles(ny)), 1);
    }

    const GridFrame& frame() const override { return frame_; }
    GridFrame& frame() { return frame_; }
    const std::vector<MaterialDef>& materials() const override { return materials_; }
    std::vector<MaterialDef>& materials() { return materials_; }
    uint64_t tile_revision(int tx, int ty) const override {
        return revisions_[static_cast<size_t>(ty * tiles(frame_.size[0]) + tx)];
    }
    void touch(int x, int y) {
        ++revisions_[static_cast<size_t>(y / 8 * tiles(frame_.size[0]) + x / 8)];
    }

    /// The same for all voxels.
    void set_velocity(Vec3 velocity_m_s) { velocity_m_s_ = velocity_m_s; }
    Vec3 velocity_m_s(int, int, int) const override { return velocity_m_s_; }
    /// How the soil of columns moves along the ground; as at first, it rests.
    void set_motion(std::function<GroundMotion(int, int)> motion) { motion_ = std::move(motion); }
    GroundMotion ground_motion(int x, int y) const override {
        return motion_ ? motion_(x, y) : GroundMotion{};
    }

    float& volume(int x, int y, int z) { return volume_[index(x, y, z)]; }
    float& solid(int x, int y, int z) { return solid_[index(x, y, z)]; }
    uint8_t& material(int x, int y, int z) { return material_[index(x, y, z)]; }

    /// Column-filled soil: full voxels, then one partial. Height by column centre [voxels].
    void fill_heights(const std::function<double(double, double)>& height) {
        for_each_voxel(
            [&](int x, int y, int z) { volume(x, y, z) = fraction(height(x + 0.5, y + 0.5) - z); });
    }
    void fill_solid_heights(const std::function<double(double, double)>& height) {
        for_each_voxel(
            [&](int x, int y, int z) { solid(x, y, z) = fraction(height(x + 0.5, y + 0.5) - z); });
    }
    /// Soil where inside(x, y, z), by 8 x 8 x 8 inside tests a voxel.
    void fill_shape(const std::function<bool(double, double, double)>& inside) {
        for_each_voxel([&](int x, int y, int z) {
            int count = 0;
            for (int s = 0; s < 512; ++s) {
                count += inside(x + (s % 8 + 0.5) / 8, y + (s / 8 % 8 + 0.5) / 8,
                                z + (s / 64 + 0.5) / 8);
            }
            volume(x, y, z) = static_cast<float>(count) / 512;
        });
    }
    double total_volume() const {
        double sum = 0;
        for (const float v : volume_) sum += v;
        return sum;
    }
    void for_each_voxel(const std::function<void(int, int, int)>& visit) {
        for (int z = 0; z < frame_.size[2]; ++z) {
            for (int y = 0; y < frame_.size[1]; ++y) {
                for (int x = 0; x < frame_.size[0]; ++x) visit(x, y, z);
            }
        }
    }

    void read_tile(int tx, int ty, std::vector<float>& volume, std::vector<float>& solid,
                   std::vector<uint8_t>& material) const override {
        const auto count = static_cast<size_t>(64 * frame_.size[2]);
        volume.assign(count, 0);
        solid.assign(count, 0);
        material.assign(count, 0);
        const int x_count = std::min(8, frame_.size[0] - 8 * tx);
        const int y_count = std::min(8, frame_.size[1] - 8 * ty);
        for (int z = 0; z < frame_.size[2]; ++z) {
            for (int y = 0; y < y_count; ++y) {
                const size_t from = index(8 * tx, 8 * ty + y, z);
                const auto to = static_cast<size_t>(z * 64 + y * 8);
                std::copy_n(&volume_[from], x_count, &volume[to]);
                std::copy_n(&solid_[from], x_count, &solid[to]);
                std::copy_n(&material_[from], x_count, &material[to]);
            }
        }
    }

  private:
    static int tiles(int n) { return (n + 7) / 8; }
    static float fraction(double v) { return static_cast<float>(std::clamp(v, 0.0, 1.0)); }
    size_t index(int x, int y, int z) const {
        return static_cast<size_t>((z * frame_.size[1] + y) * frame_.size[0] + x);
    }

    GridFrame frame_;
    std::vector<MaterialDef> materials_;
    std::vector<float> volume_, solid_;
    std::vector<uint8_t> material_;
    std::vector<uint64_t> revisions_;
    std::function<GroundMotion(int, int)> motion_;
    Vec3 velocity_m_s_;
};

/// Other tiles, for sources that say more of the same soil.
class SameTiles : public TileSource {
  public:
    explicit SameTiles(const VoxelTiles& tiles) : tiles_(tiles) {}
    const GridFrame& frame() const override { return tiles_.frame(); }
    const std::vector<MaterialDef>& materials() const override { return tiles_.materials(); }
    uint64_t tile_revision(int tx, int ty) const override { return tiles_.tile_revision(tx, ty); }
    void read_tile(int tx, int ty, std::vector<float>& volume, std::vector<float>& solid,
                   std::vector<uint8_t>& material) const override {
        tiles_.read_tile(tx, ty, volume, solid, material);
    }

  private:
    const VoxelTiles& tiles_;
};

}  // namespace bsoil::test
