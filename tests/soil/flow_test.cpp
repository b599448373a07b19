// Soil that comes and goes: sources, sinks, open sides. All of it is counted.
#include <cmath>
#include <functional>
#include <numbers>

#include "flow_fixture.h"

namespace bsoil::flow_test {
namespace {

class Rates : public testing::TestWithParam<double> {};

TEST_P(Rates, are_exact_with_any_step) {
    const auto soil = make_soil(flow_def(GetParam()));
    SourceDef source = pipe(37.7);
    source.start_s = 0.31;
    source.end_s = 1.87;
    const auto id = soil->add_source(source);
    ASSERT_TRUE(id) << id.error();
    const SoilTotals start = soil->totals();
    for (int i = 0; i < std::lround(3 / GetParam()); ++i) soil->step({});
    // To the last unit of 4 mg.
    const auto due =
        static_cast<int64_t>(std::floor(37.7 / SoilProbe::impl(*soil).kg_per_unit * (1.87 - 0.31)));
    EXPECT_EQ(sum(soil->totals().units_in), due);
    EXPECT_EQ(soil->flow_state(*id)->units, due);
    EXPECT_EQ(soil->flow_state(*id)->missed_units, 0);
    expect_balance(*soil, start);
}

INSTANTIATE_TEST_SUITE_P(Steps, Rates, testing::Values(1.0 / 30, 1.0 / 60, 1.0 / 240));

TEST(Source, pours_little_by_little_in_lumps_and_loses_nothing) {
    const auto soil = make_soil(flow_def());
    ASSERT_TRUE(soil->add_source(pipe(0.02)));  // 87 units a step, where a lump has 16384
    for (int i = 0; i < 600; ++i) soil->step({});
    const double kg = 0.02 * 10;
    const double poured = soil->totals().mass_kg[0];
    EXPECT_LE(poured, kg);
    EXPECT_GT(poured, kg - 16385 * SoilProbe::impl(*soil).kg_per_unit);
}

TEST(Source, volume_is_that_of_loose_soil) {
    SoilDef def = flow_def();
    def.material = materials::dry_sand();
    const auto soil = make_soil(def);
    SourceDef source = pipe(0);
    source.rate_m3_s = 0.02;
    source.end_s = 1;
    ASSERT_TRUE(soil->add_source(source));
    for (int i = 0; i < 90; ++i) soil->step({});
    EXPECT_NEAR(soil->totals().mass_kg[0], 0.02 * def.material.loose_density_kg_m3, 1e-5);
}

// A jet along x from 1.2 m lands v sqrt(2 h / g) on. Within a voxel. Measured: 2 mm. With a fifth
// of the rate it is 12 cm too short: soil thinner than a sixteenth of a voxel flies too slowly.
TEST(Source, jet_flies_its_parabola_in_any_grid) {
    for (const double yaw : {0.0, 0.5}) {
        SoilDef def = flow_def();
        def.size_m = {6, 2.4, 1.6};
        def.yaw_rad = yaw;
        def.floor_center_m = {};
        const auto soil = make_soil(def);
        SourceDef source;
        const Vec3 along{std::cos(yaw), std::sin(yaw), 0};
        source.center_m = -2.5 * along + Vec3{0, 0, 1.2};
        source.direction = 3.0 * along;  // its length does not matter
        source.radius_m = 0.1;
        source.speed_m_s = 4;
        source.rate_kg_s = 50;
        source.end_s = 0.1;
        ASSERT_TRUE(soil->add_source(source));
        for (int i = 0; i < 60; ++i) soil->step({});
        double mass = 0, moment = 0, aside = 0;
        const GridFrame& frame = soil->frame();
        for (int x = 0; x < frame.size[0]; ++x) {
            for (int y = 0; y < frame.size[1]; ++y) {
                for (int z = 0; z < frame.size[2]; ++z) {
                    const double volume = soil->sample(x, y, z).volume;
                    mass += volume;
                    moment += volume * (x + 0.5) * kVoxel;
                    aside += volume * (y + 0.5) * kVoxel;
                }
            }
        }
        const double way_m = 4 * std::sqrt(2 * 1.2 / def.gravity_m_s2);
        EXPECT_NEAR(moment / mass - 0.5, way_m, kVoxel) << "yaw " << yaw;
        EXPECT_NEAR(aside / mass, 1.2, 0.02) << "yaw " << yaw;
    }
}

// 0.3 m above the floor as well, when what has landed before has made a heap. Where slides ran out,
// soil in flight over thin soil was put on the ground: at 1.33 m for 1.65.
TEST(Source, jet_flies_its_parabola_above_what_has_landed) {
    for (const SlideMotion slides : {SlideMotion::settle, SlideMotion::run_out}) {
        SoilDef def = flow_def();
        def.size_m = {2.4, 0.8, 1.2};
        def.floor_center_m = {1.2, 0.4, 0};
        def.slides = slides;
        const auto soil = make_soil(def);
        SourceDef source;
        source.center_m = {0.3, 0.4, 1.0};
        source.direction = {1, 0, 0};
        source.radius_m = 0.08;
        source.speed_m_s = 3;
        source.rate_kg_s = 10;
        ASSERT_TRUE(soil->add_source(source));
        double mass = 0, moment = 0;
        for (int i = 0; i < 75; ++i) {
            soil->step({});
            if (i < 45) continue;
            for (int x = 0; x < soil->frame().size[0]; ++x) {
                for (int y = 0; y < soil->frame().size[1]; ++y) {
                    const double volume = soil->sample(x, y, 6).volume;
                    mass += volume;
                    moment += volume * (x + 0.5) * kVoxel;
                }
            }
        }
        const double fall_m = 1.0 - 6.5 * kVoxel;
        const double way_m = 3 * std::sqrt(2 * fall_m / def.gravity_m_s2);
        EXPECT_NEAR(moment / mass - 0.3, way_m, kVoxel / 2)
            << (slides == SlideMotion::settle ? "settle" : "run_out");
    }
}

// Over 3 s, so that every voxel of it has had its turn.
TEST(Source, rectangle_lies_as_it_is_turned) {
    const auto soil = make_soil(flow_def());
    SourceDef source;
    source.shape = SourceDef::Shape::rectangle;
    source.center_m = {1.2, 1.2, 0.5};
    source.length_m = 1.6;
    source.width_m = 0.2;
    source.turn_rad = std::numbers::pi / 2;
    source.rate_m3_s = 0.004;
    ASSERT_TRUE(soil->add_source(source));
    for (int i = 0; i < 180; ++i) soil->step({});
    EXPECT_GT(soil->surface_height_m(24, 10), 0.01) << "along y";
    EXPECT_GT(soil->surface_height_m(24, 37), 0.01);
    EXPECT_EQ(soil->surface_height_m(10, 24), 0) << "not along x";
    EXPECT_EQ(soil->surface_height_m(37, 24), 0);
}

TEST(Source, spread_widens_a_jet) {
    double width[2];
    for (const bool is_wide : {false, true}) {
        const auto soil = make_soil(flow_def());
        SourceDef source = pipe(20);
        source.radius_m = 0.05;
        source.speed_m_s = 3;
        source.spread_rad = is_wide ? 0.3 : 0;
        source.end_s = 0.05;
        ASSERT_TRUE(soil->add_source(source));
        for (int i = 0; i < 20; ++i) soil->step({});
        double mass = 0, square = 0;
        for (int x = 0; x < 48; ++x) {
            for (int y = 0; y < 48; ++y) {
                for (int z = 0; z < 32; ++z) {
                    const double volume = soil->sample(x, y, z).volume;
                    mass += volume;
                    square += volume * (std::pow(x + 0.5 - 24, 2) + std::pow(y + 0.5 - 24, 2));
                }
            }
        }
        width[is_wide] = std::sqrt(square / mass) * kVoxel;
    }
    // By hand: 1.1 m down take 0.256 s, aside by up to 3 tan 0.3 of that along each axis, evenly:
    // sqrt(2 / 3) of it. Lumps that meet in a voxel share their momentum, so that it is less.
    const double found_m = std::sqrt(width[1] * width[1] - width[0] * width[0]);
    const double alone_m = std::sqrt(2.0 / 3) * 3 * std::tan(0.3) * 0.256;
    EXPECT_GT(found_m, 0.4 * alone_m);
    EXPECT_LT(found_m, 1.1 * alone_m);
}

TEST(Source, waits_for_room_and_holds_back_what_never_finds_any) {
    SoilDef def = flow_def();
    def.size_m = {0.8, 0.8, 1.6};
    def.floor_center_m = {1.2, 1.2, 0};
    const auto soil = make_soil(def);
    SourceDef source = pipe(60);
    source.center_m.z = 0.8;
    const auto id = soil->add_source(source);
    ASSERT_TRUE(id) << id.error();
    const SoilTotals start = soil->totals();
    for (int i = 0; i < 1800; ++i) soil->step({});
    const FlowState full = *soil->flow_state(*id);
    // 0.8 x 0.8 x 0.8 m below the pipe, and a heap of a hand's breadth at most around it.
    EXPECT_GT(full.mass_kg, 0.8 * 0.8 * 0.7 * 1400);
    EXPECT_LT(full.mass_kg, 0.8 * 0.8 * 1.0 * 1700);
    EXPECT_NEAR(full.mass_kg + full.missed_kg, 60 * 30, 9 * 60 / 60.0);
    expect_balance(*soil, start);
    EXPECT_EQ(soil->status_bits(), 0u);
    ASSERT_TRUE(soil->add_sink(box_sink({0.8, 0.8, 0}, {1.6, 1.6, 0.4})));
    for (int i = 0; i < 120; ++i) soil->step({});
    // Within 8 steps it makes up for 8 of them.
    EXPECT_NEAR(soil->flow_state(*id)->mass_kg - full.mass_kg, 60 * 2, 9 * 60 / 60.0 + 2);
    expect_balance(*soil, start);
}

TEST(Sink, box_takes_all_that_lies_in_it_or_comes) {
    const auto soil = make_soil(flow_def());
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 48, 8})));
    const SoilTotals start = soil->totals();
    const auto id = soil->add_sink(box_sink({1.0, 1.0, 0}, {1.4, 1.4, 1}));
    ASSERT_TRUE(id) << id.error();
    for (int i = 0; i < 600; ++i) {
        soil->step({});
        ASSERT_EQ(soil->mass_inside_kg(box_shape({0.2, 0.2, 0.5}), {{1.2, 1.2, 0.5}, {}}), 0) << i;
    }
    expect_balance(*soil, start);
    // What is left is a pit with slopes of phi: soil 0.4 m deep stands back by up to 0.4 / tan phi.
    const double far_m = 0.4 / std::tan(soil->materials()[0].friction_angle_rad);
    EXPECT_LT(soil->surface_height_m(28, 24), 2 * kVoxel);
    EXPECT_NEAR(soil->surface_height_m(28 + static_cast<int>(far_m / kVoxel) + 2, 24), 0.4, kVoxel);
    EXPECT_EQ(soil->status_bits(), 0u);
}

