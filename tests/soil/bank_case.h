/// Banks of cohesive soil, and the heights to which theory lets them stand.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <ostream>

#include "soil_fixture.h"

namespace bsoil::bank_test {

inline constexpr double kDegree = std::numbers::pi / 180;
inline constexpr double kGravity = 9.81;

/// Fills every column to a height of its own [m]: of two points of the map per column one lies in
/// its middle.
inline void fill_columns(Soil& soil, const std::function<double(double x, double y)>& height_m) {
    const GridFrame& frame = soil.frame();
    const int nx = frame.size[0], ny = frame.size[1];
    HeightMapFill fill{2 * nx + 1, 2 * ny + 1, {}, {}};
    for (int y = 0; y <= 2 * ny; ++y) {
        for (int x = 0; x <= 2 * nx; ++x) {
            fill.heights_m.push_back(
                static_cast<float>(height_m(x / 2.0 * frame.voxel_m, y / 2.0 * frame.voxel_m)));
        }
    }
    EXPECT_TRUE(soil.fill(fill));
}

struct BankCase {
    double cohesion_pa, gamma_n_m3, face_deg, voxel_m, yaw_deg;
    double friction_deg = 30;
    double loose_fraction = 0;  ///< of the cohesion, that moved soil keeps
    /// Of the pressure that compacted it, the cohesion of moved soil. Then its density changes.
    double compaction_ratio = 0;

    MaterialDef material() const {
        MaterialDef m = sand(friction_deg, cohesion_pa);
        m.density_kg_m3 = gamma_n_m3 / kGravity;
        m.loose_cohesion_fraction = loose_fraction;
        if (compaction_ratio > 0) {
            m.loose_density_kg_m3 = m.density_kg_m3 / 1.15;
            m.compacted_density_kg_m3 = m.density_kg_m3 * 1.15;
            m.compaction_cohesion_ratio = compaction_ratio;
        }
        return m;
    }
    /// Culmann's height; of a vertical cut 4 c / gamma tan(45 deg + phi / 2).
    double critical_m() const {
        const double beta = face_deg * kDegree, phi = friction_deg * kDegree;
        return 4 * cohesion_pa / gamma_n_m3 * std::sin(beta) * std::cos(phi) /
               (1 - std::cos(beta - phi));
    }
};
inline void PrintTo(const BankCase& c, std::ostream* out) {
    *out << "phi_" << std::lround(c.friction_deg) << "_c_" << c.cohesion_pa << "_face_"
         << c.face_deg << "_voxel_mm_" << c.voxel_m * 1000 << "_yaw_"
         << static_cast<int>(c.yaw_deg);
}

/// A bank `share` of its critical height high, with its foot on the floor and level ground behind.
/// Behind its crest there is more of it than any failing wedge is wide; before its foot there is
/// free floor, `room` times its height and four voxels.
inline std::unique_ptr<Soil> make_bank(const BankCase& c, double share, double room = 0.5) {
    const double height = share * c.critical_m();
    const double face = height / std::tan(c.face_deg * kDegree);
    const double before = room * height + 4 * c.voxel_m;
    const double behind = height / std::tan(c.friction_deg * kDegree) - face + 12 * c.voxel_m;
    const double yaw = c.yaw_deg * kDegree;
    const double length = before + std::max(0.0, face) + behind;
    const int side = static_cast<int>(std::ceil(length / c.voxel_m));
    const int across = c.yaw_deg == 0 ? 8 : std::max(24, side);
    SoilDef def = grid_def(side, across, static_cast<int>(height / c.voxel_m) + 6, c.voxel_m);
    def.material = c.material();
    auto soil = make_soil(def);
    if (!soil) return nullptr;
    const double width = across * c.voxel_m;
    fill_columns(*soil, [&](double x, double y) {
        const double along = (x - length / 2) * std::cos(yaw) + (y - width / 2) * std::sin(yaw);
        const double rise = along + length / 2 - before;
        return face > 1e-9 ? std::clamp(rise / face, 0.0, 1.0) * height : (rise > 0 ? height : 0);
    });
    return soil;
}

/// All soil counts as moved, and all of it is looked at in the next step.
inline void loosen(Soil& soil) {
    Soil::Impl& s = SoilProbe::impl(soil);
    const std::vector<int32_t> none(static_cast<size_t>(s.params.tile_voxels), 0);
    for (int index = 0; index < static_cast<int>(s.tiles.size()); ++index) {
        const int slot = s.tiles.wake(index);
        s.device->write(layout::Buffer::state,
                        int64_t{layout::kPlaneBond} * s.params.plane_stride +
                            int64_t{slot} * s.params.tile_voxels,
                        none);
        s.tiles.note_stale(slot, true);
        for (int z = 0; z < s.blocks_per_tile; ++z) s.lists.activate(s.block_key(index, z));
    }
}

}  // namespace bsoil::bank_test
