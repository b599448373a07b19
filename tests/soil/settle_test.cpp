// Settling: what the first step would have to look at is looked at before, and soil that may not
// stand comes to rest.
#include "moving_scene.h"

namespace bsoil::settle_test {
namespace {

constexpr double kVoxel = 0.05;

TEST(Settle, level_ground_is_at_rest_without_a_step) {
    auto soil = make_soil(grid_def(400, 400, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {400, 400, 6})));
    const auto report = soil->settle();
    ASSERT_TRUE(report) << report.error();
    EXPECT_TRUE(report->is_at_rest);
    EXPECT_EQ(report->step_count, 0);
    EXPECT_EQ(report->block_active_count, 0);
    EXPECT_EQ(soil->step({}).tile_awake_count, 0);
}

TEST(Settle, without_steps_it_does_the_first_steps_looking_alone) {
    const auto steep = [] {
        auto soil = make_soil(grid_def(48, 48, 24));
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {16, 16, 0}, {32, 32, 20})));
        return soil;
    };
    const auto settled = steep(), other = steep();
    const auto report = settled->settle(0);
    ASSERT_TRUE(report);
    EXPECT_FALSE(report->is_at_rest);
    EXPECT_GT(report->block_active_count, 0);
    EXPECT_EQ(settled->checksum(), other->checksum());
    for (int i = 0; i < 50; ++i) {
        const StepReport a = settled->step({}), b = other->step({});
        ASSERT_EQ(a.block_active_count, b.block_active_count) << i;
        ASSERT_EQ(settled->checksum(), other->checksum()) << i;
    }
}

TEST(Settle, a_pile_comes_to_rest_and_keeps_its_soil) {
    auto soil = make_soil(grid_def(48, 48, 24));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {16, 16, 2}, {32, 32, 18})));
    const std::vector<int64_t> units = soil->totals().units;
    const auto few = soil->settle(5);
    ASSERT_TRUE(few);
    EXPECT_FALSE(few->is_at_rest);
    EXPECT_EQ(few->step_count, 5);
    EXPECT_GT(few->tile_awake_count, 0);
    const auto all = soil->settle(5000);
    ASSERT_TRUE(all);
    EXPECT_TRUE(all->is_at_rest);
    EXPECT_LT(all->step_count, 5000);
    EXPECT_EQ(all->tile_awake_count, 0);
    EXPECT_EQ(soil->totals().units, units);
    const uint64_t checksum = soil->checksum();
    EXPECT_EQ(soil->settle(100)->step_count, 0);
    EXPECT_EQ(soil->step({}).block_active_count, 0);
    EXPECT_EQ(soil->checksum(), checksum);
}

TEST(Settle, bodies_stand_still_and_hold_soil_back) {
    // A wall of boxes around a heap: it stays within, though the bodies are said to move.
    auto soil = make_soil(grid_def(40, 40, 24));
    std::vector<Mover> movers;
    for (const auto& [half, at] : {std::pair{Vec3{1.5, 10, 10}, Vec3{8, 20, 10}},
                                   {Vec3{1.5, 10, 10}, Vec3{32, 20, 10}},
                                   {Vec3{13.5, 1.5, 10}, Vec3{20, 8.5, 10}},
                                   {Vec3{13.5, 1.5, 10}, Vec3{20, 31.5, 10}}}) {
        movers.emplace_back(static_cast<int>(movers.size()), box_shape(half * kVoxel), at * kVoxel);
        movers.back().set_velocity({1, 0, 0});
    }
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {12, 12, 0}, {28, 28, 14})));
    const std::vector<int64_t> units = soil->totals().units;
    const auto report = soil->settle(3000, bodies_of(movers));
    ASSERT_TRUE(report);
    EXPECT_TRUE(report->is_at_rest);
    EXPECT_GT(report->step_count, 0);
    EXPECT_EQ(soil->totals().units, units);
    for (int i = 0; i < 40; ++i) {
        EXPECT_EQ(soil->surface_height_m(i, 2), 0) << i;
        EXPECT_EQ(soil->surface_height_m(2, i), 0) << i;
    }
}

