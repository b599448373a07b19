// Slope stability and slippage (1) to (10), (31), (32) against the oracle.
#include "oracle/slippage.h"

#include <functional>
#include <limits>
#include <numbers>

#include "oracle/banks.h"
#include "soil/slip_table.h"
#include "stage_scenario.h"

namespace bsoil::slippage_test {
namespace {

using namespace layout;

oracle::Wedge oracle_wedge(const MaterialDef& material, double gravity, double rise_m,
                           double run_m) {
    return oracle::failure_wedge(
        {material.cohesion_pa, material.friction_angle_rad, material.density_kg_m3 * gravity},
        gravity, rise_m, run_m);
}

TEST(SlipWedge, follows_the_oracle) {
    constexpr double kGravity = 9.81;
    for (const MaterialDef& material : materials::all()) {
        for (double run : {0.025, 0.1, 0.5}) {
            for (double slope = 0.05; slope < 16; slope += 0.37) {
                const SlipWedge got = find_slip_wedge(material, kGravity, slope * run, run);
                const oracle::Wedge expected = oracle_wedge(material, kGravity, slope * run, run);
                // The failing planes are looked for at 400 angles: an interval of them narrower
                // than that is missed. Its wedge is next to nothing (acceleration vanishes at both
                // ends of the interval).
                if (got.fails != (expected.height_m > 0)) {
                    EXPECT_LT(expected.acceleration_m_s2, 0.01 * kGravity)
                        << material.name << " slope " << slope;
                    continue;
                }
                EXPECT_NEAR(std::max(0.0, got.height_m), expected.height_m, 1e-9 * run)
                    << material.name << " slope " << slope;
                EXPECT_NEAR(got.acceleration_m_s2, expected.acceleration_m_s2, 1e-6 * kGravity)
                    << material.name;
            }
        }
    }
}

class Slippage : public Stage {
  protected:
    /// What goes by the density as the kernels have it: between entries 1/32 apart.
    static double tabulated(double relative_density,
                            const std::function<double(double density)>& by_density) {
        const double entry = std::floor(std::min(31.0, relative_density * 32));
        return std::lerp(by_density(entry / 32), by_density((entry + 1) / 32),
                         relative_density * 32 - entry);
    }
    /// The wedge as the kernels have it: between entries 1/16 apart in slope.
    static oracle::WedgeLookup tabulated(const StageBench& bench) {
        using State = oracle::SoilState;
        const auto kept = [](const MaterialDef& material, State state) {
            if (state == State::failing) return 0.0;
            return state == State::bonded ? 1.0 : material.loose_cohesion_fraction;
        };
        const bool regains = bench.model().regains, dilates = bench.model().dilates;
        const auto of_material = [&bench, kept](int material, State state,
                                                double slope) -> oracle::GridWedge {
            const SoilDef& def = bench.soil().def();
            MaterialDef soil = bench.soil().materials()[static_cast<size_t>(material)];
            soil.cohesion_pa *= kept(soil, state);
            const double slope_of_phi = std::tan(soil.friction_angle_rad);
            const auto entry = [&](int i) -> oracle::GridWedge {
                const oracle::Wedge w =
                    oracle_wedge(soil, def.gravity_m_s2, i / 16.0 * def.voxel_m, def.voxel_m);
                // Without cohesion the wedge is h - dx tan(phi) on both sides of zero; with it,
                // stable counts as -1.
                const double stable = soil.cohesion_pa > 0 ? -1 : i / 16.0 - slope_of_phi;
                return {w.height_m > 0 ? w.height_m / def.voxel_m : stable,
                        std::min(1.0, w.acceleration_m_s2 * def.step_s * def.step_s / def.voxel_m)};
            };
            const int i = std::min(static_cast<int>(slope * 16), 255);
            const double t = std::min(1.0, slope * 16 - i);
            const oracle::GridWedge a = entry(i), b = entry(i + 1);
            return {a.height + t * (b.height - a.height),
                    a.acceleration + t * (b.acceleration - a.acceleration)};
        };
        // A mixture has no table, nor has soil whose strength is by its density: its wedge is found
        // for the slope itself.
        return [&bench, of_material, kept, regains, dilates, model = bench.model()](
                   const oracle::Voxel& held, State state, double any_slope) -> oracle::GridWedge {
            const double slope = std::min(any_slope, 16.0);  // where the tables end
            const bool is_dense =
                (regains && state == State::loose) || (dilates && state == State::bonded);
            if (!held.is_mixed() && !is_dense) {
                return of_material(held.main_material(), state, slope);
            }
            const SoilDef& def = bench.soil().def();
            std::vector<double> friction, strength_m, acceleration;
            for (const MaterialDef& m : bench.soil().materials()) {
                const double cohesion = m.cohesion_pa * kept(m, state);
                const double density = oracle::relative_density(model, held);
                friction.push_back(
                    state == State::bonded
                        ? tabulated(density, [&](double d) { return oracle::peak_friction(m, d); })
                        : std::tan(m.friction_angle_rad));
                strength_m.push_back(state == State::loose
                                         ? tabulated(density,
                                                     [&](double d) {
                                                         return oracle::moved_strength_m(
                                                             m, d, def.gravity_m_s2);
                                                     })
                                         : cohesion / (m.density_kg_m3 * def.gravity_m_s2));
                acceleration.push_back(
                    of_material(static_cast<int>(acceleration.size()), state, slope).acceleration);
            }
            const double cohesion_m = held.mean(strength_m), tan_phi = held.mean(friction);
            const oracle::Wedge w =
                oracle::failure_wedge({cohesion_m, std::atan(tan_phi), 1}, def.gravity_m_s2,
                                      slope * def.voxel_m, def.voxel_m);
            const double stable = cohesion_m > 0 ? -1 : slope - tan_phi;
            return {w.height_m > 0 ? w.height_m / def.voxel_m : stable, held.mean(acceleration)};
        };
    }
    static std::vector<int32_t> random_speeds(const Scenario& scenario) {
        std::mt19937 random(scenario.seed + 2000);
        std::vector<int32_t> speeds(static_cast<size_t>(scenario.nx) * scenario.ny * kSpanCapacity,
                                    0);
        for (int32_t& speed : speeds) {
            speed = random() % 8 == 0 ? static_cast<int32_t>(random() % 20000) : 0;
        }
        return speeds;
    }
};

TEST_P(Slippage, follows_the_oracle) {
    for (const auto& [substeps, stride] : {std::pair(1, 1), {2, 1}, {1, 2}, {1, 3}, {2, 4}}) {
        SCOPED_TRACE("stride " + std::to_string(stride));
        StageBench& bench = prepared(Backend::cpu);
        const std::vector<int32_t> speeds = random_speeds(GetParam());
        bench.build_spans();
        bench.write_speeds(speeds);
        const oracle::Field before = bench.to_field(bench.read());
        oracle::SlipSpeeds oracle_speeds(speeds.begin(), speeds.end());
        for (double& speed : oracle_speeds) speed /= kVoxelFull;
        oracle::Model model = bench.model(substeps);
        model.slip_stride = stride;
        const oracle::Slippage expected =
            oracle::slip_soil(model, before, oracle_speeds, tabulated(bench));
        bench.slip(substeps, stride);
        const FieldDeviation deviation =
            compare(bench.to_field(bench.read()), expected.field, GetParam().material_count);
        // The slope's root is good to 2^-12 of it, slopes go up to 16 here and a quarter of the
        // wedge slides: 1e-3 voxel from each of up to 8 columns in the worst case, per voxel of
        // stride.
        const double tolerance = 8 * 1e-3 * stride;
        EXPECT_LT(deviation.soil.value, tolerance) << deviation.soil;
        EXPECT_LT(deviation.mass.value, tolerance) << deviation.mass;
        EXPECT_LT(deviation.momentum.value, tolerance) << deviation.momentum;
        int moved_count = 0;
        before.for_each([&](int x, int y, int z) {
            moved_count += before.at(x, y, z).soil != expected.field.at(x, y, z).soil;
        });
        // The cohesion of the mixtures leaves few long ways down.
        EXPECT_GT(moved_count, GetParam().material_count == 1 || stride == 1 ? 20 : -1);
        const std::vector<int32_t> got_speeds = bench.read_speeds();
        for (size_t i = 0; i < got_speeds.size(); ++i) {
            // Whole 1/65536 voxels; the acceleration's slope is good to 2^-12.
            EXPECT_NEAR(got_speeds[i] / static_cast<double>(kVoxelFull), expected.speeds[i], 2e-4)
                << "span " << i;
        }
    }
}

void prepare(StageBench& bench, const Scenario& scenario) {
    bench.write(scenario.planes(bench));
    bench.place(scenario.bodies(bench));
    bench.find_support();
    bench.build_spans();
}

/// Every other column has a plane that fails, somewhere in it.
std::vector<double> random_cuts(const Scenario& scenario) {
    std::mt19937 random(scenario.seed + 3000);
    std::vector<double> heights(static_cast<size_t>(scenario.nx) * scenario.ny,
                                std::numeric_limits<double>::infinity());
    for (double& height : heights) {
        const double place = std::uniform_real_distribution(0.0, 1.0 * scenario.nz)(random);
        if (random() % 2 == 0) height = std::round(place * kVoxelFull) / kVoxelFull;
    }
    return heights;
}

/// A scenario's materials with cohesion, of which loose soil keeps half, or more by its density.
SoilDef kept_cohesion_def(const Scenario& scenario, Backend backend, bool by_density = false) {
    SoilDef def = scenario.def();
    def.backend = backend;
    if (def.materials.empty()) def.materials = {def.material};
    for (MaterialDef& m : def.materials) {
        m.cohesion_pa = std::max(m.cohesion_pa, 800.0);
        m.loose_cohesion_fraction = 0.5;
        if (!by_density) continue;
        // So wide that most of the soil that planes() makes lies within it. Half dense, it has
        // 190 Pa, which holds steps of some voxels.
        m.loose_density_kg_m3 = 1000;
        m.compacted_density_kg_m3 = 2000;
        m.compaction_cohesion_ratio = 0.006;
        m.loose_cohesion_fraction = 0.02;
        m.dilatancy_angle_rad = 5 * std::numbers::pi / 180;
    }
    return def;
}

// Soil above a plane that fails has no cohesion: docs/decisions/banks.md
TEST_P(Slippage, of_soil_above_a_failing_plane_follows_the_oracle) {
    StageBench bench(kept_cohesion_def(GetParam(), Backend::cpu));
    for (const int stride : {1, 3}) {
        SCOPED_TRACE("stride " + std::to_string(stride));
        prepare(bench, GetParam());
        const std::vector<double> cuts = random_cuts(GetParam());
        bench.write_cuts(cuts);
        const oracle::Field before = bench.to_field(bench.read());
        bench.slip(1, stride);
        oracle::Model model = bench.model();
        model.slip_stride = stride;
        const oracle::SlipSpeeds still(
            static_cast<size_t>(before.nx) * before.ny * model.span_capacity, 0.0);
        const oracle::Slippage expected =
            oracle::slip_soil(model, before, still, tabulated(bench), cuts);
        const FieldDeviation deviation =
            compare(bench.to_field(bench.read()), expected.field, GetParam().material_count);
        const double tolerance = 8 * 1e-3 * stride;  // as above
        EXPECT_LT(deviation.soil.value, tolerance) << deviation.soil;
        EXPECT_LT(deviation.mass.value, tolerance) << deviation.mass;
        // More of it slides than where nothing fails.
        const oracle::Slippage plain = oracle::slip_soil(model, before, still, tabulated(bench));
        int moved_count = 0, moved_plain_count = 0;
        before.for_each([&](int x, int y, int z) {
            moved_count += before.at(x, y, z).soil != expected.field.at(x, y, z).soil;
            moved_plain_count += before.at(x, y, z).soil != plain.field.at(x, y, z).soil;
        });
        EXPECT_GT(moved_count, moved_plain_count + (stride == 1 ? 20 : -1));
    }
}

// Moved soil has its cohesion by its density, other soil its friction:
// docs/decisions/compacted_soil.md, dense_slopes.md
TEST_P(Slippage, that_goes_by_density_follows_the_oracle) {
    StageBench bench(kept_cohesion_def(GetParam(), Backend::cpu, true));
    SoilDef other_def = kept_cohesion_def(GetParam(), Backend::cpu, true);
    for (MaterialDef& m : other_def.materials) {
        m.compaction_cohesion_ratio = m.dilatancy_angle_rad = 0;
    }
    const StageBench other(other_def);
    prepare(bench, GetParam());
    // Of every other voxel's soil none is bonded, and of the rest all.
    StatePlanes planes = bench.read();
    for (int z = 0; z < planes.nz; ++z) {
        for (int y = 0; y < planes.ny; ++y) {
            for (int x = 0; x < planes.nx; ++x) {
                planes.at(layout::kPlaneBond, x, y, z) =
                    (x + y) % 2 == 0 ? 0 : planes.at(layout::kPlaneVolume, x, y, z);
            }
        }
    }
    bench.write(planes);
    bench.place(GetParam().bodies(bench));
    bench.find_support();
    bench.build_spans();
    const oracle::Field before = bench.to_field(bench.read());
    const oracle::Model model = bench.model();
    const oracle::SlipSpeeds still(static_cast<size_t>(before.nx) * before.ny * model.span_capacity,
                                   0.0);
    const auto slipped = [&](const StageBench& of) {
        return oracle::slip_soil(model, before, still, tabulated(of)).field;
    };
    const oracle::Field expected = slipped(bench), plain = slipped(other);
    bench.slip(1);
    const FieldDeviation deviation =
        compare(bench.to_field(bench.read()), expected, GetParam().material_count);
    EXPECT_LT(deviation.soil.value, 8e-3) << deviation.soil;
    EXPECT_LT(deviation.mass.value, 8e-3) << deviation.mass;
    int other_count = 0;
    before.for_each([&](int x, int y, int z) {
        other_count += std::abs(plain.at(x, y, z).soil - expected.at(x, y, z).soil) > 8e-3;
    });
    EXPECT_GT(other_count, 20) << "density decides too little to test anything";
}

/// Slip passes of two strides, on CPU and GL. make_def: of a scenario and a backend.
template <typename MakeDef>
void expect_same_slips_on_gl(MakeDef&& make_def) {
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    const Scenario scenario{11, 24, 16, 24, 3};
    std::vector<StatePlanes> after;
    for (const Backend backend : {Backend::cpu, Backend::gl}) {
        StageBench bench(make_def(scenario, backend));
        prepare(bench, scenario);
        bench.slip(1);
        bench.build_spans();
        bench.slip(1, 3);
        after.push_back(bench.read());
    }
    EXPECT_TRUE(after[0] == after[1]) << "CPU and GL differ";
}

TEST(SlippageOfCompactedSoil, has_the_same_bits_on_gl) {
    expect_same_slips_on_gl([](const Scenario& scenario, Backend backend) {
        return kept_cohesion_def(scenario, backend, true);
    });
}

TEST(SlippageOfFailingSoil, has_the_same_bits_on_gl) {
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    const Scenario scenario{11, 24, 16, 24, 3};
    std::vector<StatePlanes> after;
    for (const Backend backend : {Backend::cpu, Backend::gl}) {
        StageBench bench(kept_cohesion_def(scenario, backend));
        prepare(bench, scenario);
        bench.write_cuts(random_cuts(scenario));
        bench.slip(1);
        bench.build_spans();
        bench.slip(1, 3);
        after.push_back(bench.read());
    }
    EXPECT_TRUE(after[0] == after[1]) << "CPU and GL differ";
}

TEST_P(Slippage, has_the_same_bits_on_gl) {
    expect_same_on_gl([](StageBench& bench) {
        bench.build_spans();
        bench.write_speeds(random_speeds(GetParam()));
        bench.slip(1);
        const std::vector<int32_t> speeds = bench.read_speeds();
        bench.build_spans();
        bench.slip(1, 4);
        return std::pair(bench.read(), speeds);
    });
}

/// Materials that are rough, viscous, and both; the last holds still.
SoilDef deposits_def(const Scenario& scenario, Backend backend) {
    SoilDef def = scenario.def();
    def.backend = backend;
    if (def.materials.empty()) def.materials = {def.material};
    for (size_t i = 0; i < def.materials.size(); ++i) {
        constexpr double kRoughness[] = {0.4, 0, 0.9}, kViscosity[] = {0.3, 0.6, 1};
        def.materials[i].cohesion_pa = 0;
        def.materials[i].roughness = kRoughness[i];
        def.materials[i].viscosity = kViscosity[i];
    }
    return def;
}

TEST_P(Slippage, of_rough_and_viscous_soil_follows_the_oracle) {
    StageBench bench(deposits_def(GetParam(), Backend::cpu));
    for (const auto& [substeps, stride] : {std::pair(1, 1), {2, 1}, {1, 2}}) {
        SCOPED_TRACE("stride " + std::to_string(stride));
        prepare(bench, GetParam());
        const oracle::Field before = bench.to_field(bench.read());
        bench.slip(substeps, stride);
        oracle::Model model = bench.model(substeps);
        model.slip_stride = stride;
        model.pass = static_cast<uint32_t>(bench.impl().params.chance);
        const size_t speed_count = static_cast<size_t>(before.nx) * before.ny * model.span_capacity;
        const oracle::Slippage expected = oracle::slip_soil(
            model, before, oracle::SlipSpeeds(speed_count, 0.0), tabulated(bench));
        const FieldDeviation deviation =
            compare(bench.to_field(bench.read()), expected.field, GetParam().material_count);
        const double tolerance = 8 * 1e-3 * stride;  // as above
        EXPECT_LT(deviation.soil.value, tolerance) << deviation.soil;
        EXPECT_LT(deviation.mass.value, tolerance) << deviation.mass;
        // Chance holds some of what slides without it, and not all of it.
        model.roughness.clear();
        model.viscosity.clear();
        const oracle::Slippage plain = oracle::slip_soil(
            model, before, oracle::SlipSpeeds(speed_count, 0.0), tabulated(bench));
        int moved_count = 0, moved_plain_count = 0;
        before.for_each([&](int x, int y, int z) {
            moved_count += before.at(x, y, z).soil != expected.field.at(x, y, z).soil;
            moved_plain_count += before.at(x, y, z).soil != plain.field.at(x, y, z).soil;
        });
        EXPECT_LT(moved_count, moved_plain_count);
        EXPECT_GT(moved_count, stride == 1 ? 20 : -1);
    }
}

// Where slides keep their momentum a failing slope drives what lies on it.
// docs/decisions/run_out.md
TEST_P(Slippage, that_sets_soil_in_motion_follows_the_oracle) {
    SoilDef def = GetParam().def();
    def.backend = Backend::cpu;
    def.slides = SlideMotion::run_out;
    StageBench bench(def);
    prepare(bench, GetParam());
    const oracle::Field before = bench.to_field(bench.read());
    bench.impl().params.slide_kick = bench.impl().params.gravity_q16 * kOneQ8;
    bench.slip(1);
    const oracle::Model model = bench.model();
    const oracle::Slippage expected = oracle::slip_soil(
        model, before,
        oracle::SlipSpeeds(static_cast<size_t>(before.nx) * before.ny * model.span_capacity, 0.0),
        tabulated(bench));
    const FieldDeviation deviation =
        compare(bench.to_field(bench.read()), expected.field, GetParam().material_count);
    EXPECT_LT(deviation.soil.value, 8e-3) << deviation.soil;  // as above
    EXPECT_LT(deviation.mass.value, 8e-3) << deviation.mass;
    EXPECT_LT(deviation.momentum.value, 8e-3) << deviation.momentum;
}

TEST(SlippageOfDeposits, has_the_same_bits_on_gl) {
    expect_same_slips_on_gl(
        [](const Scenario& scenario, Backend backend) { return deposits_def(scenario, backend); });
}

// A pit of one column in a load on a plate, and a crumb over what lies in it: so its top jumps to
// the voxel's end once half of that is full, and not once all of it is. Each of eight neighbours
// gives a sixteenth of what is missing to the half: 194 units. It gave one of what is missing to
// the whole, 2114, and all eight filled the pit by more than the half.
TEST(SlippageOnABody, fills_no_voxel_beyond_where_its_top_jumps) {
    SoilDef def = grid_def(16, 16, 8);
    def.material = sand(5);
    StageBench bench(def);
    StatePlanes planes = bench.empty_planes();
    const auto put = [&](int x, int y, int z, int units) {
        planes.at(kPlaneVolume, x, y, z) = planes.at(kPlaneMaterial, x, y, z) = units;
    };
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) put(x, y, 2, 42000);
    }
    constexpr int kHeld = 10000;
    put(8, 8, 2, kHeld);
    put(8, 8, 3, 100);
    bench.write(planes);
    const double voxel = def.voxel_m;
    std::vector<Mover> movers;  // a plate under all of it, up to 0.3 of the third layer
    movers.emplace_back(0, box_shape(Vec3{10, 10, 2.15} * voxel), Vec3{8, 8, 0.15} * voxel);
    bench.place(movers);
    bench.find_support();
    bench.build_spans();
    const StatePlanes before = bench.read();
    ASSERT_EQ(before.at(kPlaneSupport, 8, 8, 2), kSupportBody);
    const int covered = before.at(kPlaneCoverage, 8, 8, 2);
    ASSERT_NEAR(covered, 0.3 * kVoxelFull, 10);
    bench.slip(1);
    const int missing = kVoxelFull - kCarrySlack - covered - kHeld;
    EXPECT_NEAR(bench.read().at(kPlaneVolume, 8, 8, 2), kHeld + 8 * (missing / 16), 16);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Slippage, testing::ValuesIn(all_scenarios()),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil::slippage_test