TEST(Sink, suction_takes_its_rate_and_what_there_is_at_most) {
    const auto soil = make_soil(flow_def());
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 48, 8})));
    const SoilTotals start = soil->totals();
    SinkDef sink;
    sink.region = sphere_shape(0.3);
    sink.pose.position = {1.2, 1.2, 0.4};
    sink.rate_kg_s = 12;
    sink.start_s = 0.5;
    const auto id = soil->add_sink(sink);
    ASSERT_TRUE(id) << id.error();
    for (int i = 0; i < 30; ++i) soil->step({});
    EXPECT_EQ(soil->flow_state(*id)->units, 0);
    for (int i = 0; i < 300; ++i) soil->step({});
    // To a step's share.
    EXPECT_NEAR(soil->flow_state(*id)->mass_kg, 12 * 5, 0.2);
    EXPECT_EQ(soil->flow_state(*id)->missed_units, 0);
    expect_balance(*soil, start);
    // Dig it all away: nothing is left to take, and nothing is owed.
    ASSERT_TRUE(soil->take_out(box_shape({3, 3, 3}), {}));
    const double taken = soil->flow_state(*id)->mass_kg;
    for (int i = 0; i < 300; ++i) soil->step({});
    EXPECT_EQ(soil->flow_state(*id)->mass_kg, taken);
    EXPECT_NEAR(soil->flow_state(*id)->missed_kg, 12 * 5, 9 * 12 / 60.0);
    // New soil is taken at the rate again, and what was missed is not made up for.
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 48, 8})));
    for (int i = 0; i < 60; ++i) soil->step({});
    EXPECT_NEAR(soil->flow_state(*id)->mass_kg - taken, 12, 9 * 12 / 60.0);
}

