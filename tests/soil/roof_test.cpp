// Roofs of soil that was never moved, over hollows. By Terzaghi (1943) a strip holds itself up to a
// span of 2 c / gamma, whatever lies on it.
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bank_case.h"

namespace bsoil::roof_test {
namespace {

using namespace bank_test;

constexpr double kUnitWeight = 16000;  // N/m3

/// A tunnel through a block of soil, from one end of the grid to the other.
struct Tunnel {
    double cohesion_pa, voxel_m, yaw_deg;
    bool is_turned() const { return yaw_deg != 0; }
    double span_m() const { return 2 * cohesion_pa / kUnitWeight; }
    /// Columns side by side across it: a step along a diagonal of the grid is longer.
    double step_m() const { return voxel_m * (is_turned() ? std::numbers::sqrt2 : 1); }
    int at_most(double share) const {
        return static_cast<int>(std::floor(share * span_m() / step_m()));
    }
    int at_least(double share) const {
        return static_cast<int>(std::ceil(share * span_m() / step_m()));
    }
};
void PrintTo(const Tunnel& t, std::ostream* out) {
    *out << "c_" << t.cohesion_pa << "_voxel_mm_" << t.voxel_m * 1000 << "_yaw_" << t.yaw_deg;
}

// The walls of the trench that a fallen roof leaves stand: 0.3 m is 0.7 of what 1 kPa holds.
constexpr double kHollowM = 0.2, kRoofM = 0.1;

std::unique_ptr<Soil> make_tunnel(const Tunnel& t, int columns, Backend backend = Backend::cpu,
                                  int thread_count = 0) {
    // A turned one ends inside of the grid: no way across it leads out of the grid.
    const double half_m = t.is_turned() ? columns * t.step_m() : columns * t.step_m() / 2;
    const int side = 2 * static_cast<int>(std::ceil((half_m + 0.3) / t.voxel_m));
    const int across = t.is_turned() ? side : 8;
    const double high = kHollowM + kRoofM;
    SoilDef def =
        grid_def(side, across, static_cast<int>(std::lround(high / t.voxel_m)) + 4, t.voxel_m);
    def.material = sand(30, t.cohesion_pa);
    def.material.density_kg_m3 = kUnitWeight / kGravity;
    def.backend = backend;
    def.thread_count = thread_count;
    auto soil = make_soil(def);
    if (!soil) return nullptr;
    fill_columns(*soil, [&](double x, double y) {
        // In steps from the middle, from -columns / 2 on.
        const double dx = x / t.voxel_m - side / 2.0, dy = y / t.voxel_m - across / 2.0;
        const double at = t.is_turned() ? (dx + dy) / 2 : dx;
        const double along = t.is_turned() ? (dx - dy) / 2 : 0;
        const double first = t.is_turned() ? -columns / 2.0 - 0.25 : -(columns / 2);
        const bool is_hollow = at > first && at < first + columns && std::abs(along) < columns;
        return is_hollow ? 0 : kHollowM;
    });
    EXPECT_TRUE(
        soil->fill(BoxFill{{{0, 0, kHollowM}, {side * t.voxel_m, across * t.voxel_m, high}}, {}}));
    return soil;
}

/// How far the lowest column of the grid has come down.
double sunk_m(const Soil& soil) {
    const GridFrame& frame = soil.frame();
    double lowest = 1e9;
    for (int y = 0; y < frame.size[1]; ++y) {
        for (int x = 0; x < frame.size[0]; ++x) {
            lowest = std::min(lowest, soil.surface_height_m(x, y));
        }
    }
    return kHollowM + kRoofM - lowest;
}

/// Soil in the lower half of the hollow's middle, two voxels across, over what has room there. A
/// roof half as thick as the hollow is high fills it, and less where its walls hold what spreads.
double filled_share(const Soil& soil) {
    const GridFrame& frame = soil.frame();
    ConvexShape middle = box_shape({frame.voxel_m, frame.voxel_m, kHollowM / 4});
    Pose pose;
    pose.position = {frame.size[0] * frame.voxel_m / 2, frame.size[1] * frame.voxel_m / 2,
                     kHollowM / 4};
    const double room_m3 = 4 * frame.voxel_m * frame.voxel_m * kHollowM / 2;
    return soil.mass_inside_kg(middle, pose) / (room_m3 * kUnitWeight / kGravity);
}

class Roof : public testing::TestWithParam<Tunnel> {};

TEST_P(Roof, stands_at_nine_tenths_of_the_span_that_its_cohesion_gives) {
    const Tunnel& tunnel = GetParam();
    const auto soil = make_tunnel(tunnel, tunnel.at_most(0.9));
    ASSERT_TRUE(soil);
    const uint64_t checksum = soil->checksum();
    const auto settled = soil->settle(60);
    ASSERT_TRUE(settled);
    EXPECT_TRUE(settled->is_at_rest);
    for (int i = 0; i < 10'000; ++i) soil->step({});
    EXPECT_EQ(soil->checksum(), checksum);
    EXPECT_LT(sunk_m(*soil), 1e-6);
    EXPECT_EQ(filled_share(*soil), 0);
}

// Where an abutment is dug away a roof comes down that has stood asleep.
TEST_P(Roof, falls_when_an_abutment_is_taken_away) {
    const Tunnel& tunnel = GetParam();
    const auto soil = make_tunnel(tunnel, tunnel.at_most(0.9));
    ASSERT_TRUE(soil);
    ASSERT_TRUE(soil->settle(60));
    EXPECT_LT(sunk_m(*soil), 1e-6);
    const GridFrame& frame = soil->frame();
    const double length_m = frame.size[0] * tunnel.voxel_m;
    SinkDef sink;  // a trench beside the tunnel, as deep, and no soil that could lean on it
    sink.region.kind = ConvexShape::Kind::box;
    sink.region.half_extents_m = {0.15, length_m, kHollowM + kRoofM};
    const double yaw = tunnel.yaw_deg * kDegree;
    const double away_m = tunnel.at_most(0.9) * tunnel.step_m() / 2 + 0.15;
    sink.pose.position = {length_m / 2 + away_m * std::cos(yaw),
                          frame.size[1] * tunnel.voxel_m / 2 + away_m * std::sin(yaw), 0};
    sink.pose.rotation = turn({0, 0, 1}, yaw);
    const auto added = soil->add_sink(sink);
    ASSERT_TRUE(added);
    for (int i = 0; i < 300; ++i) soil->step({});
    EXPECT_GT(filled_share(*soil), 0.25);
}

TEST_P(Roof, falls_at_eleven_tenths_of_it) {
    const Tunnel& tunnel = GetParam();
    const auto soil = make_tunnel(tunnel, tunnel.at_least(1.1));
    ASSERT_TRUE(soil);
    const auto settled = soil->settle(600);
    ASSERT_TRUE(settled);
    EXPECT_TRUE(settled->is_at_rest);
    EXPECT_GT(filled_share(*soil), 0.25);
}

// Spans of at least four voxels.
INSTANTIATE_TEST_SUITE_P(Spans, Roof,
                         testing::Values(Tunnel{1000, 0.025, 0}, Tunnel{1000, 0.025, 45},
                                         Tunnel{5000, 0.1, 0}, Tunnel{5000, 0.1, 45},
                                         Tunnel{5000, 0.05, 0}, Tunnel{5000, 0.05, 45},
                                         Tunnel{5000, 0.025, 0}, Tunnel{5000, 0.025, 45}));

/// What lies from a voxel's height up counts as moved, and all of it is looked at in the next step.
void loosen_above(Soil& soil, int height) {
    Soil::Impl& s = SoilProbe::impl(soil);
    const int first = layout::kTileColumns * height;
    const std::vector<int32_t> none(static_cast<size_t>(s.params.tile_voxels - first), 0);
    for (int index = 0; index < static_cast<int>(s.tiles.size()); ++index) {
        const int slot = s.tiles.wake(index);
        s.device->write(layout::Buffer::state,
                        int64_t{layout::kPlaneBond} * s.params.plane_stride +
                            int64_t{slot} * s.params.tile_voxels + first,
                        none);
        s.tiles.note_stale(slot, true);
        for (int z = 0; z < s.blocks_per_tile; ++z) s.lists.activate(s.block_key(index, z));
    }
}

// By hand: half of the height holds all of the weight, so that half of the span stands.
TEST(Roof, spans_less_with_moved_soil_on_it) {
    const Tunnel tunnel{5000, 0.05, 0};
    const int half = static_cast<int>(std::lround((kHollowM + kRoofM / 2) / tunnel.voxel_m));
    for (const double share : {0.45, 0.55}) {
        const int columns = share < 0.5 ? tunnel.at_most(share) : tunnel.at_least(share);
        const auto soil = make_tunnel(tunnel, columns);
        ASSERT_TRUE(soil);
        loosen_above(*soil, half);
        ASSERT_TRUE(soil->settle(600));
        if (share < 0.5) {
            EXPECT_EQ(filled_share(*soil), 0);
            EXPECT_LT(sunk_m(*soil), 1e-6);
        } else {
            EXPECT_GT(filled_share(*soil), 0.25);
        }
    }
}

uint64_t checksum_after(Soil& soil, int steps) {
    for (int i = 0; i < steps; ++i) soil.step({});
    return soil.checksum();
}

// Half of the roofs stand and the other half fall.
TEST(Roof, has_the_same_bits_on_opengl_on_threads_and_from_a_snapshot) {
    const Tunnel tunnel{5000, 0.05, 45};
    std::vector<std::pair<int, uint64_t>> found;  // columns, checksum
    for (const double share : {0.9, 1.1}) {
        const int columns = share < 1 ? tunnel.at_most(share) : tunnel.at_least(share);
        const auto one = make_tunnel(tunnel, columns, Backend::cpu, 1);
        const auto two = make_tunnel(tunnel, columns, Backend::cpu, 2);
        ASSERT_EQ(checksum_after(*one, 6), checksum_after(*two, 6));
        const auto again = make_tunnel(tunnel, columns, Backend::cpu, 1);
        const auto put = again->prepare(one->state());
        ASSERT_TRUE(put) << put.error();
        (*put)();
        const uint64_t checksum = checksum_after(*one, 40);
        EXPECT_EQ(checksum_after(*two, 40), checksum);
        EXPECT_EQ(checksum_after(*again, 40), checksum);
        found.emplace_back(columns, checksum);
    }
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    for (const auto& [columns, checksum] : found) {
        const auto gl = make_tunnel(tunnel, columns, Backend::gl);
        EXPECT_EQ(checksum_after(*gl, 46), checksum);
    }
}

// Which columns are hollow was not in snapshots: where what holds a roof changed in the first step
// after a load its block did not count as changed.
TEST(Roof, goes_on_from_a_snapshot_with_the_same_blocks_active) {
    const Tunnel tunnel{5000, 0.05, 45};
    const auto saved = make_tunnel(tunnel, tunnel.at_least(1.1), Backend::cpu, 1);
    const auto restored = make_tunnel(tunnel, tunnel.at_least(1.1), Backend::cpu, 1);
    for (int stop = 0; stop < 16; ++stop) {
        const auto put = restored->prepare(saved->state());
        ASSERT_TRUE(put) << put.error();
        (*put)();
        ASSERT_TRUE(restored->state() == saved->state()) << stop << ", nothing got lost";
        for (Soil* soil : {saved.get(), restored.get()}) soil->step({});
        ASSERT_TRUE(restored->state() == saved->state()) << stop;
    }
}

// A body beside one abutment wakes the tiles around it. The other abutment is in a tile that goes
// on sleeping. The hollow is deep below the block in which the body stands, which is all that a
// world from a snapshot has active.
TEST(Roof, stands_where_half_of_it_sleeps) {
    constexpr double kVoxel = 0.05, kDeep = 0.2, kHigh = 0.9, kWidth = 16 * kVoxel;
    constexpr int kFirst = 28, kLast = 38, kColumns = 64;  // 10 columns of 12 that it spans
    const auto make = [&] {
        SoilDef def = grid_def(kColumns, 16, 24, kVoxel);
        def.material = sand(30, 5000);
        def.material.density_kg_m3 = kUnitWeight / kGravity;
        auto soil = make_soil(def);
        for (const auto& [from, to, low] :
             {std::tuple(0, kFirst, 0.0), {kFirst, kLast, kDeep}, {kLast, kColumns, 0.0}}) {
            EXPECT_TRUE(
                soil->fill(BoxFill{{{from * kVoxel, 0, low}, {to * kVoxel, kWidth, kHigh}}, {}}));
        }
        return soil;
    };
    const auto soil = make();
    for (int i = 0; i < 100; ++i) soil->step({});
    EXPECT_EQ(soil->step({}).block_active_count, 0);
    std::vector<Mover> box;
    box.emplace_back(1, box_shape({0.1, 0.2, 0.1}), Vec3{20 * kVoxel, kWidth / 2, kHigh + 0.11});
    const auto press = [&](Soil& in, int steps) {
        box.front().set_velocity({0, 0, -0.1});
        for (int i = 0; i < steps; ++i) {
            box.front().advance(in.def().step_s);
            in.step(bodies_of(box));
        }
    };
    press(*soil, 30);
    const auto again = make();
    const auto put = again->prepare(soil->state());
    ASSERT_TRUE(put) << put.error();
    (*put)();
    const Mover at = Mover(1, box_shape({0.1, 0.2, 0.1}), box.front().body.pose.position);
    press(*soil, 30);
    box.front().body.pose = at.body.pose;
    press(*again, 30);
    EXPECT_EQ(again->checksum(), soil->checksum());
    Pose hollow;
    hollow.position = {(kFirst + kLast) * kVoxel / 2, kWidth / 2, kDeep / 2};
    const ConvexShape inside = box_shape({(kLast - kFirst) * kVoxel / 2, kWidth / 2, kDeep / 2});
    EXPECT_EQ(soil->mass_inside_kg(inside, hollow), 0);
    for (int x = kFirst; x < kLast; ++x) EXPECT_NEAR(soil->surface_height_m(x, 8), kHigh, 1e-6);
}

}  // namespace
}  // namespace bsoil::roof_test
