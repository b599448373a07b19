// Groundwater: soil below its table is full, suction holds and lifts water above it, and the
// account is exact.
#include <numbers>

#include "ploughed_bed.h"

namespace bsoil::groundwater_test {
namespace {

/// Sand whose dry pores draw water up by 4 c / (tan phi rho g): 0.353 m.
MaterialDef fringe_sand(double saturation) {
    MaterialDef material = sand(30);
    material.pore_water_fraction = 0.2;
    material.placed_saturation = saturation;
    material.moist_cohesion_pa = 500;
    material.conductivity_m_s = 1e-3;
    return material;
}
const double kFringeM = 4 * 500 / std::tan(std::numbers::pi / 6) / (1000 * 9.81);

constexpr double kTableM = 0.23, kDeepM = 0.8;

/// A level bed over groundwater.
std::unique_ptr<Soil> bed(const MaterialDef& material, double voxel_m = 0.05,
                          double table_m = kTableM, const SoilDef& weather = {}) {
    SoilDef def = grid_def(8, 8, static_cast<int>(1.2 / voxel_m), voxel_m);
    def.material = material;
    def.water_table_m = table_m;
    def.step_s = 1.0 / 20;  // nothing moves but water
    def.rain_m_s = weather.rain_m_s;
    def.drying_m_s = weather.drying_m_s;
    def.floor_drainage_m_s = weather.floor_drainage_m_s;
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {8, 8, kDeepM / voxel_m})));
    return soil;
}

void run_s(Soil& soil, double time_s) {
    for (int64_t i = std::lround(time_s / soil.def().step_s); i > 0; --i) soil.step({});
}

/// Largest deviation of a bed's saturation from 1 - h / H, where that is above `least`.
double deviation(const Soil& soil, double table_m, double least = -1) {
    double most = 0;
    const double voxel_m = soil.def().voxel_m;
    for (int z = 0; z < static_cast<int>(kDeepM / voxel_m); ++z) {
        const double above_m = (z + 0.5) * voxel_m - table_m;
        const double rest = std::clamp(1 - above_m / kFringeM, 0.0, 1.0);
        if (rest > least) most = std::max(most, std::abs(soil.sample(4, 4, z).saturation - rest));
    }
    return most;
}

void expect_account(const Soil& soil, int64_t start) {
    const SoilTotals now = soil.totals();
    EXPECT_EQ(now.water_units, start + now.water_units_in - now.water_units_out);
}

// What is placed over groundwater has the water that it holds: nothing flows.
TEST(Groundwater, comes_with_its_fringe_and_stands_still) {
    for (const double voxel_m : {0.05, 0.025}) {
        for (const double table_m : {0.2, 0.23, 0.26}) {
            auto soil = bed(fringe_sand(0), voxel_m, table_m);
            const int64_t start = soil->totals().water_units;
            EXPECT_LT(deviation(*soil, table_m), 1e-3) << voxel_m << ", table at " << table_m;
            run_s(*soil, 60);
            EXPECT_LT(deviation(*soil, table_m), 2e-3) << voxel_m << ", table at " << table_m;
            expect_account(*soil, start);
            const uint64_t checksum = soil->checksum();
            run_s(*soil, 5);
            EXPECT_EQ(soil->checksum(), checksum);
        }
    }
}

/// Takes all water out, as no host can.
void dry_out(Soil& soil) {
    Soil::Impl& impl = SoilProbe::impl(soil);
    TileVoxels voxels;
    impl.tiles.read_voxels(0, voxels);
    for (int z = 0; z < impl.height; ++z) {
        for (int c = 0; c < layout::kTileColumns; ++c) voxels.at(kKeptMaterial + 1, z, c) = 0;
    }
    impl.tiles.write_voxels(0, voxels);
}

