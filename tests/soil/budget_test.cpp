// A budget: a step goes on in the next calls, and is the step that it would have been.
#include <algorithm>
#include <numeric>

#include "moving_scene.h"

namespace bsoil::budget_test {
namespace {

const device::DeviceCounters& counters_of(Soil& soil) {
    return SoilProbe::impl(soil).device->counters();
}

/// A clock that says the same on every machine: each dispatch takes a millisecond. Asking takes a
/// little, so that who waits for a GPU does not wait for ever.
void count_dispatches(Soil& soil) {
    Soil::Impl& impl = SoilProbe::impl(soil);
    impl.budget.now_ms = [&impl, asked = 0]() mutable {
        return static_cast<double>(impl.device->counters().dispatch_count) + 1e-2 * ++asked;
    };
}

int64_t all_units(const Soil& soil) {
    const SoilTotals totals = soil.totals();
    return std::accumulate(totals.units.begin(), totals.units.end(), int64_t{0});
}

/// Without finishing the step in progress.
double mass_kg(const Soil& soil) {
    const GridFrame& frame = soil.frame();
    Vec3 half{static_cast<double>(frame.size[0]), static_cast<double>(frame.size[1]),
              static_cast<double>(frame.size[2])};
    half = half * (0.5 * frame.voxel_m);
    return soil.mass_inside_kg(box_shape(half + Vec3{1, 1, 1}),
                               {frame.to_world(half * (1 / frame.voxel_m)), {}});
}

class Budget : public testing::TestWithParam<Backend> {
  protected:
    void SetUp() override {
        if (GetParam() == Backend::gl && !gl_missing().empty()) {
            GTEST_SKIP() << gl_missing();
        }
    }
    SoilDef def_with(double budget_ms, int spread_max = 1000) const {
        SoilDef def = MovingScene::default_def();
        def.backend = GetParam();
        def.step_budget_ms = budget_ms;
        def.step_spread_max = spread_max;
        return def;
    }
};

TEST_P(Budget, that_is_never_spent_changes_nothing) {
    MovingScene plain(4, def_with(0)), rich(4, def_with(1000));
    SoilProbe::impl(rich.soil()).budget.now_ms = [] { return 5.0; };
    for (int i = 0; i < 10; ++i) {
        EXPECT_TRUE(plain.step().has_finished);
        EXPECT_TRUE(rich.step().has_finished);
    }
    EXPECT_EQ(plain.soil().checksum(), rich.soil().checksum());
    EXPECT_EQ(rich.soil().status_bits(), plain.soil().status_bits());
    EXPECT_EQ(rich.soil().step_rate().share(), 1);
}

// A piece is the least that a call does: a kernel that only looks, one that moves and apply_flow.
TEST_P(Budget, holds_its_caller_no_longer_and_says_so) {
    constexpr int kBudget = 40, kPieceMost = 3, kCalls = 40;
    MovingScene scene(4, def_with(kBudget));
    count_dispatches(scene.soil());
    scene.step();  // the first one is made at a stretch
    const int64_t units = all_units(scene.soil());
    int finished = 0, calls_most = 0;
    for (int i = 0; i < kCalls; ++i) {
        const int64_t before = counters_of(scene.soil()).dispatch_count;
        const StepReport report = scene.step();
        EXPECT_LE(counters_of(scene.soil()).dispatch_count - before, kBudget + kPieceMost) << i;
        finished += report.has_finished;
        calls_most = std::max(calls_most, report.call_count);
    }
    const StepRate rate = scene.soil().step_rate();
    EXPECT_EQ(rate.due_count, kCalls + 1);
    EXPECT_GE(rate.begun_count, finished + 1);
    EXPECT_LE(rate.begun_count, finished + 2);
    EXPECT_LT(rate.share(), 0.8) << "a step has 60 dispatches and more";
    EXPECT_GT(rate.share(), 0.1);
    EXPECT_GE(rate.call_count_most, calls_most);
    EXPECT_GT(calls_most, 2);
    EXPECT_EQ(rate.held_count, 0);
    EXPECT_EQ(scene.soil().status_bits() & static_cast<uint32_t>(StatusBit::budget_exceeded), 0u);
    EXPECT_NE(scene.soil().status_bits() & static_cast<uint32_t>(StatusBit::rate_lowered), 0u);
    EXPECT_EQ(all_units(scene.soil()), units);
}

// As long as a step has room for all of its passes, and bodies do not cross more voxels in it than
// in one that is in time.
TEST_P(Budget, makes_whole_steps) {
    SoilDef def = def_with(30);
    const auto fill = [](Soil& soil) {
        EXPECT_TRUE(soil.fill(voxel_box(soil, {0, 0, 0}, {40, 32, 8}, "dry_sand")));
        EXPECT_TRUE(soil.fill(voxel_box(soil, {20, 16, 12}, {26, 22, 20}, "gravel")));
    };
    const auto spread = make_soil(def);
    def.step_budget_ms = 0;
    const auto plain = make_soil(def);
    fill(*spread);
    fill(*plain);
    count_dispatches(*spread);
    const std::vector<ConvexShape> blade{box_shape(Vec3{2, 6, 4} * 0.05)};
    int64_t begun = 0;
    for (int i = 0; i < 40; ++i) {
        // Both the body and its shapes are gone when the step goes on.
        const auto shapes = std::make_unique<std::vector<ConvexShape>>(blade);
        std::vector<SoilBody> bodies(1);
        bodies[0].id = 5;
        bodies[0].shapes = shapes.get();
        bodies[0].pose.position = Vec3{8 + 0.5 * static_cast<double>(begun), 16, 7} * 0.05;
        bodies[0].center_of_mass_m = bodies[0].pose.position;
        spread->step(bodies);
        if (spread->step_rate().begun_count > begun) plain->step(bodies);
        begun = spread->step_rate().begun_count;
    }
    EXPECT_LT(begun, 30);
    EXPECT_GT(begun, 5);
    EXPECT_EQ(spread->checksum(), plain->checksum());
    EXPECT_EQ(spread->totals().units, plain->totals().units);
}

// The faster bodies are, the more sub-steps has a step that comes late; it has no more than fit.
TEST_P(Budget, bounds_what_a_late_step_does) {
    constexpr int kBudget = 20, kSpread = 4;
    SoilDef def = grid_def(64, 32, 24);
    def.backend = GetParam();
    def.step_budget_ms = kBudget;
    def.step_spread_max = kSpread;
    const auto soil = make_soil(def);
    count_dispatches(*soil);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {64, 32, 10})));
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{2, 8, 4} * 0.05), Vec3{10, 16, 9} * 0.05);
    movers[0].set_velocity({2.4, 0, 0});  // 0.8 voxels a call
    const int64_t units = all_units(*soil);
    int64_t most = 0;
    int substeps = 0;
    for (int i = 0; i < 50; ++i) {
        const int64_t before = counters_of(*soil).dispatch_count;
        const StepReport report = soil->step(bodies_of(movers));
        movers[0].advance(1.0 / 60);
        if (i < 8) continue;
        most = std::max(most, counters_of(*soil).dispatch_count - before);
        substeps = std::max(substeps, report.substep_count);
    }
    // A step of one sub-step and the least slip passes has 40 dispatches.
    EXPECT_LE(most, 2 * kBudget);
    EXPECT_LE(substeps, 2);
    EXPECT_LE(soil->step_rate().call_count_most, kSpread);
    EXPECT_EQ(all_units(*soil), units);
}

