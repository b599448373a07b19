// What a step asks of the device: waits, dispatches, bytes.
#include <algorithm>
#include <cstdio>

#include "bsoil/surface_mesh.h"
#include "moving_scene.h"
#include "temporary_file.h"

namespace bsoil::device_use_test {
namespace {

const device::DeviceCounters& counters_of(Soil& soil) {
    return SoilProbe::impl(soil).device->counters();
}

class DeviceUse : public testing::TestWithParam<Backend> {
  protected:
    void SetUp() override {
        if (GetParam() == Backend::gl && !gl_missing().empty()) {
            GTEST_SKIP() << gl_missing();
        }
    }
};

TEST_P(DeviceUse, a_warm_step_waits_for_the_device_once) {
    SoilDef def = MovingScene::default_def();
    def.backend = GetParam();
    MovingScene scene(4, def);
    scene.run(10);
    // A second read is for contacts beyond those of the step before and a quarter more, for tiles
    // that fall asleep and for soil carried in a new tile. Bodies here move slowly, and tiles stay
    // awake.
    int contact_count = 0;
    for (int i = 0; i < 10; ++i) {
        const device::DeviceCounters before = counters_of(scene.soil());
        const StepReport report = scene.step();
        contact_count += static_cast<int>(report.contacts.size());
        const device::DeviceCounters& after = counters_of(scene.soil());
        EXPECT_EQ(after.read_count - before.read_count, 1) << i;
        EXPECT_EQ(after.context_count - before.context_count, GetParam() == Backend::gl ? 1 : 0);
        EXPECT_GT(after.dispatch_count, before.dispatch_count);
    }
    EXPECT_GT(contact_count, 1000);
}

TEST_P(DeviceUse, a_surface_that_has_not_changed_is_read_once) {
    SoilDef def = MovingScene::default_def();
    def.backend = GetParam();
    MovingScene scene(4, def);
    scene.run(5);
    Soil& soil = scene.soil();
    // Over the line and back, so that no tile is the one that was asked for last.
    const auto reads_of_line = [&soil](std::vector<double>& heights_m) {
        const int64_t before = counters_of(soil).read_count;
        heights_m.clear();
        const int size = soil.frame().size[0];
        for (int i = 0; i < 2 * size; ++i) {
            heights_m.push_back(soil.surface_height_m(i < size ? i : 2 * size - 1 - i, 20));
        }
        return counters_of(soil).read_count - before;
    };
    std::vector<double> first, again, later;
    const int64_t tile_count = (soil.frame().size[0] + 7) / 8;
    EXPECT_GT(reads_of_line(first), 0);
    EXPECT_EQ(reads_of_line(again), 0);
    EXPECT_EQ(first, again);
    scene.run(15);
    EXPECT_LE(reads_of_line(later), 2 * tile_count);  // of roofs more planes, besides
    EXPECT_NE(first, later);                          // what has moved since is seen
}

/// All that a mesher shows of its soil.
std::vector<float> shown_by(const SurfaceMesher& mesher) {
    Mesh mesh;
    mesher.gather(mesh);
    std::vector<float> out = mesh.positions;
    out.insert(out.end(), mesh.colors.begin(), mesh.colors.end());
    const auto add = [&out](Vec3 v) {
        for (const double x : {v.x, v.y, v.z}) out.push_back(static_cast<float>(x));
    };
    for (int ty = 0; ty < mesher.tile_count_y(); ++ty) {
        for (int tx = 0; tx < mesher.tile_count_x(); ++tx) {
            for (const LooseVoxel& loose : mesher.loose_soil(tx, ty)) add(loose.velocity_m_s);
            for (const RollingSoil& rolling : mesher.rolling_soil(tx, ty)) {
                add(rolling.velocity_m_s);
                out.push_back(rolling.amount);
            }
        }
    }
    return out;
}

TEST_P(DeviceUse, a_mesh_reads_many_tiles_at_once) {
    SoilDef def = MovingScene::default_def();
    def.backend = GetParam();
    MovingScene scene(4, def);
    def.backend = Backend::cpu;
    MovingScene same(4, def);
    const SoilTiles tiles(scene.soil()), same_tiles(same.soil());
    SurfaceMesher mesher(tiles, {.backend = Backend::cpu});
    SurfaceMesher same_mesher(same_tiles, {.backend = Backend::cpu});
    for (int picture = 0; picture < 3; ++picture) {
        scene.run(7);
        same.run(7);
        const device::DeviceCounters before = counters_of(scene.soil());
        const SurfaceMeshReport report = mesher.update();
        const device::DeviceCounters after = counters_of(scene.soil());
        same_mesher.update();
        EXPECT_GT(report.tile_read_count, 8);
        EXPECT_EQ(shown_by(mesher), shown_by(same_mesher));
        if (GetParam() == Backend::cpu) continue;
        EXPECT_EQ(after.wait_count - before.wait_count, 1) << report.tile_read_count << " tiles";
        // A plane of neighbouring slots is one copy: not one for each tile and plane.
        const Soil::Impl& impl = SoilProbe::impl(scene.soil());
        const int tile_count = std::min(report.tile_read_count, impl.tiles.awake_count());
        EXPECT_LT(after.read_copy_count - before.read_copy_count,
                  tile_count * (impl.kept_planes + 3) / 2);
    }
}

TEST_P(DeviceUse, a_step_in_which_a_body_lands_reads_all_of_its_contacts) {
    SoilDef def = grid_def(48, 48, 24);
    def.backend = GetParam();
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 48, 8})));
    std::vector<Mover> movers;
    // Not a contact, then those of a plate of 40 x 40 voxels at once.
    movers.emplace_back(1, box_shape(Vec3{20, 20, 2} * 0.05), Vec3{24, 24, 18} * 0.05);
    soil->step(bodies_of(movers));
    movers[0].body.pose.position.z = 9.5 * 0.05;
    const device::DeviceCounters before = counters_of(*soil);
    const size_t landed = soil->step(bodies_of(movers)).contacts.size();
    EXPECT_EQ(counters_of(*soil).read_count - before.read_count, 2);
    const size_t resting = soil->step(bodies_of(movers)).contacts.size();
    EXPECT_GT(landed, 1600u);
    EXPECT_GT(resting, 1600u);
}