TEST(Settle, gives_the_same_bits_on_two_threads_and_on_gl) {
    const auto settled = [](Backend backend, int threads) {
        SoilDef def = grid_def(33, 29, 24);
        def.backend = backend;
        def.thread_count = threads;
        auto soil = make_soil(def);
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {7, 8, 1}, {23, 19, 15})));
        EXPECT_TRUE(soil->settle(60));
        return soil->checksum();
    };
    const uint64_t once = settled(Backend::cpu, 1);
    EXPECT_EQ(settled(Backend::cpu, 2), once);
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    EXPECT_EQ(settled(Backend::gl, 0), once);
}

// More tiles than threads take at a time, each other than all others, and more ground than is
// remembered.
TEST(Settle, hills_over_uneven_ground_are_the_same_on_any_number_of_threads) {
    std::vector<uint64_t> checksums;
    for (const int threads : {1, 3}) {
        SoilDef def = grid_def(320, 320, 24);
        def.backend = Backend::cpu;
        def.thread_count = threads;
        const auto soil = make_soil(def);
        NoiseFill hills;
        hills.base_m = 0.6;
        hills.amplitude_m = 0.2;
        hills.wavelength_m = 2;
        ASSERT_TRUE(soil->fill(hills));
        const std::vector<int64_t> units = soil->totals().units;
        const uint64_t without_floor = soil->checksum();
        Mover floor(1, box_shape({9, 9, 1}), {0, 0, -0.7}, true);
        floor.body.pose.rotation = turn({0, 1, 0}, 0.02);
        const auto report = soil->settle(2, std::array{floor.body});
        ASSERT_TRUE(report) << report.error();
        EXPECT_GT(report->block_active_count, 0);
        EXPECT_NE(soil->checksum(), without_floor);
        EXPECT_EQ(soil->totals().units, units);
        checksums.push_back(soil->checksum());
    }
    EXPECT_EQ(checksums[0], checksums[1]);
}

TEST(Settle, refuses_steps_out_of_range) {
    auto soil = make_soil(grid_def(16, 16, 16));
    for (int steps : {-1, limits::kSettleStepsMax + 1}) {
        const auto report = soil->settle(steps);
        ASSERT_FALSE(report);
        EXPECT_NE(report.error().find("steps_max"), std::string::npos) << report.error();
    }
}

// Random world 91022. Dust of one unit on a ledge that cohesion holds cannot be shared out among
// the columns below. It asked for their blocks in turn, each of which kept the ledge's block
// dispatched.
TEST(Settle, dust_on_a_ledge_wakes_nothing) {
    SoilDef def = grid_def(8, 24, 16);
    def.material = sand(26, 5000);
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {8, 24, 2})));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 8, 2}, {8, 16, 3})));
    ASSERT_TRUE(soil->settle(100, {})->is_at_rest);
    Soil::Impl& s = SoilProbe::impl(*soil);
    const int slot = s.tiles.wake(1);
    for (const int plane : {layout::kPlaneVolume, layout::kPlaneMaterial}) {
        for (const int y : {0, 7}) {
            const int voxel = 3 * layout::kTileColumns + y * layout::kTileSide + 2;
            s.device->write(layout::Buffer::state,
                            int64_t{plane} * s.params.plane_stride +
                                int64_t{slot} * s.params.tile_voxels + voxel,
                            std::vector<int32_t>(4, 1));
        }
    }
    s.tiles.note_stale(slot, true);
    for (const int side : {0, 2}) {
        s.lists.activate(s.block_key(side, 0));
        soil->step({});
        soil->step({});
    }
    for (int i = 0; i < 20; ++i) soil->step({});
    EXPECT_GT(soil->sample(3, 8, 3).volume, 0);
    EXPECT_EQ(soil->step({}).block_active_count, 0);
}

}  // namespace
}  // namespace bsoil::settle_test
