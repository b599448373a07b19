// Water in the soil, stage by stage: the pass and the cohesion beside the oracle's, and on GL.
#include <cmath>
#include <random>

#include "oracle/slippage.h"
#include "oracle/water.h"
#include "stage_scenario.h"

namespace bsoil::water_stage_test {
namespace {

using namespace layout;

constexpr double kGravity = 9.81;

class WaterStage : public testing::TestWithParam<Scenario> {
  protected:
    static SoilDef def(Backend backend) {
        SoilDef def = GetParam().def();
        if (def.materials.empty()) def.materials = {def.material};
        for (size_t i = 0; i < def.materials.size(); ++i) {
            const double n = static_cast<double>(i);
            def.materials[i].pore_water_fraction = 0.2 + 0.1 * n;
            def.materials[i].moist_cohesion_pa = 500 * (1 + n);
            def.materials[i].conductivity_m_s = 0.02 / (1 + n);
            def.materials[i].residual_saturation = 0.1 * n;
        }
        def.backend = backend;
        return def;
    }
    /// The scenario's soil, with water in its pores and here and there more than that.
    static void prepare(StageBench& bench) {
        StatePlanes planes = GetParam().planes(bench);
        std::mt19937 random(GetParam().seed + 3000);
        std::uniform_real_distribution<double> share(-0.2, 1.2);
        const int materials = static_cast<int>(bench.soil().materials().size());
        for (int z = 0; z < planes.nz; ++z) {
            for (int y = 0; y < planes.ny; ++y) {
                for (int x = 0; x < planes.nx; ++x) {
                    int mass = 0;
                    for (int m = 0; m < materials; ++m) {
                        mass += planes.at(kPlaneMaterial + m, x, y, z);
                    }
                    // Here and there soil has left some behind.
                    planes.at(kPlaneMaterial + materials, x, y, z) =
                        kWaterParts *
                        (mass > 0 ? static_cast<int>(std::max(0.0, share(random)) * 0.25 * mass)
                                  : static_cast<int>(random() % 8 == 0) * 50);
                }
            }
        }
        bench.write(planes);
        bench.place(GetParam().bodies(bench));
        bench.find_support();
        bench.build_spans();
        SoilParams& params = bench.impl().params;
        params.rain_units = 900 * kWaterParts;
        params.drying_units = 400 * kWaterParts;
        params.floor_seepage = 300 * kWaterParts * 16;
    }
    static std::vector<oracle::PoreSoil> pore_soils(const Soil& soil) {
        std::vector<oracle::PoreSoil> soils;
        for (const MaterialDef& m : soil.materials()) {
            const double voxels = m.conductivity_m_s / soil.frame().voxel_m;  // in a second
            const double suction_m =
                4 * m.moist_cohesion_pa / std::tan(m.friction_angle_rad) / (1000 * kGravity);
            soils.push_back({m.pore_water_fraction, m.residual_saturation,
                             std::min(1.0, voxels) * Water::kVoxelUnits / kWaterParts / kVoxelFull,
                             suction_m / soil.frame().voxel_m});
        }
        return soils;
    }
    /// Groundwater up to the middle of the fourth layer and a bit.
    static constexpr double kTable = 3.8;
    static void flood(StageBench& bench) {
        bench.impl().params.water_table = static_cast<int>(kTable * kOneQ16);
    }
    /// Mass units.
    static double sum(StageBench& bench, int word) {
        int32_t words[2];
        bench.impl().device->read(Buffer::result, word, words);
        return static_cast<double>(wide_sum(words)) / kWaterParts;
    }
};

TEST_P(WaterStage, follows_the_oracle) {
    for (const double table : {0.0, kTable}) {
        StageBench bench(def(Backend::cpu));
        prepare(bench);
        if (table > 0) flood(bench);
        const oracle::Field before = bench.to_field(bench.read());
        const double unit = 1.0 / kVoxelFull;
        const oracle::WaterStep expected =
            oracle::move_water(bench.model(), before, pore_soils(bench.soil()),
                               {900 * unit, 400 * unit, 300 * unit, table});
        bench.move_water();
        const oracle::Field got = bench.to_field(bench.read());
        Deviation water, others;
        double moved = 0;
        before.for_each([&](int x, int y, int z) {
            water.take(got.at(x, y, z).water, expected.field.at(x, y, z).water, x, y, z);
            others.take(got.at(x, y, z).soil, before.at(x, y, z).soil, x, y, z);
            moved += std::abs(expected.field.at(x, y, z).water - before.at(x, y, z).water);
        });
        // Whole units by chance, ten of them a voxel, and a cube of Q16 shares of up to 2^15 units.
        EXPECT_LT(water.value, 24 * unit) << water;
        EXPECT_EQ(others.value, 0) << others;
        EXPECT_GT(moved, 1000 * unit);
        // Two units a column; what groundwater moves comes by chance in each of four layers, too.
        const double near = (table > 0 ? 6 : 2) * unit * before.nx * before.ny;
        EXPECT_GT(expected.in, 0);
        EXPECT_NEAR(sum(bench, kResultWaterIn) * unit, expected.in, near);
        EXPECT_NEAR(sum(bench, kResultWaterOut) * unit, expected.out, near);
    }
}

// A thin layer with full pores on dry soil, under rain: what drips out of it, the rain that runs
// through it and what suction draws in from the sides had filled the pores below by up to a half
// too much.
TEST_P(WaterStage, fills_no_pore_beyond_its_room) {
    StageBench bench(def(Backend::cpu));
    prepare(bench);
    StatePlanes planes = bench.read();
    const auto& materials = bench.soil().materials();
    const int count = static_cast<int>(materials.size());
    const auto pores = [&](const StatePlanes& of, int x, int y, int z) {
        double sum = 0;
        for (int m = 0; m < count; ++m) {
            sum += of.at(kPlaneMaterial + m, x, y, z) *
                   materials[static_cast<size_t>(m)].pore_water_fraction * kWaterParts;
        }
        return sum;
    };
    const auto for_each = [&](const auto& look) {
        for (int z = 0; z < planes.nz; ++z) {
            for (int y = 0; y < planes.ny; ++y) {
                for (int x = 0; x < planes.nx; ++x) look(x, y, z);
            }
        }
    };
    for_each([&](int x, int y, int z) {
        const bool is_thin = 2 * planes.at(kPlaneVolume, x, y, z) < kVoxelFull;
        planes.at(kPlaneMaterial + count, x, y, z) =
            is_thin ? static_cast<int>(pores(planes, x, y, z)) : 0;
    });
    bench.write(planes);
    bench.impl().params.rain_units = kVoxelFull * kWaterParts;
    bench.move_water();
    const StatePlanes after = bench.read();
    int64_t water = 0;
    for_each([&](int x, int y, int z) {
        const int units = after.at(kPlaneMaterial + count, x, y, z);
        water += units;
        // A unit for each of six ways in.
        if (after.at(kPlaneVolume, x, y, z) > 0) {
            EXPECT_LE(units, pores(after, x, y, z) + 6) << x << ' ' << y << ' ' << z;
        }
    });
    EXPECT_GT(water, 1000);
}

TEST_P(WaterStage, gives_cohesion_as_the_oracle_has_it) {
    if (GetParam().material_count > 1) return;  // the wedge below is that of one material
    SoilDef moist = def(Backend::cpu);
    moist.materials[0].moist_cohesion_pa = 300;
    moist.materials[0].loose_cohesion_fraction = 0.5;
    StageBench bench(moist);
    prepare(bench);
    const oracle::Field before = bench.to_field(bench.read());
    const std::vector<oracle::PoreSoil> soils = pore_soils(bench.soil());
    const MaterialDef& m = moist.materials[0];
    const double weight = m.density_kg_m3 * kGravity, voxel_m = moist.voxel_m;
    const auto wedge = [&](const oracle::Voxel& voxel, oracle::SoilState state,
                           double any_slope) -> oracle::GridWedge {
        const double slope = std::min(any_slope, 16.0);
        const double strength_m = oracle::moist_strength(
            0, m.moist_cohesion_pa * (state == oracle::SoilState::bonded ? 1 : 0.5) / weight,
            oracle::saturation(voxel, soils), voxel.water / voxel.total_mass());
        const oracle::Wedge w = oracle::failure_wedge({strength_m, m.friction_angle_rad, 1},
                                                      kGravity, slope * voxel_m, voxel_m);
        const oracle::Wedge dry =
            oracle::failure_wedge({0, m.friction_angle_rad, 1}, kGravity, slope * voxel_m, voxel_m);
        const double stable = strength_m > 0 ? -1 : slope - std::tan(m.friction_angle_rad);
        return {w.height_m > 0 ? w.height_m / voxel_m : stable,
                std::min(1.0, dry.acceleration_m_s2 * moist.step_s * moist.step_s / voxel_m)};
    };
    bench.slip(1);
    const oracle::Model model = bench.model();
    const oracle::Slippage expected = oracle::slip_soil(
        model, before,
        oracle::SlipSpeeds(static_cast<size_t>(before.nx) * before.ny * model.span_capacity, 0.0),
        wedge);
    const FieldDeviation deviation = compare(bench.to_field(bench.read()), expected.field, 1);
    EXPECT_LT(deviation.soil.value, 8e-3) << deviation.soil;  // as in slippage_test.cpp
    EXPECT_LT(deviation.mass.value, 8e-3) << deviation.mass;
}

TEST_P(WaterStage, has_the_same_bits_on_gl) {
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    for (const bool has_table : {false, true}) {
        std::vector<int32_t> words[2];
        for (const Backend backend : {Backend::cpu, Backend::gl}) {
            StageBench bench(def(backend));
            prepare(bench);
            if (has_table) flood(bench);
            bench.move_water();
            bench.build_spans();
            bench.slip(1);
            std::vector<int32_t>& out = words[backend == Backend::gl];
            out = bench.read().words;
            for (const int at : {kResultWaterIn, kResultWaterOut, kResultWaterMoves}) {
                out.push_back(static_cast<int32_t>(sum(bench, at) * kWaterParts));
            }
        }
        EXPECT_TRUE(words[0] == words[1]) << "CPU and GL differ";
    }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, WaterStage, testing::ValuesIn(all_scenarios()),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil::water_stage_test
