// Dense soil stands steeper, and what slides comes to its critical density:
// docs/decisions/dense_slopes.md
#include "bank_case.h"
#include "soil/slip_table.h"

namespace bsoil::dense_slope_test {
namespace {

using namespace bank_test;
using namespace layout;

constexpr double kDensity = 0.6;

/// Sand of phi 33 deg that fills leave at a relative density.
MaterialDef dense_sand(double relative_density) {
    MaterialDef m = materials::dry_sand();
    m.density_kg_m3 =
        1 / std::lerp(1 / m.loose_density_kg_m3, 1 / m.compacted_density_kg_m3, relative_density);
    m.dilatancy_angle_rad = 5 * kDegree;
    return m;
}

// By hand: 5 x 0.6 - 1 = 2 units of dilatancy, 5 deg each.
TEST(PeakFriction, is_boltons) {
    const MaterialDef m = dense_sand(kDensity);
    const std::vector<int32_t> words = peak_frictions(m);
    const auto angle_deg = [&](size_t entry) {
        return std::atan(words[entry] / 65536.0) / kDegree;
    };
    EXPECT_NEAR(angle_deg(0), 33, 1e-2);
    EXPECT_NEAR(angle_deg(6), 33, 1e-2);             // below critical
    EXPECT_NEAR(angle_deg(16), 33 + 5 * 1.5, 1e-2);  // 0.5
    EXPECT_NEAR(angle_deg(32), 33 + 5 * 4, 1e-2);    // 1
    EXPECT_NEAR(dilatancy_index(kDensity), 2, 1e-12);
    EXPECT_EQ(dilatancy_index(kCriticalDensity), 0);
}

struct SlopeCase {
    double voxel_m, yaw_deg;
};
void PrintTo(const SlopeCase& c, std::ostream* out) {
    *out << "voxel_mm_" << c.voxel_m * 1000 << "_yaw_" << static_cast<int>(c.yaw_deg);
}

/// A cut of `face_deg` through level ground, `high` voxels, in the grid's middle.
std::unique_ptr<Soil> make_cut(const MaterialDef& material, const SlopeCase& c, double face_deg,
                               int high) {
    const int side = 3 * high + 8;
    SoilDef def = grid_def(side, c.yaw_deg == 0 ? 8 : side, high + 8, c.voxel_m);
    def.material = material;
    auto soil = make_soil(def);
    if (!soil) return nullptr;
    const double length = side * c.voxel_m, width = def.size_m.y, yaw = c.yaw_deg * kDegree,
                 top = high * c.voxel_m;
    fill_columns(*soil, [&](double x, double y) {
        const double along = (x - length / 2) * std::cos(yaw) + (y - width / 2) * std::sin(yaw);
        return std::clamp(top / 2 + along * std::tan(face_deg * kDegree), 0.0, top);
    });
    return soil;
}

class DenseSlope : public testing::TestWithParam<SlopeCase> {};

// By hand: at a relative density of 0.6 it stands to 33 + 10 deg, and without dilatancy to 33.
TEST_P(DenseSlope, stands_to_its_peak_angle) {
    const MaterialDef dense = dense_sand(kDensity);
    MaterialDef plain = dense;
    plain.dilatancy_angle_rad = 0;
    const auto stands = [&](const MaterialDef& material, double face_deg) {
        auto soil = make_cut(material, GetParam(), face_deg, 12);
        if (!soil) return false;
        const uint64_t checksum = soil->checksum();
        const int64_t units = soil->totals().units[0];
        for (int i = 0; i < 300; ++i) soil->step({});
        EXPECT_EQ(soil->totals().units[0], units);
        EXPECT_EQ(soil->status_bits(), 0u);
        return soil->checksum() == checksum;
    };
    EXPECT_TRUE(stands(dense, 43 - 1.5));
    EXPECT_FALSE(stands(dense, 43 + 1.5));
    EXPECT_FALSE(stands(plain, 43 - 1.5));
    EXPECT_TRUE(stands(plain, 33 - 1.5));
}

INSTANTIATE_TEST_SUITE_P(Cuts, DenseSlope,
                         testing::Values(SlopeCase{0.1, 0}, SlopeCase{0.1, 22.5},
                                         SlopeCase{0.1, 45}, SlopeCase{0.05, 0},
                                         SlopeCase{0.025, 0}),
                         testing::PrintToStringParamName());

// What slides dilates from 0.6 to 0.2, not to 0, and rests at phi.
TEST(FallenCut, comes_to_its_critical_density) {
    const MaterialDef m = dense_sand(kDensity);
    auto soil = make_cut(m, {0.05, 0}, 75, 16);
    ASSERT_TRUE(soil);
    const int64_t units = soil->totals().units[0];
    const auto settled = soil->settle(2400);
    ASSERT_TRUE(settled);
    EXPECT_TRUE(settled->is_at_rest);
    EXPECT_EQ(soil->totals().units[0], units);
    Soil::Impl& s = SoilProbe::impl(*soil);
    double mass = 0, volume = 0;  // of voxels without bond
    TileVoxels voxels;
    for (int index = 0; index < static_cast<int>(s.tiles.size()); ++index) {
        if (!s.tiles[static_cast<size_t>(index)]) continue;
        s.tiles.read_voxels(index, voxels);
        for (int z = 0; z < s.height; ++z) {
            for (int c = 0; c < kTileColumns; ++c) {
                if (voxels.at(kKeptBond, z, c) > 0) continue;
                mass += voxels.at(kKeptMaterial, z, c);
                volume += voxels.at(kKeptVolume, z, c);
            }
        }
    }
    ASSERT_GT(volume, 20 * kVoxelFull);
    const double density = m.relative_density(kReferenceDensity * mass / volume);
    RecordProperty("relative_density", std::to_string(density));
    EXPECT_NEAR(density, kCriticalDensity, 0.02);
}

// Loose soil neither has a peak nor dilates: it rests at phi, with the heights that it has without.
TEST(LooseSlope, knows_no_dilatancy) {
    MaterialDef m = dense_sand(0);
    auto soil = make_cut(m, {0.05, 22.5}, 75, 12);
    m.dilatancy_angle_rad = 0;
    auto plain = make_cut(m, {0.05, 22.5}, 75, 12);
    ASSERT_TRUE(soil && plain);
    for (int i = 0; i < 600; ++i) {
        soil->step({});
        plain->step({});
    }
    double most = 0;
    const GridFrame& frame = soil->frame();
    for (int y = 0; y < frame.size[1]; ++y) {
        for (int x = 0; x < frame.size[0]; ++x) {
            most = std::max(most,
                            std::abs(soil->surface_height_m(x, y) - plain->surface_height_m(x, y)));
        }
    }
    EXPECT_LT(most, 0.05 * frame.voxel_m);
}

}  // namespace
}  // namespace bsoil::dense_slope_test