TEST_P(DeviceUse, tiles_that_wake_are_written_together) {
    if (GetParam() == Backend::cpu) GTEST_SKIP() << "memory of its own";
    SoilDef def = grid_def(48, 48, 16);
    def.backend = GetParam();
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 48, 8})));
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{40, 40, 2} * 0.05), Vec3{24, 24, 8.5} * 0.05);
    const device::DeviceCounters before = counters_of(*soil);
    soil->step(bodies_of(movers));
    const device::DeviceCounters after = counters_of(*soil);
    EXPECT_EQ(SoilProbe::impl(*soil).tiles.awake_count(), 36);
    EXPECT_GT(after.write_count + after.fill_count - before.write_count - before.fill_count, 900);
    EXPECT_LT(after.write_call_count - before.write_call_count, 150);
}

TEST_P(DeviceUse, air_is_not_written_when_a_tile_wakes) {
    SoilDef def = grid_def(16, 16, 256);
    def.backend = GetParam();
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {16, 16, 8})));
    Soil::Impl& impl = SoilProbe::impl(*soil);
    const int64_t tile_bytes = int64_t{4} * impl.params.tile_voxels * impl.kept_planes;
    const device::DeviceCounters before = counters_of(*soil);
    for (int tile = 0; tile < 4; ++tile) impl.tiles.wake(tile);
    const device::DeviceCounters after = counters_of(*soil);
    EXPECT_LT(after.write_bytes - before.write_bytes, tile_bytes);
}

