#include "soil_volume.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bsoil/surface_mesh.h"

namespace bsoil::scene {
namespace {

constexpr int kTileSide = 8;
/// How far one sees, in voxels: into soil not at all, through a field some way.
/// Soil begins where its surface does: half way between a full voxel and an empty one.
constexpr double kSoilThreshold = 0.5;
constexpr double kSoilSight = 0.3, kFieldSight = 6;

uint8_t byte_of(double share) {
    return static_cast<uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

int tile_count(int size) { return (size + kTileSide - 1) / kTileSide; }

}  // namespace

SoilVolume::SoilVolume(const Soil& soil, const SoilVolumeDef& def)
    : soil_(soil), def_(def), field_(soil, def.field, def.low, def.high) {
    const GridFrame& frame = soil.frame();
    size_t count = 4;
    for (int axis = 0; axis < 3; ++axis) {
        data_.size[axis] = frame.size[axis];
        count *= static_cast<size_t>(frame.size[axis]);
    }
    data_.rgba.assign(count, 0);
    revisions_.assign(static_cast<size_t>(tile_count(frame.size[0])) *
                          static_cast<size_t>(tile_count(frame.size[1])),
                      0);
}

bool SoilVolume::update() {
    bool changed = is_new_;
    for (int ty = 0; ty < tile_count(data_.size[1]); ++ty) {
        for (int tx = 0; tx < tile_count(data_.size[0]); ++tx) {
            uint64_t& known = revisions_[static_cast<size_t>(ty * tile_count(data_.size[0]) + tx)];
            const uint64_t revision = soil_.tile_revision(tx, ty);
            if (!is_new_ && known == revision) continue;
            known = revision;
            changed |= read_tile(tx, ty);
        }
    }
    is_new_ = false;
    return changed;
}

bool SoilVolume::read_tile(int tx, int ty) {
    bool changed = false;
    const int x_end = std::min(data_.size[0], kTileSide * (tx + 1)),
              y_end = std::min(data_.size[1], kTileSide * (ty + 1));
    for (int z = 0; z < data_.size[2]; ++z) {
        for (int y = kTileSide * ty; y < y_end; ++y) {
            for (int x = kTileSide * tx; x < x_end; ++x) {
                const auto row = static_cast<size_t>(z) * static_cast<size_t>(data_.size[1]) +
                                 static_cast<size_t>(y);  // beyond an int where grids are large
                const size_t v =
                    4 * (row * static_cast<size_t>(data_.size[0]) + static_cast<size_t>(x));
                const std::array<uint8_t, 4> now = texel(x, y, z);
                changed |= !std::equal(now.begin(), now.end(), &data_.rgba[v]);
                std::copy(now.begin(), now.end(), &data_.rgba[v]);
            }
        }
    }
    return changed;
}

std::array<uint8_t, 4> SoilVolume::texel(int x, int y, int z) const {
    const VoxelSample sample = soil_.sample(x, y, z);
    std::array<float, 3> color{};
    double hides = 0;
    if (def_.field == Field::none) {
        if (sample.volume <= 0) return {};
        color = SoilTiles(soil_).color_at(x, y, z, sample.material);
        hides = sample.volume;
    } else {
        const std::optional<double> value = field_.value(sample);
        if (!value) return {};
        color = field_.color(*value, sample);
        const double much = def_.field == Field::material ? 1 : field_.fraction(*value);
        const bool is_soil = def_.field != Field::coverage;
        hides = much * (is_soil ? std::min(1.0, sample.volume) : 1.0);
    }
    std::array<uint8_t, 4> texel{};
    for (size_t c = 0; c < 3; ++c) texel[c] = byte_of(std::sqrt(static_cast<double>(color[c])));
    texel[3] = byte_of(hides);
    return texel;
}

render::Volume SoilVolume::placed() const {
    const GridFrame& frame = soil_.frame();
    render::Volume volume;
    volume.pose = frame.grid_to_world;
    volume.voxel_m = frame.voxel_m;
    const double sight = def_.field == Field::none ? kSoilSight : kFieldSight;
    if (def_.field == Field::none) volume.threshold = kSoilThreshold;
    volume.sight_m = def_.sight_m > 0 ? def_.sight_m : sight * frame.voxel_m;
    return volume;
}

}  // namespace bsoil::scene
