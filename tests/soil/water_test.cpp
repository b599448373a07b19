// Water in the soil: where it goes, what it makes stand, and the account of it.
#include <cmath>
#include <numbers>

#include "ploughed_bed.h"

namespace bsoil::water_test {
namespace {

using namespace layout;

constexpr double kGravity = 9.81;

/// Sand that holds a fifth of its mass of water.
MaterialDef moist_sand(double saturation, double moist_cohesion_pa = 2000) {
    MaterialDef material = sand(30);
    material.pore_water_fraction = 0.2;
    material.placed_saturation = saturation;
    material.moist_cohesion_pa = moist_cohesion_pa;
    material.conductivity_m_s = 1e-3;
    material.residual_saturation = 0.1;
    return material;
}

/// A bank against a wall, so many voxels of 5 cm high.
std::unique_ptr<Soil> bank(const MaterialDef& material, int high, SoilDef changes = {}) {
    SoilDef def = grid_def(32, 8, high + 2);
    def.material = material;
    def.rain_m_s = changes.rain_m_s;
    def.drying_m_s = changes.drying_m_s;
    def.floor_drainage_m_s = changes.floor_drainage_m_s;
    def.backend = changes.backend;
    def.thread_count = changes.thread_count;
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {16, 8, 1.0 * high})));
    return soil;
}
/// A level bed of 4 voxels in all of that grid.
std::unique_ptr<Soil> bed(const MaterialDef& material, const SoilDef& changes) {
    auto soil = bank(material, 4, changes);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {16, 0, 0}, {32, 8, 4})));
    return soil;
}

int64_t soil_units(const Soil& soil) { return soil.totals().units.front(); }

double mean_height_m(const Soil& soil, int from, int to) {
    double sum = 0;
    for (int x = from; x < to; ++x) sum += soil.surface_height_m(x, 4);
    return sum / (to - from);
}

// Hc = 4 c / gamma tan(45 deg + phi / 2), with c of 2 kPa at half saturation and the water's
// weight.
TEST(Water, lets_a_cut_stand_that_dry_and_saturated_falls) {
    const double weight = 1600 * 1.1 * kGravity;
    const double high_m = 4 * 2000 / weight * std::tan(std::numbers::pi / 3);
    const int stands = static_cast<int>(0.9 * high_m / 0.05),
              falls = static_cast<int>(std::ceil(1.15 * high_m / 0.05));
    ASSERT_GT(stands, 12);
    for (const auto& [saturation, high, keeps] : {std::tuple(0.5, stands, true),
                                                  {0.5, falls, false},
                                                  {0.0, stands, false},
                                                  {1.0, stands, false},
                                                  {0.05, stands, false}}) {
        MaterialDef material = moist_sand(saturation);
        material.conductivity_m_s = 0;
        auto soil = bank(material, high);
        const uint64_t checksum = soil->checksum();
        for (int i = 0; i < 300; ++i) soil->step({});
        EXPECT_EQ(soil->checksum() == checksum, keeps) << saturation << ", " << high << " voxels";
        EXPECT_EQ(soil->status_bits(), 0u);
    }
}

// Moved sand that keeps its cohesion. By Culmann's height 10 Pa hold a heap of 1 m and 1700 kg/m3
// at 32.7 deg; dry and full of water it has none and rests at phi. Wedges one voxel wide would let
// it stand at 44 deg.
TEST(Water, makes_moved_sand_rest_steeper_where_it_is_moist) {
    double rests_deg[3] = {};
    for (int i = 0; i < 3; ++i) {
        MaterialDef material = moist_sand(0.5 * i, 10);
        material.conductivity_m_s = 0;
        material.loose_cohesion_fraction = 1;
        SoilDef def = grid_def(64, 8, 24);
        def.material = material;
        const auto soil = make_soil(def);
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {20, 8, 20})));
        ASSERT_TRUE(soil->settle(4000));
        // Between a quarter and three quarters of the heap's height.
        const double peak_m = soil->surface_height_m(0, 4);
        int low = 0, high = 0;
        while (soil->surface_height_m(high, 4) > 0.75 * peak_m) ++high;
        while (soil->surface_height_m(low, 4) > 0.25 * peak_m) ++low;
        const double fall_m = soil->surface_height_m(high, 4) - soil->surface_height_m(low, 4);
        rests_deg[i] = std::atan2(fall_m, (low - high) * 0.05) * 180 / std::numbers::pi;
    }
    EXPECT_NEAR(rests_deg[0], 30, 1.5);
    EXPECT_NEAR(rests_deg[1], 32.7, 1);
    EXPECT_NEAR(rests_deg[2], 30, 1.5);
}