TEST_P(Budget, soil_is_conserved_between_any_two_pieces) {
    MovingScene scene(5, def_with(1));
    count_dispatches(scene.soil());
    while (!scene.step().has_finished) {
    }
    const double before_kg = mass_kg(scene.soil());  // with soil buried under the post
    int unfinished = 0;
    for (int i = 0; i < 80; ++i) {
        unfinished += !scene.step().has_finished;
        ASSERT_EQ(mass_kg(scene.soil()), before_kg) << i;
    }
    EXPECT_GT(unfinished, 60);
    EXPECT_TRUE(scene.soil().is_stepping());
}

TEST_P(Budget, finishes_a_step_that_is_spread_too_far) {
    constexpr int kSpread = 4;
    MovingScene scene(4, def_with(1, kSpread));
    count_dispatches(scene.soil());
    EXPECT_TRUE(scene.step().has_finished) << "the first one always";
    for (int i = 0; i < 24; ++i) {
        const StepReport report = scene.step();
        EXPECT_EQ(report.has_finished, i % kSpread == kSpread - 1) << i;
        EXPECT_EQ(report.call_count, i < kSpread - 1 ? 1 : kSpread) << i;
    }
    const StepRate rate = scene.soil().step_rate();
    EXPECT_EQ(rate.held_count, 6);
    EXPECT_EQ(rate.begun_count, 7);
    EXPECT_EQ(rate.call_count_most, kSpread);
    EXPECT_NE(scene.soil().status_bits() & static_cast<uint32_t>(StatusBit::budget_exceeded), 0u);
    const auto conditions = scene.soil().conditions();
    const auto lowered = std::ranges::find(conditions, StatusBit::rate_lowered, &Condition::bit);
    ASSERT_NE(lowered, conditions.end());
    EXPECT_EQ(lowered->step_count, 6);
}