// What a tower has left in a slot, the next tile there does not find.
TEST_P(DeviceUse, tiles_take_each_others_slots) {
    SoilDef def = grid_def(16, 8, 128);
    def.backend = GetParam();
    def.tile_capacity = 1;
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {8, 8, 100})));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {8, 0, 0}, {16, 8, 3})));
    Soil::Impl& impl = SoilProbe::impl(*soil);
    std::vector<TileVoxels> asleep(2);
    for (int tile = 0; tile < 2; ++tile) impl.tiles.read_voxels(tile, asleep[tile]);
    for (int i = 0; i < 4; ++i) {
        const int tile = i % 2;
        ASSERT_EQ(impl.tiles.wake(tile), 0);
        TileVoxels awake;
        impl.tiles.read_voxels(tile, awake);
        EXPECT_EQ(awake.words, asleep[tile].words) << i;
        impl.tiles.put_to_sleep({&tile, 1});
    }
}

// What is known of a tile's height is a bound, and a snapshot has it. Awake it is the soil's own
// again: a soil that goes on from a snapshot looks no further up than one that was never saved.
TEST_P(DeviceUse, a_tile_of_a_snapshot_wakes_as_high_as_its_soil) {
    SoilDef def = grid_def(8, 8, 64);
    def.backend = GetParam();
    const auto soil = make_soil(def), copy = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {8, 8, 3})));
    Soil::Impl &saved = SoilProbe::impl(*soil), &loaded = SoilProbe::impl(*copy);
    saved.tiles[0]->top = 40;
    const auto put = copy->prepare(soil->state());
    ASSERT_TRUE(put) << put.error();
    (*put)();
    for (Soil::Impl* impl : {&saved, &loaded}) {
        EXPECT_EQ(impl->tiles[0]->top, 40);
        ASSERT_GE(impl->tiles.wake(0), 0);
        EXPECT_EQ(impl->tiles[0]->top, 3);
    }
}

TEST_P(DeviceUse, tiles_that_fall_asleep_are_read_together) {
    SoilDef def = grid_def(32, 32, 16);
    def.backend = GetParam();
    const auto soil = make_soil(def);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {32, 32, 8})));
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{10, 10, 2} * 0.05), Vec3{16, 16, 8} * 0.05);
    for (int i = 0; i < 3; ++i) soil->step(bodies_of(movers));
    Soil::Impl& impl = SoilProbe::impl(*soil);
    int most = 0;
    for (int i = 0; i < 100 && impl.tiles.awake_count() > 0; ++i) {
        const int awake = impl.tiles.awake_count();
        const device::DeviceCounters before = counters_of(*soil);
        soil->step({});
        const int slept = awake - impl.tiles.awake_count();
        const auto groups = static_cast<int>((slept + kTilesARead - 1) / kTilesARead);
        EXPECT_LE(counters_of(*soil).read_count - before.read_count, 1 + groups) << i;
        most = std::max(most, slept);
    }
    EXPECT_EQ(impl.tiles.awake_count(), 0);
    EXPECT_GT(most, 2) << "one by one they would take as many reads";
}

TEST_P(DeviceUse, a_snapshot_reads_each_awake_tile_once) {
    SoilDef def = MovingScene::default_def();
    def.backend = GetParam();
    MovingScene scene(4, def);
    scene.run(5);
    const device::DeviceCounters before = counters_of(scene.soil());
    const TemporaryFile file("device_use.snapshot");
    EXPECT_TRUE(scene.soil().save(file.path()));
    EXPECT_EQ(counters_of(scene.soil()).read_count - before.read_count,
              SoilProbe::impl(scene.soil()).tiles.awake_count());
}

