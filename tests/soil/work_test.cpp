// How much the passes look at: counts, the same on every machine.
#include <cstdlib>
#include <numbers>
#include <numeric>

#include "base/kernels.h"
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

/// What a device was asked for while `work` was done.
struct Cost {
    std::vector<int64_t> lanes;  ///< by kernel
    int64_t dispatch_count = 0, read_count = 0, read_bytes = 0, write_bytes = 0;

    int64_t all_lanes() const { return std::accumulate(lanes.begin(), lanes.end(), int64_t{0}); }
};

template <typename Work>
Cost cost_of(Soil& soil, Work&& work) {
    const device::DeviceCounters before = SoilProbe::impl(soil).device->counters();
    Cost cost;
    cost.lanes = lanes_in(soil, work);
    const device::DeviceCounters& after = SoilProbe::impl(soil).device->counters();
    cost.dispatch_count = after.dispatch_count - before.dispatch_count;
    cost.read_count = after.read_count - before.read_count;
    cost.read_bytes = after.read_bytes - before.read_bytes;
    cost.write_bytes = after.write_bytes - before.write_bytes;
    return cost;
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
/// with the first material's for all of them, they are 28100 and 40200. Those of flows are from
/// after pushed soil flies, those of spans and slips from after soil that lies under bodies slides:
/// 8 % more. That of support is from after confined soil rises alike in all directions, that of
/// contacts from after all of a load is looked at, however high it lies.
TEST(Work, passes_look_at_little_more_than_what_moves) {
    MovingScene scene(4, cpu_def(MovingScene::default_def()));
    scene.run(20);
    int64_t listed = 0;
    const Cost cost = cost_of(scene.soil(), [&] {
        for (int i = 0; i < 20; ++i) listed += 64 * scene.step().block_dispatched_count;
    });
    struct Bound {
        Kernel kernel;
        int64_t lane_count;
    };
    for (const auto& [kernel, most] :
         {Bound{Kernel::apply_force, 15900}, Bound{Kernel::propagate_force, 48400},
          Bound{Kernel::apply_flow, 197500}, Bound{Kernel::advect_soil, 32400},
          Bound{Kernel::resolve_overflow, 51000}, Bound{Kernel::build_spans, 81400},
          Bound{Kernel::slip_soil, 120600}, Bound{Kernel::voxelize_shapes, 22200},
          Bound{Kernel::collect_contacts, 17100}, Bound{Kernel::find_support, 40300},
          Bound{Kernel::find_failures, 21800}}) {
        EXPECT_LE(cost.lanes[static_cast<size_t>(kernel)], most)
            << soil_kernel_set().kernels[static_cast<size_t>(kernel)].name << " of " << listed;
    }
    EXPECT_LE(cost.dispatch_count, 1127);
    EXPECT_LE(cost.write_bytes, 34960);
    EXPECT_LE(cost.read_bytes, 9381000);
}

constexpr int kBladeRoom = 64;  ///< voxels along each side in which a blade works for itself

/// 20 steps of blades, each in a square of kBladeRoom voxels of its own, from the square `first`
/// on, on a bed of `columns` x `columns` columns. Lengths are sums of powers of two, so that no
/// rounding tells places apart.
Cost cost_of_blades(int columns, int first, int blade_count) {
    constexpr int kBed = 12;
    constexpr double kVoxelM = 1.0 / 16, kWay = 3.0 / 8;
    SoilDef def = cpu_def(grid_def(columns, columns, 32, kVoxelM));
    def.step_s = 1.0 / 30;
    const auto soil = make_soil(def);
    EXPECT_TRUE(
        soil->fill(voxel_box(*soil, {0, 0, 0}, Vec3{1.0 * columns, 1.0 * columns, 1.0 * kBed})));
    std::vector<Mover> movers;
    for (int i = first; i < first + blade_count; ++i) {
        const Vec3 corner{1.0 * (i % 4 * kBladeRoom), 1.0 * (i / 4 * kBladeRoom), 0};
        movers.emplace_back(i + 1, box_shape(Vec3{1, 7.5, 4} * kVoxelM),
                            (corner + Vec3{20.25, 32.25, kBed + 0.25}) * kVoxelM);
        movers.back().set_velocity({kWay * kVoxelM / soil->def().step_s, 0, 0});
    }
    const auto run = [&](int steps) {
        for (int i = 0; i < steps; ++i) {
            for (Mover& mover : movers) {
                mover.body.pose.position.x += kWay * kVoxelM;
                mover.body.center_of_mass_m = mover.body.pose.position;
            }
            soil->step(bodies_of(movers));
        }
    };
    run(30);  // by then the table of awake tiles has grown for the last time
    return cost_of(*soil, [&] { run(20); });
}

void expect_no_more(const Cost& cost, const Cost& other, double factor) {
    const auto bound = [factor](int64_t count) { return factor * static_cast<double>(count); };
    for (size_t kernel = 0; kernel < cost.lanes.size(); ++kernel) {
        EXPECT_LE(cost.lanes[kernel], bound(other.lanes[kernel]))
            << soil_kernel_set().kernels[kernel].name;
    }
    EXPECT_LE(cost.write_bytes, bound(other.write_bytes));
}

/// Ten million columns asleep: the bar for them is a twentieth more, and they cost nothing.
TEST(Work, is_the_same_on_ten_million_sleeping_columns_as_on_few) {
    const Cost few = cost_of_blades(2 * kBladeRoom, 0, 1);
    const Cost many = cost_of_blades(3200, 0, 1);
    EXPECT_GT(few.all_lanes(), 10000);
    EXPECT_EQ(many.lanes, few.lanes);
    EXPECT_EQ(many.dispatch_count, few.dispatch_count);
    EXPECT_EQ(many.read_count, few.read_count);
    EXPECT_EQ(many.read_bytes, few.read_bytes);
    EXPECT_EQ(many.write_bytes, few.write_bytes);
}

/// Soil rolls by chance, which is a place's own, so each blade is counted alone in its place as
/// well. What one of them leaves too steep makes a pass more for all.
TEST(Work, of_ten_blades_is_at_most_that_of_each_alone) {
    constexpr double kPasses = 1.04;  // measured: 1.03
    constexpr int kBlades = 10;
    Cost alone = cost_of_blades(4 * kBladeRoom, 0, 1);
    const int64_t read_bytes = alone.read_bytes;
    for (int i = 1; i < kBlades; ++i) {
        const Cost next = cost_of_blades(4 * kBladeRoom, i, 1);
        for (size_t kernel = 0; kernel < alone.lanes.size(); ++kernel) {
            alone.lanes[kernel] += next.lanes[kernel];
        }
        alone.write_bytes += next.write_bytes;
        alone.dispatch_count = std::max(alone.dispatch_count, next.dispatch_count);
    }
    const Cost ten = cost_of_blades(4 * kBladeRoom, 0, kBlades);
    EXPECT_GT(10 * ten.all_lanes(), 9 * alone.all_lanes()) << "else they are not ten";
    EXPECT_LE(static_cast<double>(ten.dispatch_count),
              kPasses * static_cast<double>(alone.dispatch_count));
    expect_no_more(ten, alone, kPasses);
    // What a step reads goes with the slots for awake tiles, which double: 1024 for 528 tiles, and
    // 64 for 53.
    EXPECT_LE(static_cast<double>(ten.read_bytes), 12 * static_cast<double>(read_bytes));
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

/// While it lives, new soils count what their kernels touch.
class Counting {
  public:
    Counting() { setenv("BULLETSOIL_CPU", "counting", 1); }
    ~Counting() { unsetenv("BULLETSOIL_CPU"); }
};

TEST(Touched, is_counted_alike_with_any_number_of_threads_and_changes_no_bit) {
    const auto run = [](int threads) {
        SoilDef def = cpu_def(MovingScene::default_def());
        def.thread_count = threads;
        MovingScene scene(4, def);
        scene.run(12);
        return std::pair(scene.soil().work_counts(), scene.soil().checksum());
    };
    const auto [plain, plain_sum] = run(1);
    const Counting counting;
    const auto [one, one_sum] = run(1);
    const auto [four, four_sum] = run(4);
    EXPECT_EQ(one_sum, plain_sum);
    EXPECT_EQ(four_sum, plain_sum);
    for (size_t i = 0; i < plain.passes.size(); ++i) {
        const PassWork &a = one.passes[i], &b = four.passes[i];
        EXPECT_EQ(plain.passes[i].moved_bytes, 0) << "nothing asked for a count";
        EXPECT_EQ(a.column_count, plain.passes[i].column_count) << a.name;
        EXPECT_EQ(a.moved_bytes > 0, a.dispatch_count > 0) << a.name;
        EXPECT_EQ(a.moved_bytes, b.moved_bytes) << a.name;
        EXPECT_EQ(a.voxel_visited_count, b.voxel_visited_count) << a.name;
        EXPECT_EQ(a.voxel_changed_count, b.voxel_changed_count) << a.name;
        EXPECT_LE(a.voxel_changed_count, a.voxel_visited_count) << a.name;
    }
}

/// Bounds are 5 % above what was counted when they were written down, those of advection
/// after soil can leave the ground, those of support, overflow and bonds after confined soil rises
/// alike in all directions, those of contacts after they tell what was moved, those of spans and
/// slips after soil that lies under bodies slides: 9 % more soil slips; those of failures after
/// their planes ask whether columns have changed. In all, 4.3 voxels were visited for one changed,
/// and 4.57 since slopes stop sooner: their last creep changed more than it visited.
TEST(Touched, stays_in_proportion_to_what_changes) {
    const Counting counting;
    MovingScene scene(4, cpu_def(MovingScene::default_def()));
    scene.run(20);
    const std::vector<PassWork> before = scene.soil().work_counts().passes;
    scene.run(20);
    const std::vector<PassWork> after = scene.soil().work_counts().passes;
    struct Bound {
        Kernel kernel;
        int64_t visited_count, moved_bytes;
    };
    int64_t visited_count = 0, changed_count = 0;
    for (const auto& [kernel, visited, bytes] : {
             Bound{Kernel::clear_coverage, 31010, 298700},
             Bound{Kernel::voxelize_shapes, 14270, 294200},
             Bound{Kernel::apply_force, 134200, 3294000},
             Bound{Kernel::propagate_force, 475900, 21210000},
             Bound{Kernel::apply_flow, 380300, 42020000},
             Bound{Kernel::find_support, 134500, 2957000},
             Bound{Kernel::advect_soil, 242200, 7889000},
             Bound{Kernel::resolve_overflow, 340500, 4312000},
             Bound{Kernel::build_spans, 625800, 15440000},
             Bound{Kernel::find_failures, 33280, 1171000},
             Bound{Kernel::break_bonds, 3511, 59900},
             Bound{Kernel::slip_soil, 161800, 16640000},
             Bound{Kernel::collect_contacts, 145900, 3033000},
         }) {
        const PassWork &was = before[static_cast<size_t>(kernel)],
                       &is = after[static_cast<size_t>(kernel)];
        EXPECT_LE(is.voxel_visited_count - was.voxel_visited_count, visited) << is.name;
        EXPECT_LE(is.moved_bytes - was.moved_bytes, bytes) << is.name;
        visited_count += is.voxel_visited_count - was.voxel_visited_count;
        changed_count += is.voxel_changed_count - was.voxel_changed_count;
    }
    EXPECT_GT(changed_count, 500000);
    EXPECT_LE(static_cast<double>(visited_count), 4.66 * static_cast<double>(changed_count));
}

}  // namespace
}  // namespace bsoil::work_test