// What rests costs little, and the rate comes back by itself.
TEST_P(Budget, costs_nothing_that_fits) {
    SoilDef def = grid_def(32, 32, 16);
    def.backend = GetParam();
    def.step_budget_ms = 20;
    const auto soil = make_soil(def);
    count_dispatches(*soil);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {32, 32, 6})));
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {12, 12, 6}, {20, 20, 14})));
    for (int i = 0; i < 20; ++i) soil->step({});
    EXPECT_LT(soil->step_rate().share(), 0.9);
    for (int i = 0; i < 1000 && soil->step({}).block_active_count > 0; ++i) {
    }
    const StepRate before = soil->step_rate();
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(soil->step({}).has_finished);
    const StepRate after = soil->step_rate();
    EXPECT_EQ(after.begun_count - before.begun_count, 50);
}

TEST_P(Budget, who_asks_for_the_whole_soil_or_changes_it_finds_a_whole_step) {
    MovingScene scene(4, def_with(6));
    Soil& soil = scene.soil();
    count_dispatches(soil);
    const int64_t units = all_units(soil);
    const auto in_between = [&] {
        while (!soil.is_stepping()) scene.step();
    };
    in_between();
    const uint64_t checksum = soil.checksum();
    EXPECT_FALSE(soil.is_stepping());
    EXPECT_EQ(soil.checksum(), checksum);
    const StepReport told = scene.step();
    EXPECT_TRUE(told.has_finished) << "the step that was finished in between";
    in_between();
    const std::vector<uint8_t> state = soil.state();
    EXPECT_FALSE(soil.is_stepping());

    // The state may be put back while a step is in progress; what a soil without a budget makes of
    // it is another soil's matter.
    in_between();
    auto put = soil.prepare(state);
    ASSERT_TRUE(put) << put.error();
    (*put)();
    EXPECT_FALSE(soil.is_stepping());
    EXPECT_EQ(soil.state(), state);
    const auto other = make_soil(def_with(0));
    auto into_other = other->prepare(state);
    ASSERT_TRUE(into_other) << into_other.error();
    (*into_other)();
    EXPECT_EQ(other->checksum(), soil.checksum());

    in_between();
    const auto taken = soil.take_out(box_shape(Vec3{6, 6, 6} * 0.05), {Vec3{20, 16, 8} * 0.05, {}});
    ASSERT_TRUE(taken);
    EXPECT_FALSE(soil.is_stepping());
    in_between();
    EXPECT_TRUE(soil.fill(voxel_box(soil, {2, 2, 18}, {6, 6, 22}, "gravel")));
    EXPECT_FALSE(soil.is_stepping());
    const int64_t filled = all_units(soil);
    EXPECT_NE(filled, units);
    in_between();
    SourceDef source;
    source.center_m = Vec3{10, 10, 20} * 0.05;
    source.radius_m = 0.1;
    source.rate_kg_s = 20;
    source.material = "gravel";
    const auto id = soil.add_source(source);
    ASSERT_TRUE(id);
    EXPECT_FALSE(soil.is_stepping());
    for (int i = 0; i < 100; ++i) scene.step();
    const SoilTotals totals = soil.totals();
    EXPECT_GT(totals.units_in[2], 0);
    EXPECT_EQ(all_units(soil),
              filled + std::accumulate(totals.units_in.begin(), totals.units_in.end(), int64_t{0}));
    in_between();
    EXPECT_TRUE(soil.settle(3));
    EXPECT_FALSE(soil.is_stepping());
}

