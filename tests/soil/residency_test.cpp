// Tiles asleep and awake hold the same soil.
#include <array>

#include "moving_scene.h"

namespace bsoil::residency_test {
namespace {

void sleep_all(Soil& soil) {
    Soil::Impl& impl = SoilProbe::impl(soil);
    for (size_t index = 0; index < impl.tiles.size(); ++index) {
        if (impl.tiles[index] && impl.tiles[index]->slot >= 0) {
            impl.tiles.put_to_sleep(std::array{static_cast<int>(index)});
        }
    }
}

void wake_all(Soil& soil) {
    Soil::Impl& impl = SoilProbe::impl(soil);
    for (size_t index = 0; index < impl.tiles.size(); ++index) {
        impl.tiles.wake(static_cast<int>(index));
    }
}

TEST(Residency, sleeping_and_waking_change_no_bit) {
    MovingScene scene(11, MovingScene::default_def());
    for (int i = 0; i < 5; ++i) {
        scene.run(13);
        const uint64_t checksum = scene.soil().checksum();
        sleep_all(scene.soil());
        EXPECT_EQ(scene.soil().memory_use().awake_voxels, 0);
        EXPECT_EQ(scene.soil().checksum(), checksum);
        wake_all(scene.soil());
        EXPECT_EQ(scene.soil().memory_use().asleep_columns, 0);
        EXPECT_EQ(scene.soil().checksum(), checksum);
    }
}

// In one go, on several threads: 22 of 36 tiles have a slot, three of them before.
TEST(Residency, tiles_that_wake_together_wake_as_one_by_one) {
    const auto awake = [](bool together) {
        SoilDef def = grid_def(48, 48, 40);
        def.tile_capacity = 22;
        def.thread_count = 3;
        auto soil = make_soil(def);
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 48, 5})));
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {20, 20, 5}, {30, 30, 35})));
        Soil::Impl& impl = SoilProbe::impl(*soil);
        for (const int index : {7, 30, 8}) impl.tiles.wake(index);
        std::vector<int> indices;
        for (int i = 0; i < 72; ++i) indices.push_back(i * 5 % 36);
        if (together) impl.tiles.wake_ahead(indices);
        std::vector<int> slots;
        for (const int index : indices) {
            slots.push_back(together ? impl.tiles[static_cast<size_t>(index)]->slot
                                     : impl.tiles.wake(index));
        }
        EXPECT_EQ(impl.tiles.awake_count(), 22);
        return std::pair(slots, soil->checksum());
    };
    EXPECT_EQ(awake(true), awake(false));
}

// A blade cuts into a heap, leaves it alone for long enough that its tiles fall asleep, and comes
// back.
TEST(Residency, soil_that_sleeps_in_between_moves_like_soil_that_stays_awake) {
    const auto run = [](bool keep_awake) {
        auto soil = make_soil(grid_def(72, 24, 16));
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {72, 24, 5})));
        std::vector<Mover> movers;
        movers.emplace_back(1, box_shape(Vec3{1.2, 4.5, 3} * 0.05), Vec3{8, 12, 6} * 0.05);
        std::vector<uint64_t> checksums;
        int awake_least = 1000;
        for (int s = 0; s < 260; ++s) {
            const bool rests = s >= 60 && s < 180;
            movers[0].set_velocity({rests ? 0.0 : (s < 60 ? 1.2 : -1.2), 0, 0});
            movers[0].advance(1.0 / 60);
            if (keep_awake) wake_all(*soil);
            const StepReport report = soil->step(bodies_of(movers));
            awake_least = std::min(awake_least, report.tile_awake_count);
            if (s % 20 == 0) checksums.push_back(soil->checksum());
        }
        EXPECT_EQ(awake_least == 27, keep_awake);
        return checksums;
    };
    EXPECT_EQ(run(true), run(false));
}

TEST(Residency, a_full_tile_table_is_reported_and_loses_nothing) {
    SoilDef def = grid_def(48, 48, 16);
    def.tile_capacity = 2;
    auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 48, 5})));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {20, 20, 5}, {30, 30, 12})));
    const std::vector<int64_t> units = soil->totals().units;
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{2, 6, 3} * 0.05), Vec3{6, 24, 6} * 0.05);
    movers[0].set_velocity({1, 0, 0});
    for (int s = 0; s < 120; ++s) {
        movers[0].advance(1.0 / 60);
        const StepReport report = soil->step(bodies_of(movers));
        EXPECT_LE(report.tile_awake_count, 2);
        ASSERT_EQ(soil->totals().units, units) << "step " << s;
    }
    EXPECT_TRUE(soil->status_bits() & static_cast<uint32_t>(StatusBit::tile_table_full));
}

