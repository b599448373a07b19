// Soil is conserved to the unit, and what lies in a voxel is possible.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/layout.h"
#include "check.h"
#include "soil/soil_impl.h"

namespace bsoil {

/// The friend through which tests look into a soil.
struct SoilProbe {
    static const Soil::Impl& impl(const Soil& soil) { return *soil.impl_; }
};

namespace random_worlds {
namespace {

/// Every so many steps all voxels are looked at.
constexpr int kLookEvery = 20;

class UnitsCheck final : public Check {
  public:
    explicit UnitsCheck(const BuiltWorld& world) {
        for (const bullet::SoilAction* soil : world.soils()) {
            const SoilTotals totals = soil->soil().totals();
            units_.push_back(totals.units);
            water_.push_back(totals.water_units);
        }
    }

    void after_step(BuiltWorld& world, Failures& failures) override {
        for (size_t i = 0; i < units_.size(); ++i) {
            const std::vector<int64_t>& filled = world.filled_units()[i];
            for (size_t m = 0; m < filled.size(); ++m) units_[i][m] += filled[m];
            water_[i] += world.filled_water_units()[i];
        }
        if (world.step_count() % kLookEvery == 0) look(world, failures);
    }
    void at_end(BuiltWorld& world, bool, Failures& failures) override { look(world, failures); }

  private:
    void look(BuiltWorld& world, Failures& failures) {
        for (size_t i = 0; i < units_.size(); ++i) {
            const Soil& soil = world.soil(static_cast<int>(i)).soil();
            const std::string name = fmt::format("soil {}", i);
            const SoilTotals now = soil.totals();
            std::vector<int64_t> due = units_[i];
            for (size_t m = 0; m < due.size(); ++m) due[m] += now.units_in[m] - now.units_out[m];
            if (now.units != due) {
                failures.add("units", name, world.time_s(), fmt::format("{}", due),
                             fmt::format("{}", now.units));
            }
            const int64_t water_due = water_[i] + now.water_units_in - now.water_units_out;
            if (now.water_units != water_due) {
                failures.add("water", name, world.time_s(), fmt::format("{}", water_due),
                             fmt::format("{}", now.water_units));
            }
            look_at_voxels(soil, name, world.time_s(), failures);
        }
    }
    static void look_at_voxels(const Soil& soil, const std::string& name, double time_s,
                               Failures& failures) {
        const Soil::Impl& s = SoilProbe::impl(soil);
        TileVoxels voxels;
        const int materials = static_cast<int>(soil.materials().size());
        const bool has_water = s.water.is_there();
        for (int tile = 0; tile < s.tiles_x * s.tiles_y; ++tile) {
            if (!s.tiles[static_cast<size_t>(tile)]) continue;
            s.tiles.read_voxels(tile, voxels);
            for (int z = 0; z < voxels.height; ++z) {
                for (int column = 0; column < 64; ++column) {
                    const int32_t terrain = voxels.at(kKeptTerrain, z, column);
                    const int32_t volume = voxels.at(kKeptVolume, z, column);
                    const int32_t bond = voxels.at(kKeptBond, z, column);
                    int64_t mass = 0;
                    bool is_negative = terrain < 0 || volume < 0 || bond < 0;
                    for (int m = 0; m < materials; ++m) {
                        const int32_t amount = voxels.at(kKeptMaterial + m, z, column);
                        is_negative |= amount < 0;
                        mass += amount;
                    }
                    const int32_t water =
                        has_water ? voxels.at(kKeptMaterial + materials, z, column) : 0;
                    is_negative |= water < 0;
                    const int x = tile % s.tiles_x * 8 + column % 8,
                              y = tile / s.tiles_x * 8 + column / 8;
                    const auto found = [&] {
                        return fmt::format(
                            "voxel ({} {} {}): terrain {} volume {} bond {} mass {} "
                            "water {}",
                            x, y, z, terrain, volume, bond, mass, water);
                    };
                    if (is_negative) {
                        failures.add("amounts", name, time_s, "no amount below 0", found());
                    }
                    if ((volume == 0) != (mass == 0)) {
                        failures.add("mass without volume", name, time_s, "both or none", found());
                    }
                    if ((volume > 0 || mass > 0) &&
                        (x >= s.frame.size[0] || y >= s.frame.size[1] || z >= s.frame.size[2])) {
                        failures.add("outside", name, time_s, "soil within the grid", found());
                    }
                }
            }
        }
    }

    std::vector<std::vector<int64_t>> units_;
    std::vector<int64_t> water_;
};

}  // namespace

std::unique_ptr<Check> make_units_check(const BuiltWorld& world) {
    return std::make_unique<UnitsCheck>(world);
}

}  // namespace random_worlds
}  // namespace bsoil
