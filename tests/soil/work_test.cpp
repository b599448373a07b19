// How much the passes look at: counts, the same on every machine.
#include <numbers>

#include "device/kernel_set.h"
#include "moving_scene.h"
#include "soil/soil_kernels.h"

namespace bsoil::work_test {
namespace {

using layout::Kernel;

std::vector<int64_t> lanes_of(Soil& soil) {
    return SoilProbe::impl(soil).device->counters().lane_counts;
}

/// Lanes with work, by kernel, that `work` asks for.
template <typename Work>
std::vector<int64_t> lanes_in(Soil& soil, Work&& work) {
    std::vector<int64_t> before = lanes_of(soil);
    work();
    std::vector<int64_t> after = lanes_of(soil);
    before.resize(after.size());
    for (size_t i = 0; i < after.size(); ++i) after[i] -= before[i];
    return after;
}

SoilDef cpu_def(SoilDef def) {
    def.backend = Backend::cpu;
    return def;
}

TEST(Work, a_bed_at_rest_under_a_standing_body_is_not_looked_at) {
    const auto soil = make_soil(cpu_def(grid_def(64, 64, 32)));
    ASSERT_TRUE(soil);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {64, 64, 16})));
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{5, 5, 2} * 0.05), Vec3{32, 32, 17.9} * 0.05);
    for (int i = 0; i < 120; ++i) soil->step(bodies_of(movers));
    const std::vector<int64_t> lanes = lanes_in(*soil, [&] { soil->step(bodies_of(movers)); });
    for (size_t kernel = 0; kernel < lanes.size(); ++kernel) {
        if (kernel != static_cast<size_t>(Kernel::collect_contacts)) {
            EXPECT_EQ(lanes[kernel], 0) << soil_kernel_set().kernels[kernel].name;
        }
    }
    // Two blocks of air above the sole's corners are as much as it may waste.
    EXPECT_LE(lanes[static_cast<size_t>(Kernel::collect_contacts)], 2 * 12 * 12 + 64);
}

/// Bounds are 5 % above what was counted when they were written down: a pass that looks at more has
/// lost what it gained. Those of sliding are from after mixtures slide by the mean of their
/// materials, those of advection and overflow from after each soil is carried by its own friction:
/// with the first material's for all of them, they are 28100 and 40200.
TEST(Work, passes_look_at_little_more_than_what_moves) {
    MovingScene scene(4, cpu_def(MovingScene::default_def()));
    scene.run(20);
    int64_t listed = 0;
    const std::vector<int64_t> lanes = lanes_in(scene.soil(), [&] {
        for (int i = 0; i < 20; ++i) listed += 64 * scene.step().block_dispatched_count;
    });
    struct Bound {
        Kernel kernel;
        int64_t lane_count;
    };
    for (const auto& [kernel, most] :
         {Bound{Kernel::apply_force, 15900}, Bound{Kernel::propagate_force, 48400},
          Bound{Kernel::apply_flow, 197500}, Bound{Kernel::advect_soil, 32400},
          Bound{Kernel::resolve_overflow, 51000}, Bound{Kernel::build_spans, 75700},
          Bound{Kernel::slip_soil, 114500}, Bound{Kernel::voxelize_shapes, 22200},
          Bound{Kernel::collect_contacts, 15200}}) {
        EXPECT_LE(lanes[static_cast<size_t>(kernel)], most)
            << soil_kernel_set().kernels[static_cast<size_t>(kernel)].name << " of " << listed;
    }
}