/// Of a bed in all of a grid of 16 x 16 columns.
double volume_voxels(const Soil& soil) {
    double volume = 0;
    for (int z = 0; z < 8; ++z) {
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) volume += soil.sample(x, y, z).volume;
        }
    }
    return volume;
}

// A unit out of each voxel in each step. Rounded down, mass and room are two different parts of
// what there is: 1 of 52428 and 2 of 65536.
TEST(Sink, slow_suction_leaves_soil_as_dense_as_it_was) {
    SoilDef def = grid_def(16, 16, 16, kVoxel);
    def.material = fixed_density(sand(32));
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {16, 16, 8})));
    SinkDef sink = box_sink({0, 0, 0}, {0.8, 0.8, 0.8});
    sink.rate_kg_s = 2048 * 60 * SoilProbe::impl(*soil).kg_per_unit;
    ASSERT_TRUE(soil->add_sink(sink));
    const double volume = volume_voxels(*soil), mass_kg = soil->totals().mass_kg[0];
    for (int i = 0; i < 300; ++i) soil->step({});
    const double mass_share = 1 - soil->totals().mass_kg[0] / mass_kg;
    ASSERT_GT(mass_share, 0.004);
    // Chance: half a unit a voxel and step, over 2048 x 300 of them.
    EXPECT_NEAR((1 - volume_voxels(*soil) / volume) / mass_share, 1, 0.01);
}

