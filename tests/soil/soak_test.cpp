// Digging for long: work, memory and bits of a step stay what they were. Some thousand steps here;
// tests/soak.sh sets BULLETSOIL_SOAK_STEPS to a million.
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "allocation_count.h"
#include "soil_fixture.h"

namespace bsoil::soak_test {
namespace {

/// Steps of one round of the blade.
constexpr int kRound = 400;
/// So many rounds are no part of what is compared: the blade shapes its trench.
constexpr int kWarmRounds = 5;
/// Stamps wrap this many steps after the start.
constexpr int64_t kStepsToWrap = 3 * kRound + 17;

/// here: without BULLETSOIL_SOAK_STEPS.
int64_t soak_steps(int64_t here) {
    const char* text = std::getenv("BULLETSOIL_SOAK_STEPS");
    return text ? std::max<int64_t>(std::atoll(text), 2 * kWarmRounds * kRound) : here;
}

/// A blade that goes to and fro through a bed with a post in it, and turns as it goes. Where it is
/// follows from the step, so that no rounding adds up.
class Dig {
  public:
    /// The stamps of steps wrap after `steps_to_wrap`, as they do after a million.
    explicit Dig(int64_t steps_to_wrap, int thread_count = 1) {
        SoilDef def = grid_def(26, 18, 16);
        def.thread_count = thread_count;
        soil_ = make_soil(def);
        Soil::Impl& impl = SoilProbe::impl(*soil_);
        impl.step_index = kStampWrap - steps_to_wrap;
        impl.params.step_stamp = step_stamp_of(impl.step_index);
        EXPECT_TRUE(soil_->fill(voxel_box(*soil_, {0, 0, 0}, {26, 18, 6})));
        EXPECT_TRUE(soil_->fill(voxel_box(*soil_, {2, 2, 6}, {8, 9, 10})));
        movers_.emplace_back(1, box_shape(Vec3{1.2, 4, 3} * voxel()), Vec3{});
        movers_.emplace_back(2, round_shape(ConvexShape::Kind::cylinder, 0.1, 0.3),
                             Vec3{20, 13, 7} * voxel(), true);
        bodies_ = bodies_of(movers_);
    }

    StepReport step() {
        ++step_count_;
        SoilBody& blade = bodies_[0];
        blade.pose = course(step_count_);
        blade.center_of_mass_m = blade.pose.position;
        const Pose before = course(step_count_ - 1);
        blade.linear_velocity_m_s = (blade.pose.position - before.position) * 60.0;
        const Quat change = blade.pose.rotation * conjugate(before.rotation);
        blade.angular_velocity_rad_s = Vec3{change.x, change.y, change.z} * 120.0;
        return soil_->step(bodies_);
    }
    void run(int64_t steps) {
        for (int64_t i = 0; i < steps; ++i) step();
    }
    /// As far as its bodies go; for a soil that is loaded.
    void skip_to(int64_t steps) { step_count_ = steps; }
    Soil& soil() { return *soil_; }

  private:
    static double voxel() { return 0.05; }
    static Pose course(int64_t step) {
        const double turn_rad = 2 * std::numbers::pi * static_cast<double>(step % kRound) / kRound;
        return {Vec3{12 + 6 * std::sin(turn_rad), 8 + 2 * std::cos(turn_rad), 6.3} * voxel(),
                turn({0, 0, 1}, 0.4 * std::cos(turn_rad))};
    }