/// A bar of 2 x 2 x 60 voxels stands aslant: the box around it along the grid's axes holds 32 x 32
/// columns, 8 voxels of each in 6 blocks. Its middle passes through 18 blocks, and with its reach
/// it touches about 30 of 150.
TEST(Work, a_long_body_aslant_is_looked_at_where_it_is) {
    const auto soil = make_soil(cpu_def(grid_def(64, 64, 64)));
    ASSERT_TRUE(soil);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {64, 64, 50})));
    constexpr double kQuarter = std::numbers::pi / 4;
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{30, 1, 1} * 0.05), Vec3{32, 32, 32} * 0.05);
    movers.back().body.pose.rotation = turn({0, 0, 1}, kQuarter) * turn({0, 1, 0}, -kQuarter);
    soil->step(bodies_of(movers));
    movers.back().body.pose.position.x += 0.01;
    const std::vector<int64_t> lanes = lanes_in(*soil, [&] { soil->step(bodies_of(movers)); });
    const int64_t around = 32 * 32 * 6;
    EXPECT_GT(lanes[static_cast<size_t>(Kernel::voxelize_shapes)], 300);
    EXPECT_LT(lanes[static_cast<size_t>(Kernel::voxelize_shapes)], around / 2);
}

// The table of awake tiles grows beyond its first 64 while they wake. What was known of the columns
// before is found again, though only the blocks at the surface are listed.
TEST(Work, looks_at_the_surface_of_a_deep_bed_and_not_at_all_of_it) {
    constexpr int kBed = 32, kHeight = 64;
    const auto soil = make_soil(cpu_def(grid_def(160, 160, kHeight)));
    ASSERT_TRUE(soil);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {160, 160, kBed})));
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{8, 50, 6} * 0.05), Vec3{40, 80, kBed + 2} * 0.05);
    auto& impl = SoilProbe::impl(*soil);
    int32_t before_last = 0;
    for (int i = 0; i < 10; ++i) {
        movers.back().body.pose.position.x += 0.5 * 0.05;
        movers.back().body.linear_velocity_m_s.x = 0.5 * 0.05 / soil->def().step_s;
        before_last = impl.params.pass_stamp;
        soil->step(bodies_of(movers));
    }
    ASSERT_GT(impl.tiles.awake_count(), 64);
    const auto words_of = [&](int array) {
        std::vector<int32_t> words(static_cast<size_t>(impl.tiles.slot_count()) *
                                   layout::kTileColumns);
        impl.device->read(layout::Buffer::spans, impl.tiles.column_array_offset(array, 0), words);
        return words;
    };
    const std::vector<int32_t> stamp = words_of(layout::kColumnStamp);
    const std::vector<int32_t> full = words_of(layout::kColumnFull);
    const std::vector<int32_t> end = words_of(layout::kColumnEnd);
    int changed_count = 0;
    for (size_t c = 0; c < stamp.size(); ++c) {
        if (stamp[c] <= before_last) continue;
        ++changed_count;
        EXPECT_GE(full[c], kBed / 2) << c;
        EXPECT_LE(end[c], kBed + 16) << c;
    }
    EXPECT_GT(changed_count, 1000);
}

TEST(Work, is_told_by_pass) {
    MovingScene scene(4, cpu_def(MovingScene::default_def()));
    const WorkCounts before = scene.soil().work_counts();
    EXPECT_EQ(before.passes.size(), soil_kernel_set().kernels.size());
    const std::vector<int64_t> lanes = lanes_in(scene.soil(), [&] { scene.run(3); });
    const WorkCounts after = scene.soil().work_counts();
    int64_t dispatches = 0;
    for (size_t i = 0; i < after.passes.size(); ++i) {
        const PassWork &was = before.passes[i], &is = after.passes[i];
        EXPECT_EQ(is.name, soil_kernel_set().kernels[i].name);
        EXPECT_EQ(is.column_count - was.column_count, lanes[i]) << is.name;
        EXPECT_EQ(is.dispatch_count > was.dispatch_count, is.time_ms > was.time_ms) << is.name;
        dispatches += is.dispatch_count - was.dispatch_count;
    }
    EXPECT_GT(dispatches, 30);
    EXPECT_EQ(dispatches, after.dispatch_count - before.dispatch_count);
    EXPECT_GT(after.read_bytes, before.read_bytes);
}

}  // namespace
}  // namespace bsoil::work_test