// 46080 voxels, of which a step's due is an eleventh of a unit each.
TEST(Sink, slow_suction_out_of_much_soil_waits_and_misses_nothing) {
    const auto soil = make_soil(flow_def());
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 48, 20})));
    const SoilTotals start = soil->totals();
    SinkDef sink = box_sink({0, 0, 0}, {2.4, 2.4, 1.2});
    sink.rate_kg_s = 4096 * 60 * SoilProbe::impl(*soil).kg_per_unit;
    const auto id = soil->add_sink(sink);
    ASSERT_TRUE(id) << id.error();
    for (int i = 0; i < 40; ++i) soil->step({});
    const FlowState state = *soil->flow_state(*id);
    EXPECT_EQ(state.missed_units, 0);
    EXPECT_GT(state.units, 20 * 4096);
    expect_balance(*soil, start);
}

// What its region held before says nothing of a heap that it is moved to, or that comes: it took
// all of one in a step, 380 voxels of it here.
TEST(Sink, suction_takes_no_more_than_its_rate_of_soil_that_is_new_to_it) {
    for (const bool is_moved : {true, false}) {
        const auto soil = make_soil(flow_def());
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {4, 4, 0}, {5, 5, 1})));
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {20, 20, 0}, {30, 30, 8})));
        SinkDef sink = box_sink({0.1, 0.1, 0}, {0.5, 0.5, 0.3});
        constexpr int64_t kUnits = 20000;  // a step
        sink.rate_kg_s = kUnits * 60 * SoilProbe::impl(*soil).kg_per_unit;
        const auto id = soil->add_sink(sink);
        ASSERT_TRUE(id) << id.error();
        for (int i = 0; i < 2; ++i) soil->step({});
        ASSERT_GT(soil->flow_state(*id)->units, 0);
        if (is_moved) {
            ASSERT_TRUE(soil->move_sink(*id, {{1.25, 1.25, 0.2}, {}}));
        } else {
            ASSERT_TRUE(soil->fill(voxel_box(*soil, {2, 2, 0}, {10, 10, 6})));
        }
        for (int i = 0; i < 5; ++i) {
            soil->step({});
            EXPECT_LE(soil->flow_state(*id)->units, (3 + i) * kUnits);
        }
        EXPECT_GT(soil->flow_state(*id)->units, 6 * kUnits);
    }
}

