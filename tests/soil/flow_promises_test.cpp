// What soil promises holds for sources, sinks and open sides: the same bits, snapshots, no
// allocation, no cost where there are none, nothing taken that cannot be.
#include <cmath>
#include <functional>

#include "allocation_count.h"
#include "base/kernels.h"
#include "bsoil/snapshot_file.h"
#include "cure.h"
#include "device/kernel_set.h"
#include "flow_fixture.h"
#include "soil/soil_kernels.h"

namespace bsoil::flow_promises_test {
namespace {

/// A pipe over a bed with an open side and a suction, a body in it.
struct Plant {
    std::unique_ptr<Soil> soil;
    std::vector<Mover> movers;

    explicit Plant(SoilDef def) {
        def.materials = {sand(32), materials::dry_sand()};
        def.materials[1].name = "other";
        def.open_sides = kOpenHighX | kOpenLowY;
        soil = make_soil(def);
        movers.emplace_back(1, box_shape(Vec3{3, 4, 4} * kVoxel), Vec3{0.8, 1.2, 0.5});
    }
    void start() const {
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 48, 6})));
        SourceDef source = pipe(25);
        source.material = "other";
        source.speed_m_s = 4;
        source.spread_rad = 0.1;
        source.direction = {0.4, 0.1, -1};
        EXPECT_TRUE(soil->add_source(source));
        SinkDef sink = box_sink({0.2, 0.2, 0}, {1, 1, 1});
        sink.rate_kg_s = 9;
        EXPECT_TRUE(soil->add_sink(sink));
        sink = box_sink({1.6, 1.6, 0}, {2, 2, 1});
        EXPECT_TRUE(soil->add_sink(sink));
    }
    void run(int steps) {
        for (int i = 0; i < steps; ++i) {
            movers[0].set_velocity({0.6, 0.1, -0.2});
            movers[0].advance(1.0 / 60);
            soil->step(bodies_of(movers));
        }
    }
};

TEST(Flows, are_the_same_on_any_number_of_threads_and_on_gl) {
    SoilDef def = flow_def();
    def.backend = Backend::cpu;
    def.thread_count = 1;
    Plant one(def);
    one.start();
    one.run(25);
    const SoilTotals totals = one.soil->totals();
    EXPECT_GT(totals.units_in[1], 0);
    EXPECT_GT(totals.units_out[0], 0);
    def.thread_count = 2;
    Plant two(def);
    two.start();
    two.run(25);
    EXPECT_EQ(two.soil->checksum(), one.soil->checksum());
    EXPECT_EQ(two.soil->totals().units_out, totals.units_out);
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    def.backend = Backend::gl;
    Plant gl(def);
    gl.start();
    gl.run(25);
    EXPECT_EQ(gl.soil->checksum(), one.soil->checksum());
    EXPECT_EQ(gl.soil->totals().units_in, totals.units_in);
    EXPECT_EQ(gl.soil->totals().units_out, totals.units_out);
}

TEST(Flows, go_on_bit_for_bit_from_a_snapshot) {
    Plant through(flow_def());
    through.start();
    through.run(31);
    const std::vector<uint8_t> state = through.soil->state();
    Plant later(flow_def());  // without its sources and sinks: the state brings them
    later.movers[0].body.pose = through.movers[0].body.pose;
    later.movers[0].body.center_of_mass_m = through.movers[0].body.center_of_mass_m;
    auto put = later.soil->prepare(state);
    ASSERT_TRUE(put) << put.error();
    (*put)();
    EXPECT_EQ(later.soil->state(), state);
    through.run(40);
    later.run(40);
    EXPECT_EQ(later.soil->checksum(), through.soil->checksum());
    EXPECT_EQ(later.soil->totals().units_in, through.soil->totals().units_in);
    EXPECT_EQ(later.soil->totals().units_out, through.soil->totals().units_out);
    EXPECT_EQ(later.soil->flow_state(2)->missed_units, through.soil->flow_state(2)->missed_units);
    EXPECT_EQ(later.soil->state(), through.soil->state());
}