// Of a tile that stays at hand from step to step, some planes are read at one time and some at
// another, and what comes to rest need not make a new revision of it.
TEST(Residency, samples_are_of_now_whatever_was_asked_before) {
    SoilDef def = grid_def(8, 8, 40);
    def.slides = SlideMotion::run_out;
    auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {8, 8, 3})));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {2, 2, 20}, {6, 6, 24})));
    std::vector<float> volume, solid;
    std::vector<uint8_t> material;
    int moving_count = 0, later_count = 0;
    uint64_t revision = 0;
    for (int step = 0; step < 150; ++step) {
        soil->step({});
        later_count += soil->tile_revision(0, 0) == revision;
        revision = soil->tile_revision(0, 0);
        if (step % 3 == 0) soil->read_tile(0, 0, volume, solid, material);
        std::vector<VoxelSample> at_hand;
        for (int v = 0; v < 8 * 8 * 40; ++v) {
            const int x = v % 8, y = v / 8 % 8, z = v / 64;
            at_hand.push_back(soil->sample_matter(x, y, z));
            at_hand.back().velocity_m_s = soil->velocity_m_s(x, y, z);
            if (step % 2 == 0) at_hand.back().push = soil->sample(x, y, z).push;
        }
        SoilProbe::impl(*soil).sampler.forget();
        for (int v = 0; v < 8 * 8 * 40; ++v) {
            const VoxelSample now = soil->sample(v % 8, v / 8 % 8, v / 64);
            const VoxelSample& then = at_hand[static_cast<size_t>(v)];
            moving_count += now.velocity_m_s != Vec3{};
            ASSERT_EQ(then.velocity_m_s, now.velocity_m_s) << step;
            ASSERT_EQ(then.undisturbed, now.undisturbed) << step;
            ASSERT_EQ(then.density_kg_m3, now.density_kg_m3) << step;
            if (step % 2 == 0) {
                ASSERT_EQ(then.push, now.push) << step;
            }
        }
        if (step % 4 != 0) soil->sample_matter(0, 0, 0);
        if (step % 4 == 1) soil->sample(0, 0, 0);
    }
    EXPECT_GT(moving_count, 100);
    EXPECT_GT(later_count, 10);  // steps without a revision
}

// The table starts with 64 slots and may have 100 of the 108 that a snapshot needs.
TEST(Residency, a_snapshot_with_more_tiles_awake_than_there_may_be_is_refused) {
    SoilDef def = grid_def(96, 72, 8);
    auto saved = make_soil(def);
    ASSERT_TRUE(saved->fill(voxel_box(*saved, {0, 0, 0}, {96, 72, 5})));
    wake_all(*saved);
    const std::string path = testing::TempDir() + "more_tiles_awake";
    ASSERT_TRUE(saved->save(path));
    def.tile_capacity = 100;
    auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {96, 72, 2})));
    const uint64_t checksum = soil->checksum();
    const Status loaded = soil->load(path);
    ASSERT_FALSE(loaded);
    EXPECT_NE(loaded.error().find("108 awake tiles"), std::string::npos) << loaded.error();
    EXPECT_EQ(soil->checksum(), checksum);
    def.tile_capacity = 108;
    auto larger = make_soil(def);
    ASSERT_TRUE(larger->load(path));
    EXPECT_EQ(larger->checksum(), saved->checksum());
}

// Soil arrives high above the ground of a tile that held none so high.
TEST(Residency, soil_comes_to_rest_on_a_plateau_of_bare_rock) {
    auto soil = make_soil(grid_def(32, 16, 40));
    const double voxel = 0.05;
    ASSERT_TRUE(soil->add_terrain([&](Vec3 at) { return at.z < 24 * voxel ? 1.0 : -1.0; }));
    ASSERT_TRUE(
        soil->fill(voxel_box(*soil, {0, 0, 24}, {8, 16, 34})));  // a cliff on the edge of a tile
    StepReport report;
    for (int i = 0; i < 1000; ++i) report = soil->step({});
    EXPECT_EQ(report.block_active_count, 0);
    // 33 deg from a heap of 10 by 8 voxels reaches about 15 voxels far.
    EXPECT_GT(soil->surface_height_m(12, 8), 25 * voxel);
    EXPECT_LT(soil->surface_height_m(4, 8), 32 * voxel);
}

/// Mass above a height [kg].
double mass_above_kg(const Soil& soil, double height_m) {
    const Vec3 size = soil.def().size_m;
    const double half = (size.z - height_m) / 2;
    return soil.mass_inside_kg(box_shape({size.x / 2, size.y / 2, half}),
                               {{size.x / 2, size.y / 2, size.z - half}, {}});
}

class CarriedLoad : public testing::TestWithParam<bool> {};