// What a body carries under another body is read by tiles: those that the step before had asked
// for with everything else, a new one when it is first asked for.
TEST_P(DeviceUse, carried_soil_is_read_with_the_rest_after_its_first_step) {
    SoilDef def = grid_def(48, 48, 24);
    def.backend = GetParam();
    const auto soil = make_soil(def);
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{12, 12, 2} * 0.05), Vec3{24, 24, 3} * 0.05);
    movers.emplace_back(2, box_shape(Vec3{4, 4, 2} * 0.05), Vec3{24, 24, 20} * 0.05);
    soil->step(bodies_of(movers));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {14, 14, 5}, {34, 34, 9})));
    for (int i = 0; i < 5; ++i) soil->step(bodies_of(movers));
    movers[1].body.pose.position.z = 10.5 * 0.05;
    const device::DeviceCounters before = counters_of(*soil);
    const StepReport landed = soil->step(bodies_of(movers));
    const auto carried = std::ranges::count_if(
        landed.contacts, [](const ContactVoxel& c) { return c.body == 2 && c.carrier == 1; });
    EXPECT_GT(carried, 0);
    Soil::Impl& impl = SoilProbe::impl(*soil);
    const auto tiles = static_cast<int64_t>(impl.contacts.surface().span_words() /
                                            (layout::kTileColumns * layout::kColumnWords));
    EXPECT_GT(tiles, 0);
    const int64_t reads = counters_of(*soil).read_count - before.read_count;
    EXPECT_GE(reads, 1 + tiles);
    EXPECT_LE(reads, 2 + tiles) << "and the records of what has landed";
    const device::DeviceCounters then = counters_of(*soil);
    soil->step(bodies_of(movers));
    EXPECT_EQ(counters_of(*soil).read_count - then.read_count, 1);
}

// Flags, tile table and surface heights of awake tiles, the contacts and the head: nothing else.
TEST_P(DeviceUse, a_step_reads_a_few_words_a_block_and_no_voxel) {
    SoilDef def = MovingScene::default_def();
    def.backend = GetParam();
    MovingScene scene(4, def);
    scene.run(20);
    Soil::Impl& impl = SoilProbe::impl(scene.soil());
    const device::DeviceCounters before = counters_of(scene.soil());
    const StepReport report = scene.step();
    const int64_t words = (counters_of(scene.soil()).read_bytes - before.read_bytes) / 4;
    const int64_t slot_words =
        2 * impl.blocks_per_tile + layout::kTileTableWords + layout::kTileColumns;
    const int64_t head =
        layout::kResultHeader + static_cast<int64_t>(impl.bodies.ids().size()) * layout::kLoadWords;
    // Where a body carries the soil under another one, the height spans of the tiles around as
    // well.
    const auto spans = static_cast<int64_t>(impl.contacts.surface().span_words());
    EXPECT_LT(spans, impl.tiles.slot_count() * layout::kTileColumns * layout::kColumnWords);
    const int64_t records = words - impl.tiles.slot_count() * slot_words - head - spans;
    EXPECT_EQ(records % layout::kContactWords, 0);
    EXPECT_LE(records / layout::kContactWords, 2 * static_cast<int64_t>(report.contacts.size()));
}

INSTANTIATE_TEST_SUITE_P(Backends, DeviceUse, testing::Values(Backend::cpu, Backend::gl),
                         [](const auto& backend) {
                             return backend.param == Backend::gl ? "gl" : "cpu";
                         });

TEST(DeviceTimes, gl_tells_the_stages_times_by_its_own_clock) {
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    SoilDef def = MovingScene::default_def();
    def.backend = Backend::gl;
    MovingScene scene(4, def);
    scene.run(10);
    const StageTimes ms = scene.step().stage_ms;
    for (double stage : {ms.voxelize, ms.deform, ms.advect, ms.slip, ms.contacts}) {
        EXPECT_GT(stage, 0);
    }
}

TEST(DeviceTimes, gl_tells_the_kernels_times_when_the_gpu_has_told_them) {
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    SoilDef def = MovingScene::default_def();
    def.backend = Backend::gl;
    MovingScene scene(4, def);
    const auto slip = [&] {
        const std::vector<PassWork> passes = scene.soil().work_counts().passes;
        return *std::ranges::find(passes, "slip_soil", &PassWork::name);
    };
    // Stamps are read when a later step begins. The host's clock knew a time at once.
    scene.step();
    EXPECT_GT(slip().dispatch_count, 0);
    EXPECT_EQ(slip().time_ms, 0);
    scene.run(5);
    EXPECT_GT(slip().time_ms, 0);
    for (const PassWork& pass : scene.soil().work_counts().passes) {
        if (pass.dispatch_count == 0) {
            EXPECT_EQ(pass.time_ms, 0) << pass.name;
        }
    }
}

}  // namespace
}  // namespace bsoil::device_use_test