TEST(Flows, are_moved_and_removed) {
    const auto soil = make_soil(flow_def());
    const auto id = soil->add_source(pipe(30));
    ASSERT_TRUE(id);
    for (int i = 0; i < 60; ++i) soil->step({});
    EXPECT_GT(soil->surface_height_m(24, 24), 0.05);
    ASSERT_TRUE(soil->move_source(*id, {0.4, 0.4, 0.6}, {}));
    for (int i = 0; i < 60; ++i) soil->step({});
    EXPECT_GT(soil->surface_height_m(8, 8), 0.05);
    EXPECT_NEAR(soil->flow_state(*id)->mass_kg, 60, 0.6) << "its rate goes on";
    const auto sink = soil->add_sink(box_sink({0, 0, 0}, {0.8, 0.8, 1}));
    ASSERT_TRUE(soil->move_sink(*sink, {{1.2, 1.2, 0.5}, {}}));
    ASSERT_TRUE(soil->remove_flow(*id));
    for (int i = 0; i < 30; ++i) soil->step({});
    EXPECT_EQ(soil->surface_height_m(24, 24), 0);
    EXPECT_GT(soil->surface_height_m(8, 8), 0.05);
    EXPECT_FALSE(soil->flow_state(*id));
    EXPECT_FALSE(soil->remove_flow(*id));
    EXPECT_FALSE(soil->move_source(*sink, {}, {}));
    EXPECT_EQ(soil->flow_state(*sink)->units, sum(soil->totals().units_out));
    // An id is not given twice, and a source that comes late owes nothing of before.
    const auto late = soil->add_source(pipe(30));
    ASSERT_TRUE(late);
    EXPECT_GT(*late, *sink);
    for (int i = 0; i < 6; ++i) soil->step({});
    EXPECT_NEAR(soil->flow_state(*late)->mass_kg, 3, 0.6);
}

// What is poured falls into a sink: nothing grows.
TEST(Flows, allocate_nothing_once_warm) {
    SoilDef def = flow_def();
    def.open_sides = kOpenHighX;
    const auto soil = make_soil(def);
    SourceDef source = pipe(25);
    source.center_m.x = 1.8;
    source.speed_m_s = 2;
    ASSERT_TRUE(soil->add_source(source));
    ASSERT_TRUE(soil->add_sink(box_sink({1, 1, 0}, {2.3, 2.4, 0.2})));
    SinkDef suction = box_sink({1, 1, 0.3}, {2, 2.4, 0.9});
    suction.rate_kg_s = 5;
    ASSERT_TRUE(soil->add_sink(suction));
    for (int i = 0; i < 240; ++i) soil->step({});
    const int64_t before = allocation_count();
    for (int i = 0; i < 60; ++i) soil->step({});
    EXPECT_EQ(allocation_count() - before, 0);
    EXPECT_GT(soil->flow_state(3)->units, 0);
}

TEST(Flows, cost_nothing_where_there_are_none_and_little_at_rest) {
    const auto count = [](Soil& soil, layout::Kernel kernel) {
        return SoilProbe::impl(soil).device->counters().kernel_dispatch_counts[static_cast<size_t>(
            kernel)];
    };
    const auto without = make_soil(flow_def());
    ASSERT_TRUE(without->fill(voxel_box(*without, {0, 0, 0}, {10, 10, 10})));
    for (int i = 0; i < 30; ++i) without->step({});
    EXPECT_EQ(count(*without, layout::Kernel::pour_soil), 0);
    EXPECT_EQ(count(*without, layout::Kernel::take_soil), 0);
    // A side that is open, and a bed that has run out: asleep.
    SoilDef def = flow_def();
    def.open_sides = kOpenLowX;
    const auto open = make_soil(def);
    ASSERT_TRUE(open->fill(voxel_box(*open, {0, 0, 0}, {48, 48, 6})));
    ASSERT_TRUE(open->settle(3000)->is_at_rest);
    const int64_t dispatched = count(*open, layout::Kernel::take_soil);
    EXPECT_EQ(open->step({}).block_dispatched_count, 0);
    EXPECT_EQ(count(*open, layout::Kernel::take_soil), dispatched);
}