TEST_P(CarriedLoad, stays_in_a_bucket_high_above_the_ground) {
    const bool ground_is_active = GetParam();
    auto soil = make_soil(grid_def(64, 16, 40));
    const double voxel = 0.05, step = 1.0 / 60;
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {64, 16, 2})));
    const auto wall = [&](Vec3 half, Vec3 at) {
        ConvexShape shape = box_shape(half * voxel);
        shape.local.position = at * voxel;
        return shape;
    };
    std::vector<Mover> movers;
    movers.emplace_back(1, wall({6, 6, 1}, {0, 0, -4}), Vec3{10, 8, 32} * voxel);
    for (const ConvexShape& side : {wall({1, 6, 5}, {-6, 0, 0}), wall({1, 6, 5}, {6, 0, 0}),
                                    wall({6, 1, 5}, {0, -6, 0}), wall({6, 1, 5}, {0, 6, 0})}) {
        movers[0].shapes.push_back(side);
    }
    if (ground_is_active) {
        movers.emplace_back(2, box_shape(Vec3{1, 5, 2} * voxel),
                            Vec3{10, 8, 2} * voxel);  // ploughs below the bucket
    }
    soil->step(bodies_of(movers));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {6, 4, 29.5}, {14, 12, 33})));
    const double loaded_kg = mass_above_kg(*soil, 20 * voxel);
    EXPECT_GT(loaded_kg, 10);
    StepReport report;
    for (int i = -30; i < 160; ++i) {
        for (Mover& mover : movers) {
            mover.set_velocity({std::clamp(0.02 * i, 0.0, 0.9), 0,
                                0});  // within what friction with the floor can do
            mover.advance(step);
        }
        report = soil->step(bodies_of(movers));
    }
    EXPECT_GT(movers[0].body.pose.position.x, 40 * voxel);
    EXPECT_GT(mass_above_kg(*soil, 20 * voxel), 0.98 * loaded_kg);
    // A little of it stands in the bucket's walls at any time and counts for none.
    ASSERT_GE(report.loads.size(), 1u);
    EXPECT_EQ(report.loads[0].body, 1);
    EXPECT_NEAR(report.loads[0].mass_kg, loaded_kg, 0.1 * loaded_kg);
}

INSTANTIATE_TEST_SUITE_P(Ground, CarriedLoad, testing::Bool(), [](const auto& parameter) {
    return parameter.param ? "active" : "asleep";
});

// More tiles wake in the first step than the table has slots at its start.
TEST(Residency, all_soil_that_hangs_falls_in_the_first_step) {
    auto soil = make_soil(grid_def(96, 96, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 6}, {96, 96, 10})));
    EXPECT_EQ(soil->step({}).tile_awake_count, 144);
    for (int tile = 0; tile < 144; ++tile) {
        EXPECT_GT(soil->sample(tile % 12 * 8 + 4, tile / 12 * 8 + 4, 5).volume, 0) << tile;
    }
}

TEST(Residency, the_tile_table_grows_without_changing_a_bit) {
    // 9 x 9 tiles: more than the table starts with. One soil grows while it moves, the other wakes
    // everything before.
    const auto run = [](bool grow_first) {
        auto soil = make_soil(grid_def(72, 72, 8));
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {72, 72, 2.5})));
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {30, 30, 2.5}, {40, 40, 7})));
        if (grow_first) wake_all(*soil);
        for (int s = 0; s < 30; ++s) soil->step({});
        wake_all(*soil);
        for (int s = 0; s < 10; ++s) soil->step({});
        return soil->checksum();
    };
    EXPECT_EQ(run(true), run(false));
}

// A step in which the table doubles takes no look at what was awake before, and reads none of it.
TEST(Residency, tiles_stay_on_the_device_while_the_table_grows) {
    const auto soil = make_soil(grid_def(128, 128, 8));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {128, 128, 2.5})));
    Soil::Impl& impl = SoilProbe::impl(*soil);
    for (int tile = 0; tile < 64; ++tile) impl.tiles.wake(tile);
    ASSERT_EQ(impl.tiles.slot_count(), 64);
    soil->step({});
    const int64_t read_before = impl.device->counters().read_bytes;
    impl.tiles.wake(64);
    EXPECT_EQ(impl.tiles.slot_count(), 128);
    EXPECT_EQ(impl.device->counters().read_bytes, read_before);
    const auto lanes = [&impl] {
        int64_t sum = 0;
        for (const int64_t count : impl.device->counters().lane_counts) sum += count;
        return sum;
    };
    const int64_t lanes_before = lanes();
    soil->step({});
    // Nine kernels look at the columns of the tile that woke, some of them in each of its blocks.
    EXPECT_LE(lanes() - lanes_before, 64 * 64);
}

}  // namespace
}  // namespace bsoil::residency_test
