/// Dust over soil that moves fast.
#include <algorithm>
#include <cmath>

#include "bsoil/render/renderer.h"
#include "random_share.h"

namespace bsoil::render {
namespace {

/// Where there is most dust every other voxel has a cloud: they are several voxels wide. Where there
/// is less there are fewer and thinner ones.
constexpr double kDustyShare = 0.5;
/// Soil makes no dust below the first speed and most above the second [m/s]. A fall of 0.1 m ends
/// at 1.4 m/s, one of 1 m at 4.4 m/s.
constexpr double kFallBegin = 1.4, kFallMost = 4.4;
/// Most dust is made where soil lands: so near to the ground [voxels]. Higher up it is this share.
constexpr float kLandsWithin = 4;
constexpr double kFallDust = 0.15;
/// Soil that rolls stays at the ground and stirs up less, this share at most.
constexpr double kRollBegin = 1.0, kRollMost = 4.0, kRollDust = 0.1;
constexpr float kStrengthLeast = 0.2f;

double within(double value, double begin, double most) {
    return std::clamp((value - begin) / (most - begin), 0.0, 1.0);
}

}  // namespace

void append_dust(const SurfaceMesher& mesher, std::vector<DustPuff>& dust) {
    const auto append = [&dust](const auto& soil, double strength, uint32_t seed) {
        DustPuff puff;
        puff.strength = std::sqrt(static_cast<float>(strength) * soil.dust);
        if (puff.strength < kStrengthLeast) return;
        if (random_share(seed) > kDustyShare * static_cast<double>(puff.strength)) return;
        puff.center = soil.center_m;
        puff.velocity_m_s = soil.velocity_m_s;
        puff.side_m = soil.side_m;
        puff.color = soil.color;
        puff.seed = seed;
        dust.push_back(puff);
    };
    for (int ty = 0; ty < mesher.tile_count_y(); ++ty) {
        for (int tx = 0; tx < mesher.tile_count_x(); ++tx) {
            for (const LooseVoxel& voxel : mesher.loose_soil(tx, ty)) {
                const double thick = std::min(1.0, 5 * static_cast<double>(voxel.volume));
                const double speed = length(voxel.velocity_m_s);
                const bool lands = voxel.height_m < kLandsWithin * voxel.side_m;
                append(voxel,
                       (lands ? 1.0 : kFallDust) * thick * within(speed, kFallBegin, kFallMost),
                       2 * voxel.seed);
            }
            for (const RollingSoil& soil : mesher.rolling_soil(tx, ty)) {
                const double speed = length(soil.velocity_m_s);
                append(soil,
                       kRollDust * static_cast<double>(soil.amount) *
                           within(speed, kRollBegin, kRollMost),
                       2 * soil.seed + 1);
            }
        }
    }
}

}  // namespace bsoil::render