TEST(Flows, refuse_what_cannot_be_by_name) {
    SoilDef def = flow_def();
    const auto soil = make_soil(def);
    const double inf = INFINITY, nan = NAN;
    struct Case {
        std::function<void(SourceDef&)> change;
        const char* said;
    };
    for (const auto& [change, said] : std::vector<Case>{
             {[=](SourceDef& s) { s.center_m.x = nan; }, "source.center_m is nan"},
             {[=](SourceDef& s) { s.direction.y = inf; }, "source.direction is inf"},
             {[](SourceDef& s) {
                  s.center_m = {50, 50, 50};
              },
              "no voxel of the grid"},
             {[](SourceDef& s) { s.radius_m = 0; }, "source.radius_m is 0, must be"},
             {[](SourceDef& s) { s.radius_m = -1; }, "source.radius_m is -1"},
             {[](SourceDef& s) {
                  s.shape = SourceDef::Shape::rectangle;
                  s.width_m = 0;
              },
              "source.width_m is 0"},
             {[](SourceDef& s) { s.shape = static_cast<SourceDef::Shape>(7); },
              "source.shape is 7"},
             {[](SourceDef& s) { s.rate_kg_s = 0; }, "one of them must be above 0"},
             {[](SourceDef& s) { s.rate_m3_s = 1; }, "one of them must be above 0"},
             {[=](SourceDef& s) { s.rate_kg_s = nan; }, "source.rate_kg_s is nan"},
             {[](SourceDef& s) { s.rate_kg_s = 1e6; }, "which fill its region in every step"},
             {[](SourceDef& s) { s.speed_m_s = 99; }, "8 voxels a step"},
             {[](SourceDef& s) { s.speed_m_s = -1; }, "source.speed_m_s is -1"},
             {[](SourceDef& s) { s.spread_rad = 2; }, "source.spread_rad is 2"},
             {[](SourceDef& s) { s.turn_rad = 8; }, "source.turn_rad is 8"},
             {[](SourceDef& s) {
                  s.start_s = 3;
                  s.end_s = 2;
              },
              "source.end_s is 2, must be 3"},
             {[](SourceDef& s) { s.material = "snow"; }, "'snow' is not in this soil"}}) {
        SourceDef source = pipe(10);
        change(source);
        const auto added = soil->add_source(source);
        ASSERT_FALSE(added) << said;
        EXPECT_NE(added.error().find(said), std::string::npos) << added.error();
        EXPECT_TRUE(says_what_to_do(added.error())) << added.error();
    }
    SinkDef sink = box_sink({0, 0, 0}, {1, 1, 1});
    sink.region.half_extents_m.x = nan;
    EXPECT_FALSE(soil->add_sink(sink));
    sink = box_sink({9, 9, 9}, {10, 10, 10});
    EXPECT_FALSE(soil->add_sink(sink));
    sink = box_sink({0, 0, 0}, {1, 1, 1});
    sink.pose.rotation.w = inf;
    EXPECT_FALSE(soil->add_sink(sink));
    sink = box_sink({0, 0, 0}, {1, 1, 1});
    sink.rate_kg_s = -1;
    EXPECT_FALSE(soil->add_sink(sink));
    sink.region = octahedron_shape(0.3);
    sink.rate_kg_s = 1;
    EXPECT_FALSE(soil->add_sink(sink));
    EXPECT_EQ(sum(soil->totals().units_in), 0);
    for (int i = 0; i < 64; ++i) ASSERT_TRUE(soil->add_source(pipe(1))) << i;
    EXPECT_FALSE(soil->add_source(pipe(1))) << "64 at most";
    def.open_sides = kOpenHighZ;
    EXPECT_FALSE(def.validate()) << "up";
}

TEST(Flows, of_a_damaged_snapshot_are_refused) {
    Plant plant(flow_def());
    plant.start();
    plant.run(5);
    const std::vector<uint8_t> state = plant.soil->state();
    Plant other(flow_def());
    // The last bytes are theirs: any of them may be anything, and it is refused or sound.
    int refused = 0;
    for (size_t back = 1; back <= 700 && back < state.size(); back += 11) {
        std::vector<uint8_t> damaged = state;
        damaged[damaged.size() - back] ^= 0xff;
        auto put = other.soil->prepare(damaged);
        refused += !put;
        if (put) {
            (*put)();
            other.soil->step({});
        }
    }
    EXPECT_GT(refused, 10);
    SoilDef closed = flow_def();
    closed.materials = {sand(32), materials::dry_sand()};
    closed.materials[1].name = "other";
    const auto put = make_soil(closed)->prepare(state);
    ASSERT_FALSE(put);
    EXPECT_NE(put.error().find("open_sides"), std::string::npos) << put.error();
}

}  // namespace
}  // namespace bsoil::flow_promises_test