    std::unique_ptr<Soil> soil_;
    std::vector<Mover> movers_;
    std::vector<SoilBody> bodies_;
    int64_t step_count_ = 0;
};

/// Resident memory of this process [bytes].
int64_t resident_bytes() {
    int64_t pages = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> pages >> resident;
    return resident * sysconf(_SC_PAGESIZE);
}

TEST(Soak, neither_work_nor_memory_of_a_step_grows) {
    Dig dig(kStepsToWrap);
    const std::vector<int64_t> units = dig.soil().totals().units;
    // The trench still changes after ten rounds, by a thirtieth of the work, and no more after
    // twenty.
    constexpr int64_t kRoundsLeast = 20;
    const int64_t rounds = std::max(kRoundsLeast, soak_steps(0) / kRound);
    std::vector<double> blocks;  // dispatched a step, by round
    int64_t allocated = 0, resident_at_first = 0;
    std::vector<int> awake_tiles;
    int steps_alike = 0;  // in which tiles are awake
    for (int64_t round = 0; round < rounds; ++round) {
        double sum = 0;
        for (int i = 0; i < kRound; ++i) {
            const int64_t before = allocation_count();
            const StepReport report = dig.step();
            // A tile that wakes or falls asleep keeps its soil in another place, and is read there
            // by the step after.
            const int64_t made = allocation_count() - before;
            const std::span<const int> now = SoilProbe::impl(dig.soil()).tiles.slot_tiles();
            steps_alike = std::ranges::equal(now, awake_tiles) ? steps_alike + 1 : 0;
            awake_tiles.assign(now.begin(), now.end());
            if (round >= kWarmRounds && steps_alike > 1) allocated += made;
            sum += report.block_dispatched_count;
        }
        blocks.push_back(sum / kRound);
        if (round == kWarmRounds) resident_at_first = resident_bytes();
    }
    EXPECT_EQ(dig.soil().totals().units, units);
    EXPECT_EQ(dig.soil().status_bits(), 0u);
    EXPECT_EQ(allocated, 0);
    // The allocator keeps a page here and there; a leak of a byte a step would be 1 MB in a
    // million.
    EXPECT_LT(resident_bytes() - resident_at_first, 1 << 20);
    const auto mean = [&](size_t first, size_t count) {
        double sum = 0;
        for (size_t i = first; i < first + count; ++i) sum += blocks[i];
        return sum / static_cast<double>(count);
    };
    const size_t tail = (blocks.size() - kWarmRounds) / 2;
    const double early = mean(kWarmRounds, tail), late = mean(blocks.size() - tail, tail);
    EXPECT_GT(early, 5) << "else nothing is dug";
    // The trench is what it is by then: rounds differ by single grains.
    EXPECT_NEAR(late / early, 1, 0.02);
}

TEST(Soak, ends_with_the_same_bits_twice) {
    Dig first(kStepsToWrap), second(kStepsToWrap, 2);
    const int64_t steps = soak_steps(2000);
    first.run(steps);
    second.run(steps);
    EXPECT_EQ(first.soil().checksum(), second.soil().checksum());
}

TEST(Soak, stamps_that_wrap_lose_no_soil_and_stop_nothing) {
    constexpr int kBefore = 30;
    Dig dig(kBefore);
    const std::vector<int64_t> units = dig.soil().totals().units;
    int blocks_least = 1 << 30;
    for (int i = 0; i < 2 * kBefore; ++i) {
        const uint64_t before = dig.soil().checksum();
        const StepReport report = dig.step();
        blocks_least = std::min(blocks_least, report.block_active_count);
        EXPECT_EQ(dig.soil().totals().units, units) << i - kBefore << " steps after the wrap";
        EXPECT_NE(dig.soil().checksum(), before) << "nothing moves " << i - kBefore;
    }
    EXPECT_GT(blocks_least, 0);
}

TEST(Soak, a_snapshot_goes_on_over_the_wrap) {
    constexpr int kBefore = 30;
    for (const int saved_after : {kBefore - 2, kBefore - 1, kBefore, kBefore + 1}) {
        Dig saved(kBefore), restored(kBefore);
        saved.run(saved_after);
        auto put = restored.soil().prepare(saved.soil().state());
        ASSERT_TRUE(put) << put.error();
        (*put)();
        restored.skip_to(saved_after);
        for (int i = 0; i < 20; ++i) {
            saved.step();
            restored.step();
            ASSERT_EQ(restored.soil().checksum(), saved.soil().checksum())
                << "saved after " << saved_after << ", " << i << " steps on";
        }
    }
}

TEST(Soak, soil_at_rest_stays_at_rest_over_the_wrap) {
    auto soil = make_soil(grid_def(24, 24, 16));
    Soil::Impl& impl = SoilProbe::impl(*soil);
    constexpr int kBefore = 600;
    impl.step_index = kStampWrap - kBefore;
    impl.params.step_stamp = step_stamp_of(impl.step_index);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {24, 24, 4})));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {8, 8, 4}, {16, 16, 12})));
    for (int i = 0; i < kBefore - 5; ++i) soil->step({});
    ASSERT_EQ(soil->step({}).block_active_count, 0);
    const uint64_t checksum = soil->checksum();
    for (int i = 0; i < 20; ++i) EXPECT_EQ(soil->step({}).block_active_count, 0);
    EXPECT_EQ(soil->checksum(), checksum);
}

}  // namespace
}  // namespace bsoil::soak_test