// In an hour from above, out of full soil, and from below into dry soil. What is nearly dry lets
// hardly any water through. A water step evens out a part of what two voxels differ by: on a finer
// grid water rises more slowly.
void expect_the_same_rest(double voxel_m) {
    auto full = bed(fringe_sand(1), voxel_m);
    EXPECT_GT(deviation(*full, kTableM), 0.9);
    const int64_t start = full->totals().water_units;
    run_s(*full, 3600);
    EXPECT_LT(deviation(*full, kTableM, 0.3), 0.03);
    expect_account(*full, start);
    auto dry = bed(fringe_sand(0), voxel_m);
    dry_out(*dry);
    run_s(*dry, 3600 * 0.05 / voxel_m);
    EXPECT_LT(deviation(*dry, kTableM), 0.06);
    expect_account(*dry, 0);
}

TEST(Groundwater, drains_and_rises_to_the_same_rest) { expect_the_same_rest(0.05); }
TEST(SlowGroundwater, drains_and_rises_to_the_same_rest) { expect_the_same_rest(0.025); }

// A soil that draws nothing up is dry above the table, and full below.
TEST(Groundwater, has_no_fringe_without_suction) {
    MaterialDef gravel = fringe_sand(0);
    gravel.moist_cohesion_pa = 0;
    auto soil = bed(gravel);
    dry_out(*soil);
    run_s(*soil, 600);
    for (int z = 0; z < 16; ++z) {  // the middle of layer 4 lies at 0.225 m
        EXPECT_NEAR(soil->sample(4, 4, z).saturation, z < 5 ? 1 : 0, 1e-3) << z;
    }
}

// Rain that has got down to the table leaves the grid there; drying draws water up from it.
TEST(Groundwater, takes_the_rain_and_brings_what_dries) {
    const double units_per_m = Water::kVoxelUnits / 0.05, columns = 64;
    SoilDef weather;
    weather.rain_m_s = 1e-5;
    auto soil = bed(fringe_sand(0), 0.05, kTableM, weather);
    run_s(*soil, 3600);
    SoilTotals before = soil->totals();
    run_s(*soil, 600);
    SoilTotals now = soil->totals();
    const double rained = columns * 1e-5 * 600 * units_per_m;
    EXPECT_NEAR(static_cast<double>(now.water_units_out - before.water_units_out), rained,
                0.02 * rained);
    weather.rain_m_s = 0;
    weather.drying_m_s = 1e-6;
    soil = bed(fringe_sand(0), 0.05, 0.6, weather);
    const int64_t start = soil->totals().water_units;
    run_s(*soil, 3600);
    before = soil->totals();
    run_s(*soil, 600);
    now = soil->totals();
    const double dried = columns * 1e-6 * 600 * units_per_m;
    EXPECT_NEAR(static_cast<double>(now.water_units_out - before.water_units_out), dried,
                0.02 * dried);
    EXPECT_NEAR(static_cast<double>(now.water_units_in - before.water_units_in), dried,
                0.02 * dried);
    expect_account(*soil, start);
}

/// Half of the bed lies in the groundwater.
PloughedBed ploughed(Backend backend = Backend::cpu, int threads = 0) {
    SoilDef def = ploughed_def(fringe_sand(0.4), backend, threads);
    def.water_table_m = 0.19;
    return {def, 0.3};
}

TEST(Groundwater, is_counted_to_the_unit_under_a_plough) {
    PloughedBed scene = ploughed();
    const int64_t start = scene.soil->totals().water_units;
    for (int i = 0; i < 240; ++i) {
        scene.step();
        if (i % 30 == 0) expect_account(*scene.soil, start);
    }
    EXPECT_GT(scene.soil->totals().water_units_in, 0);
    EXPECT_GT(scene.soil->totals().water_units_out, 0);
    EXPECT_EQ(scene.soil->status_bits(), 0u);
}

TEST(SlowGroundwater, has_the_same_bits_on_gl_on_threads_and_from_a_snapshot) {
    expect_same_bits(ploughed, 130, 70);
}

}  // namespace
}  // namespace bsoil::groundwater_test