// The built-in that takes water: as placed it has 4 S (1 - S) of 640 Pa, 425 Pa, so that a cut
// stands to 0.20 m.
TEST(Water, lets_a_cut_in_fine_sand_stand_as_placed) {
    MaterialDef material = fixed_density(materials::fine_sand());
    const double cohesion_pa = material.moisture_cohesion_pa(material.placed_saturation);
    EXPECT_NEAR(cohesion_pa, 425, 1);
    const double weight =
        material.density_kg_m3 * material.wet_mass_share(material.placed_saturation) * kGravity;
    const double high_m =
        4 * cohesion_pa / weight * std::tan(std::numbers::pi / 4 + material.friction_angle_rad / 2);
    EXPECT_NEAR(high_m, 0.20, 0.005);
    constexpr double kVoxelM = 0.0125;
    for (const auto& [share, stands] : {std::pair(0.9, true), std::pair(1.15, false)}) {
        const double high =
            stands ? std::floor(share * high_m / kVoxelM) : std::ceil(share * high_m / kVoxelM);
        SoilDef def = grid_def(48, 8, static_cast<int>(high) + 4, kVoxelM);
        def.material = material;
        const auto soil = make_soil(def);
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {24, 8, high})));
        const double before_m = mean_height_m(*soil, 24, 48);
        for (int i = 0; i < 300; ++i) soil->step({});
        EXPECT_EQ(mean_height_m(*soil, 24, 48) == before_m, stands) << share;
    }
}

TEST(Water, of_rain_brings_a_bank_down) {
    MaterialDef material = moist_sand(0.5);
    material.conductivity_m_s = 0.05;
    material.residual_saturation = 0.5;  // what is there at first stays where it is
    SoilDef wet;
    wet.rain_m_s = 1e-3;
    auto soil = bank(material, 14, wet);
    const double before_m = mean_height_m(*soil, 16, 32);
    for (int i = 0; i < 300; ++i) soil->step({});
    EXPECT_EQ(mean_height_m(*soil, 16, 32), before_m);
    // 0.7 m of soil of 1600 kg/m3 take 0.112 m of water from half saturation on: 112 s.
    for (int i = 300; i < 7000; ++i) soil->step({});
    EXPECT_GT(mean_height_m(*soil, 16, 32), before_m + 0.05);
}

TEST(Water, falls_dries_and_drains_at_the_stated_rates) {
    SoilDef changes;
    changes.rain_m_s = 2e-5;
    auto soil = bed(moist_sand(0), changes);
    for (int i = 0; i < 600; ++i) soil->step({});
    const double units_per_m = Water::kVoxelUnits / 0.05, columns = 32 * 8;
    SoilTotals totals = soil->totals();
    EXPECT_EQ(totals.water_units, totals.water_units_in);
    EXPECT_EQ(totals.water_units_in, static_cast<int64_t>(columns) *
                                         static_cast<int64_t>(std::floor(2e-5 * 10 * units_per_m)));
    changes.rain_m_s = 0;
    changes.drying_m_s = 2e-5;
    changes.floor_drainage_m_s = 1e-4;
    soil = bed(moist_sand(1), changes);
    const int64_t start = soil->totals().water_units;
    for (int i = 0; i < 600; ++i) soil->step({});
    totals = soil->totals();
    EXPECT_EQ(totals.water_units, start - totals.water_units_out);
    EXPECT_NEAR(static_cast<double>(totals.water_units_out), columns * 1.2e-4 * 10 * units_per_m,
                0.01 * columns * 1.2e-4 * 10 * units_per_m);
}

// Sand of 1e-3 m/s loses what it can in minutes. What is left drains less than 1/256 unit a second.
TEST(Water, drains_to_the_residual_saturation_and_stands_still) {
    MaterialDef material = moist_sand(1);
    material.conductivity_m_s = 0.02;
    SoilDef changes;
    changes.floor_drainage_m_s = 1;
    auto soil = bed(material, changes);
    for (int i = 0; i < 30000; ++i) soil->step({});
    for (int z = 0; z < 3; ++z) EXPECT_NEAR(soil->sample(2, 4, z).saturation, 0.1, 0.05) << z;
    const SoilTotals totals = soil->totals();
    EXPECT_GT(totals.water_units_out, 0);
}

/// Share of the water of a wet strip of soil, a voxel thick, that suction has drawn over into the
/// dry strip beside it after ten minutes.
double drawn_share(double voxel_m, double moist_cohesion_pa) {
    const int side = static_cast<int>(std::lround(0.8 / voxel_m));
    SoilDef def = grid_def(2 * side, 8, 8, voxel_m);
    def.materials = {moist_sand(0.7, moist_cohesion_pa), moist_sand(0, moist_cohesion_pa)};
    for (MaterialDef& material : def.materials) material.conductivity_m_s = 1e-4;
    def.materials[1].name = "dry";
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {1.0 * side, 8, 1})));
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {1.0 * side, 0, 0}, {2.0 * side, 8, 1}, "dry")));
    const int64_t water = soil->totals().water_units;
    for (int i = 0; i < 36000; ++i) soil->step({});
    EXPECT_EQ(soil->totals().water_units, water);
    double all = 0, drawn = 0, last = 1;
    for (int x = 0; x < 2 * side; ++x) {
        const double saturation = soil->sample(x, 4, 0).saturation;
        EXPECT_LE(saturation, last + 1e-3) << x;
        last = saturation;
        all += saturation;
        drawn += x >= side ? saturation : 0;
    }
    return drawn / all;
}

