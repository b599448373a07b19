// Wells: what they take out of the soil's pores and bring to them, and the account of it.
#include "flow_fixture.h"

namespace bsoil::well_test {
namespace {

/// A bed of 8 voxels in the whole grid, of sand that holds a fifth of its mass of water.
std::unique_ptr<Soil> bed(double saturation, Backend backend = Backend::cpu, int threads = 0) {
    SoilDef def = grid_def(24, 24, 16, kVoxel);
    def.material = sand(30);
    def.material.pore_water_fraction = 0.2;
    def.material.placed_saturation = saturation;
    def.material.moist_cohesion_pa = 500;
    def.material.conductivity_m_s = 2e-3;
    def.material.residual_saturation = 0.1;
    def.backend = backend;
    def.thread_count = threads;
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {24, 24, 8})));
    return soil;
}

/// A box of 4 x 4 x 3 voxels in the middle of the bed, one voxel over the floor.
SinkDef well(double water_kg_s) {
    SinkDef sink =
        box_sink({10 * kVoxel, 10 * kVoxel, kVoxel}, {14 * kVoxel, 14 * kVoxel, 4 * kVoxel});
    sink.water_kg_s = water_kg_s;
    return sink;
}

void run_s(Soil& soil, double time_s) {
    for (int64_t i = std::lround(time_s / soil.def().step_s); i > 0; --i) soil.step({});
}

TEST(Well, takes_and_brings_water_at_its_rate_and_no_soil) {
    for (const double rate_kg_s : {0.01, -0.01, 1e-3}) {
        auto soil = bed(0.6);
        const SoilTotals start = soil->totals();
        const int id = *soil->add_sink(well(rate_kg_s));
        run_s(*soil, 60.5);
        const SoilTotals now = soil->totals();
        const FlowState state = *soil->flow_state(id);
        // Its first look brings nothing yet.
        EXPECT_NEAR(state.mass_kg, 60 * std::abs(rate_kg_s), 1.2 * std::abs(rate_kg_s));
        EXPECT_EQ(state.missed_units, 0);
        EXPECT_EQ(rate_kg_s > 0 ? now.water_units_out : now.water_units_in, state.units);
        EXPECT_EQ(rate_kg_s > 0 ? now.water_units_in : now.water_units_out, 0);
        EXPECT_EQ(now.water_units, start.water_units + now.water_units_in - now.water_units_out);
        EXPECT_EQ(now.units, start.units);
        EXPECT_EQ(now.units_out, start.units_out);
        EXPECT_EQ(soil->moved_kg(FlowWay::out), 0);
        EXPECT_EQ(soil->status_bits(), 0u);
    }
}

// More than the soil gives: it takes what flows towards it, and misses the rest.
TEST(Well, dries_the_soil_around_it_to_its_residual_water) {
    auto soil = bed(0.6);
    const int id = *soil->add_sink(well(20));
    run_s(*soil, 120);
    for (int z = 1; z < 4; ++z) EXPECT_NEAR(soil->sample(11, 11, z).saturation, 0.1, 0.12) << z;
    // Suction draws water towards it from beside.
    EXPECT_LT(soil->sample(9, 11, 2).saturation, 0.9 * soil->sample(2, 2, 2).saturation);
    const FlowState state = *soil->flow_state(id);
    EXPECT_GT(state.missed_units, state.units);
    EXPECT_GT(state.mass_kg, 48 * 0.5 * 0.2 * 1600 * std::pow(kVoxel, 3));
}

TEST(Well, that_brings_water_fills_pores_and_no_more) {
    auto soil = bed(0.2);
    const int id = *soil->add_sink(well(-20));
    run_s(*soil, 60);
    EXPECT_GT(soil->sample(11, 11, 2).saturation, 0.95);
    EXPECT_LE(soil->sample(11, 11, 2).saturation, 1);
    EXPECT_GT(soil->flow_state(id)->missed_units, 0);
    EXPECT_GT(soil->sample(8, 11, 2).saturation, 0.25);
}

TEST(Well, ends_moves_and_is_removed) {
    auto soil = bed(0.6);
    SinkDef def = well(0.05);
    def.start_s = 10;
    def.end_s = 30;
    const int id = *soil->add_sink(def);
    run_s(*soil, 9.5);
    EXPECT_EQ(soil->flow_state(id)->units, 0);
    Pose aside = def.pose;
    aside.position.x += 4 * kVoxel;
    EXPECT_TRUE(soil->move_sink(id, aside));
    run_s(*soil, 50);
    // It goes by what its last look left; a tenth of what it takes in a second may have come since.
    EXPECT_NEAR(soil->flow_state(id)->mass_kg, 20 * 0.05, 0.1 * 0.05);
    EXPECT_LT(soil->sample(15, 11, 2).saturation, soil->sample(3, 11, 2).saturation);
    EXPECT_TRUE(soil->remove_flow(id));
}

TEST(Well, is_refused_where_it_makes_no_sense) {
    auto soil = bed(0.6);
    SinkDef both = well(1);
    both.rate_kg_s = 1;
    auto made = soil->add_sink(both);
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().find("sink.water_kg_s is 1"), std::string::npos) << made.error();
    made = soil->add_sink(well(2e9));
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().find("sink.water_kg_s"), std::string::npos) << made.error();
    SoilDef dry = soil->def();
    dry.material.pore_water_fraction = 0;
    made = make_soil(dry)->add_sink(well(1));
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().find("pore_water_fraction is 0"), std::string::npos) << made.error();
}

TEST(Well, has_the_same_bits_on_gl_on_threads_and_from_a_snapshot) {
    const auto with_wells = [](Backend backend, int threads) {
        auto soil = bed(0.6, backend, threads);
        EXPECT_TRUE(soil->add_sink(well(0.3)));
        SinkDef brings = well(-0.2);
        brings.pose.position.x -= 3 * kVoxel;  // they meet
        EXPECT_TRUE(soil->add_sink(brings));
        return soil;
    };
    auto soil = with_wells(Backend::cpu, 0), twin = bed(0.6, Backend::cpu, 3);
    std::vector<uint64_t> sums;
    constexpr int kSteps = 310, kSaved = 150;
    for (int i = 0; i < kSteps; ++i) {
        if (i == kSaved) {
            const auto put = twin->prepare(soil->state());
            ASSERT_TRUE(put) << put.error();
            (*put)();
        }
        soil->step({});
        sums.push_back(soil->checksum());
        if (i < kSaved) continue;
        twin->step({});
        ASSERT_EQ(twin->checksum(), sums.back()) << "step " << i;
    }
    EXPECT_GT(soil->totals().water_units_in, 0);
    EXPECT_EQ(soil->totals().water_units_in, twin->totals().water_units_in);
    EXPECT_EQ(soil->totals().water_units_out, twin->totals().water_units_out);
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    auto on_gl = with_wells(Backend::gl, 0);
    for (size_t i = 0; i < sums.size(); ++i) {
        on_gl->step({});
        ASSERT_EQ(on_gl->checksum(), sums[i]) << "step " << i << " on GL";
    }
}

}  // namespace
}  // namespace bsoil::well_test