/// Slope of the ground between two columns along x [rad].
double slope_between(const Soil& soil, int x0, int x1, int y) {
    return std::atan((soil.surface_height_m(x1, y) - soil.surface_height_m(x0, y)) /
                     ((x1 - x0) * kVoxel));
}

// The bed is 0.4 m high: its slope is 13 voxels long, and its foot stands at the edge.
TEST(OpenSide, lets_a_bed_run_out_to_its_angle_of_repose) {
    SoilDef def = grid_def(48, 16, 16);
    def.material = fixed_density(sand(32));
    def.open_sides = kOpenHighX;
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 16, 8})));
    const SoilTotals start = soil->totals();
    const auto settled = soil->settle(3000);
    ASSERT_TRUE(settled);
    EXPECT_TRUE(settled->is_at_rest);
    expect_balance(*soil, start);
    EXPECT_EQ(soil->surface_height_m(47, 8), 0);
    EXPECT_NEAR(slope_between(*soil, 44, 38, 8), -32 * std::numbers::pi / 180, 0.03);
    EXPECT_NEAR(soil->surface_height_m(0, 8), 0.4, 1e-6) << "the other sides are walls";
    EXPECT_NEAR(soil->surface_height_m(20, 0), 0.4, 1e-6);
    // What is gone is that wedge, whose foot is the middle of the column on the edge, and the rest
    // of that column.
    const double wedge_m2 =
        0.4 * 0.4 / 2 / std::tan(32 * std::numbers::pi / 180) + 0.4 * kVoxel / 2;
    EXPECT_NEAR(
        static_cast<double>(soil->totals().units_out[0]) * SoilProbe::impl(*soil).kg_per_unit,
        wedge_m2 * 0.8 * def.material.density_kg_m3, 0.05 * 60);
    EXPECT_EQ(soil->status_bits(), 0u);
}

TEST(OpenSide, is_the_same_side_of_the_world_whichever_axis_is_up) {
    struct Case {
        UpAxis up;
        int bit;
        Vec3 toward;
    };
    for (const auto& [up, bit, toward] :
         {Case{UpAxis::z, kOpenLowX, {-1, 0, 0}}, Case{UpAxis::z, kOpenHighX, {1, 0, 0}},
          Case{UpAxis::z, kOpenLowY, {0, -1, 0}}, Case{UpAxis::z, kOpenHighY, {0, 1, 0}},
          Case{UpAxis::y, kOpenLowX, {-1, 0, 0}}, Case{UpAxis::y, kOpenHighX, {1, 0, 0}},
          Case{UpAxis::y, kOpenLowZ, {0, 0, -1}}, Case{UpAxis::y, kOpenHighZ, {0, 0, 1}}}) {
        const bool is_y_up = up == UpAxis::y;
        SoilDef def;
        def.up = up;
        def.size_m = is_y_up ? Vec3{1.5, 0.8, 1.1} : Vec3{1.5, 1.1, 0.8};
        def.open_sides = bit;
        def.backend = Backend::cpu;
        const auto soil = make_soil(def);
        ASSERT_TRUE(soil->fill(BoxFill{{{-5, is_y_up ? 0.0 : -5, is_y_up ? -5 : 0.0},
                                        {5, is_y_up ? 0.3 : 5, is_y_up ? 5 : 0.3}},
                                       {}}));
        for (int i = 0; i < 30; ++i) soil->step({});
        const auto height = [&](Vec3 side) {
            const Vec3 at = soil->frame().to_grid(
                {0.74 * side.x, is_y_up ? 0 : 0.54 * side.y, is_y_up ? 0.54 * side.z : 0});
            return soil->surface_height_m(static_cast<int>(at.x), static_cast<int>(at.y));
        };
        EXPECT_EQ(height(toward), 0) << bit;
        EXPECT_NEAR(height(-toward), 0.3, 1e-6) << bit;
    }
}

}  // namespace
}  // namespace bsoil::flow_test