TEST(Water, is_drawn_aside_by_suction_as_far_in_any_grid) {
    const double coarse = drawn_share(0.05, 500), fine = drawn_share(0.025, 500);
    EXPECT_GT(coarse, 0.05);
    EXPECT_NEAR(fine, coarse, 0.1 * coarse);
    EXPECT_EQ(drawn_share(0.05, 0), 0);
}

/// It dries, too, and wet soil is poured onto it.
PloughedBed ploughed(Backend backend = Backend::cpu, int threads = 0) {
    SoilDef def = ploughed_def(moist_sand(0.4), backend, threads);
    def.drying_m_s = 1e-4;
    PloughedBed bed(def, 0.35);
    SourceDef source;
    source.center_m = {1.2, 0.4, 0.7};
    source.rate_kg_s = 20;
    EXPECT_TRUE(bed.soil->add_source(source));
    return bed;
}

TEST(Water, is_conserved_to_the_unit_under_a_plough_rain_and_an_open_side) {
    PloughedBed scene = ploughed();
    const SoilTotals start = scene.soil->totals();
    for (int i = 0; i < 300; ++i) {
        scene.step();
        if (i % 30 != 0) continue;
        const SoilTotals now = scene.soil->totals();
        ASSERT_EQ(now.water_units, start.water_units + now.water_units_in - now.water_units_out)
            << "step " << i;
        ASSERT_EQ(now.units[0], start.units[0] + now.units_in[0] - now.units_out[0]);
    }
    EXPECT_GT(scene.soil->totals().water_units_in, 0);
    EXPECT_GT(scene.soil->totals().water_units_out, 0);
    EXPECT_EQ(scene.soil->status_bits(), 0u);
}

TEST(Water, has_the_same_bits_on_gl_on_threads_and_from_a_snapshot) {
    expect_same_bits(ploughed, 90, 40);
}

// Neither drains nor dries: a plough moves soil and its water alike.
TEST(Water, stays_with_its_soil_under_a_plough) {
    SoilDef def = grid_def(48, 16, 16);
    def.material = moist_sand(0.5, 0);
    def.material.conductivity_m_s = 0;
    PloughedBed bed(def, 0.35);
    for (int i = 0; i < 120; ++i) bed.step();
    // A water unit of 1/16 of a mass unit is 1/80000 of a half-full voxel. With whole mass units it
    // went from 0.464 to 0.513, and from 0.452 to 0.584 where less than half a voxel lies.
    double least = 1, most = 0;
    for (int z = 0; z < 16; ++z) {
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 48; ++x) {
                const VoxelSample voxel = bed.soil->sample(x, y, z);
                if (voxel.volume < 0.01) continue;
                least = std::min(least, voxel.saturation);
                most = std::max(most, voxel.saturation);
            }
        }
    }
    EXPECT_GT(least, 0.49);
    EXPECT_LT(most, 0.51);
}

// A thin top layer has no room for a shower: what it cannot take goes into the soil beneath.
TEST(Water, of_rain_goes_into_the_topmost_half_voxel_of_soil_at_least) {
    SoilDef changes;
    changes.rain_m_s = 2e-4;
    auto soil = bed(moist_sand(0), changes);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 4}, {32, 8, 4.01})));
    for (int i = 0; i < 300; ++i) soil->step({});
    const double columns = 32 * 8, units_per_m = Water::kVoxelUnits / 0.05;
    EXPECT_NEAR(static_cast<double>(soil->totals().water_units_in),
                columns * 2e-4 * 5 * units_per_m, 0.02 * columns * 2e-4 * 5 * units_per_m);
}