TEST_P(Budget, may_change_while_the_soil_runs) {
    MovingScene scene(4, def_with(0));
    Soil& soil = scene.soil();
    count_dispatches(soil);
    scene.run(5);
    SoilDef def = soil.def();
    def.step_budget_ms = 5;
    def.step_spread_max = 7;
    const uint64_t before = soil.checksum();
    ASSERT_TRUE(soil.change(def));
    EXPECT_EQ(soil.checksum(), before);
    EXPECT_FALSE(scene.step().has_finished);
    def.step_budget_ms = 0;
    ASSERT_TRUE(soil.change(def));
    EXPECT_FALSE(soil.is_stepping());
    for (int i = 0; i < 5; ++i) EXPECT_TRUE(scene.step().has_finished);
    def.step_budget_ms = -1;
    const Status refused = soil.change(def);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().find("step_budget_ms"), std::string::npos);
}

// What a call does is decided outside of the devices; BudgetOnGl has what is OpenGL's own.
INSTANTIATE_TEST_SUITE_P(Cpu, Budget, testing::Values(Backend::cpu));
INSTANTIATE_TEST_SUITE_P(SlowGl, Budget, testing::Values(Backend::gl));

// Without a budget a step waits for the GPU once; with one it asks whether the GPU is through.
TEST(BudgetOnGl, never_waits_for_the_gpu) {
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    SoilDef def = MovingScene::default_def();
    def.backend = Backend::gl;
    MovingScene plain(4, def);
    plain.run(20);
    int64_t before = counters_of(plain.soil()).wait_count;
    plain.run(10);
    EXPECT_EQ(counters_of(plain.soil()).wait_count - before, 10);

    // A blade goes on when a step begins. Its tiles stay awake, and it has no more contacts than
    // expected: what else takes a second read.
    def = grid_def(32, 32, 16);
    def.backend = Backend::gl;
    def.step_budget_ms = 10;
    def.step_spread_max = 1000;
    const auto soil = make_soil(def);
    count_dispatches(*soil);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {32, 32, 6})));
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{1, 6, 3} * 0.05), Vec3{12, 16, 6} * 0.05);
    movers[0].set_velocity({0.3, 0, 0});
    const auto finish_steps = [&](int count) {
        for (int i = 0, finished = 0; i < 1000 && finished < count; ++i) {
            const int64_t begun = soil->step_rate().begun_count;
            finished += soil->step(bodies_of(movers)).has_finished;
            if (soil->step_rate().begun_count > begun) movers[0].advance(1.0 / 60);
        }
    };
    finish_steps(10);
    before = counters_of(*soil).wait_count;
    const int64_t reads = counters_of(*soil).read_count;
    const int64_t finished = soil->step_rate().begun_count;
    finish_steps(10);
    EXPECT_GE(soil->step_rate().begun_count - finished, 9);
    EXPECT_EQ(counters_of(*soil).wait_count - before, 0);
    EXPECT_LE(counters_of(*soil).read_count - reads, 11);
    EXPECT_LT(soil->step_rate().share(), 0.6);
}

}  // namespace
}  // namespace bsoil::budget_test