/// As a snapshot has it, with another number of units in the plane of the water or its account.
TEST(Water, of_a_snapshot_is_refused_out_of_its_range) {
    const auto copy_of = [](const Soil& soil) {
        auto copy = make_soil(soil.def());
        const auto put = copy->prepare(soil.state());
        EXPECT_TRUE(put) << put.error();
        if (put) (*put)();
        return copy;
    };
    auto soil = bed(moist_sand(0.5), {});
    for (int i = 0; i < 70; ++i) soil->step({});
    const uint64_t checksum = soil->checksum();
    for (const int32_t units : {-1, 2 * kVoxelMost * kWaterParts}) {
        auto spoilt = copy_of(*soil);
        Soil::Impl& impl = SoilProbe::impl(*spoilt);
        TileVoxels voxels;
        impl.tiles.read_voxels(0, voxels);
        voxels.at(kKeptMaterial + 1, 1, 9) = units;
        impl.tiles.write_voxels(0, voxels);
        const auto put = soil->prepare(spoilt->state());
        ASSERT_FALSE(put);
        EXPECT_NE(put.error().find("water of a voxel in tile 0"), std::string::npos) << put.error();
    }
    for (const std::vector<int64_t>& account : {std::vector<int64_t>{-1, 0, 0}, {0, -1, 0}}) {
        auto spoilt = copy_of(*soil);
        SoilProbe::impl(*spoilt).water.restart(account);
        const auto put = soil->prepare(spoilt->state());
        ASSERT_FALSE(put);
        EXPECT_NE(put.error().find("account of its water"), std::string::npos) << put.error();
    }
    MaterialDef dry = moist_sand(0.5);
    dry.pore_water_fraction = 0;
    const auto put = bed(dry, {})->prepare(soil->state());
    ASSERT_FALSE(put);
    EXPECT_NE(put.error().find("pore_water_fraction"), std::string::npos) << put.error();
    EXPECT_EQ(soil->checksum(), checksum);
}

// A tray full of soil is as heavy as soil and water are.
TEST(Water, weighs_on_the_body_that_carries_it) {
    double load_kg[2] = {};
    for (const double saturation : {0.0, 1.0}) {
        SoilDef def = grid_def(24, 24, 24);
        def.material = moist_sand(saturation, 0);  // no crumb sticks for its cohesion
        def.material.conductivity_m_s = 0;
        auto soil = make_soil(def);
        Mover tray(1, box_shape({0.5, 0.5, 0.1}), Vec3{0.6, 0.6, 0.6});
        soil->step({&tray.body, 1});
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {8, 8, 14}, {16, 16, 18})));
        StepReport report;
        for (int i = 0; i < 120; ++i) {
            tray.set_velocity({0, 0, i < 60 ? 0 : 0.1});
            tray.advance(def.step_s);
            report = soil->step({&tray.body, 1});
        }
        ASSERT_EQ(report.loads.size(), 1u);
        load_kg[saturation > 0] = report.loads[0].mass_kg;
    }
    EXPECT_GT(load_kg[0], 10);
    EXPECT_NEAR(load_kg[1], 1.2 * load_kg[0], 1e-3 * load_kg[0]);
}

TEST(Water, is_known_where_a_body_meets_the_soil) {
    for (const double saturation : {0.0, 0.5, 1.0}) {
        MaterialDef material = moist_sand(saturation);
        material.conductivity_m_s = 0;
        auto soil = bed(material, {});
        Mover plate(1, box_shape({0.1, 0.1, 0.05}), Vec3{0.8, 0.2, 0.26});
        plate.set_velocity({0, 0, -0.1});
        StepReport report;
        for (int i = 0; i < 30; ++i) {
            plate.advance(soil->def().step_s);
            report = soil->step({&plate.body, 1});
        }
        ASSERT_FALSE(report.contacts.empty());
        for (const ContactVoxel& contact : report.contacts) {
            EXPECT_EQ(contact.material, 0);
            // In what little soil a push leaves in a voxel, shares are rounded to a unit.
            EXPECT_NEAR(contact.saturation, saturation, 0.02);
        }
    }
}

// Dry soil stands still; what is put on it later does not.
TEST(Water, starts_anew_in_soil_that_is_put_in) {
    SoilDef def = grid_def(32, 8, 8);
    def.materials = {moist_sand(0), moist_sand(1)};
    def.materials[1].name = "wet";
    auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {32, 8, 3})));
    for (int i = 0; i < 130; ++i) soil->step({});
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 3}, {32, 8, 4}, "wet")));
    for (int i = 0; i < 130; ++i) soil->step({});
    EXPECT_GT(soil->sample(16, 4, 2).saturation, 0.01);
}

// Its plane is there, and moves with it; nothing else is other than without.
TEST(Water, that_is_not_there_changes_nothing_else) {
    auto with = bank(moist_sand(0, 0), 12), without = bank(sand(30), 12);
    for (int i = 0; i < 59; ++i) {  // until its first pass, which draws new chances
        with->step({});
        without->step({});
    }
    EXPECT_EQ(soil_units(*with), soil_units(*without));
    for (int x = 0; x < 32; ++x) {
        EXPECT_EQ(with->surface_height_m(x, 4), without->surface_height_m(x, 4)) << x;
    }
    EXPECT_EQ(with->totals().water_units, 0);
}

}  // namespace
}  // namespace bsoil::water_test
