// Static bodies as part of the terrain: what they cover, what they bury, what they cost.
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "bsoil/distance_lattice.h"
#include "soil/ground_coverage.h"
#include "stage_bench.h"

namespace bsoil::ground_bodies_test {
namespace {

using namespace layout;

constexpr double kVoxel = 0.05;

std::vector<int64_t> units_of(const Soil& soil) { return soil.totals().units; }

Mover box_at(int id, Vec3 low, Vec3 high, bool is_static = true) {
    return {id, box_shape((high - low) * (kVoxel / 2)), (low + high) * (kVoxel / 2), is_static};
}

/// 48 x 32 x 24 voxels, soil up to 10.
std::unique_ptr<Soil> make_bed() {
    auto soil = make_soil(grid_def(48, 32, 24));
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 32, 10})));
    return soil;
}

/// Until nothing moves any more, for 400 steps at most.
StepReport settle(Soil& soil, const std::vector<Mover>& movers) {
    StepReport report;
    for (int i = 0; i < 400; ++i) {
        report = soil.step(bodies_of(movers));
        if (i > 5 && report.block_active_count == 0) break;
    }
    EXPECT_EQ(report.block_active_count, 0);
    return report;
}

ConvexShape lattice_shape() {
    LatticeDef def;
    def.voxel_m = kVoxel;
    const auto ring = [](Vec3 p) {
        const double across = std::hypot(p.x, p.y) - 3.6 * kVoxel;
        return std::hypot(across, p.z) - 1.7 * kVoxel;
    };
    const double reach = 5.5 * kVoxel;
    const auto made = DistanceLattice::from_distance(
        ring, {{-reach, -reach, -reach}, {reach, reach, reach}}, def);
    EXPECT_TRUE(made) << made.error();
    ConvexShape shape;
    shape.kind = ConvexShape::Kind::lattice;
    shape.lattice = *made;
    return shape;
}

TEST(GroundBodies, cover_voxels_as_moving_bodies_do) {
    using Kind = ConvexShape::Kind;
    ConvexShape rounded = box_shape(Vec3{3.8, 2.1, 2.7} * kVoxel);
    rounded.rounding_m = 0.5 * kVoxel;
    const std::vector<ConvexShape> shapes = {
        box_shape(Vec3{4.3, 2.6, 3.2} * kVoxel),
        sphere_shape(4.4 * kVoxel),
        round_shape(Kind::capsule, 2.7 * kVoxel, 2.4 * kVoxel),
        round_shape(Kind::cylinder, 3.6 * kVoxel, 2.9 * kVoxel),
        round_shape(Kind::cone, 4.2 * kVoxel, 3.4 * kVoxel),
        octahedron_shape(5.5 * kVoxel),
        rounded,
        lattice_shape(),
    };
    StageBench bench(grid_def(16, 16, 16));
    for (const ConvexShape& shape : shapes) {
        std::vector<Mover> movers;
        movers.emplace_back(0, shape, Vec3{8.3, 7.9, 8.1} * kVoxel);
        movers[0].body.pose.rotation = turn(Vec3{2, -1, 2} * (1.0 / 3), 0.7);
        movers[0].shapes[0].local.position = Vec3{0.3, -0.2, 0.1} * kVoxel;
        bench.write(bench.empty_planes());
        bench.place(movers);
        const StatePlanes planes = bench.read();
        double covered = 0;
        for (int tile = 0; tile < 4; ++tile) {
            const TilePlace place{tile % 2 * 8, tile / 2 * 8, 16};
            std::vector<int32_t> units(static_cast<size_t>(64 * place.height));
            add_coverage(movers[0].shapes[0], movers[0].body.pose, kVoxel, place, units);
            for (int v = 0; v < 64 * place.height; ++v) {
                const int on_device =
                    planes.at(kPlaneCoverage, place.x0 + v % 8, place.y0 + v / 8 % 8, v / 64);
                // The kernel reckons in floats: a sub-cell counts 1024 units, a distance is good
                // to some 1e-5 voxels.
                ASSERT_NEAR(units[static_cast<size_t>(v)], on_device, 8)
                    << "shape " << &shape - shapes.data() << " voxel " << v << " tile " << tile;
                covered += on_device;
            }
        }
        EXPECT_GT(covered, 50.0 * kVoxelFull);
    }
}

TEST(GroundBodies, buried_soil_comes_back_bit_for_bit_when_the_body_goes) {
    auto soil = make_bed();
    const std::vector<int64_t> units = units_of(*soil);
    const uint64_t checksum = soil->checksum();
    std::vector<Mover> movers;
    movers.emplace_back(1, sphere_shape(4.3 * kVoxel), Vec3{20.2, 16.7, 6.1} * kVoxel, true);
    movers.emplace_back(2, octahedron_shape(5 * kVoxel), Vec3{24, 16, 5} * kVoxel, true);
    for (int i = 0; i < 3; ++i) {
        const StepReport report = soil->step(bodies_of(movers));
        EXPECT_EQ(report.tile_awake_count, 0);
        EXPECT_EQ(report.status_bits, 0u);
    }
    EXPECT_EQ(units_of(*soil), units);
    EXPECT_EQ(soil->sample(20, 16, 6).volume, 0);
    EXPECT_EQ(soil->sample(20, 16, 6).coverage, 1);
    EXPECT_NE(soil->checksum(), checksum);
    soil->step({&movers[1].body, 1});
    EXPECT_EQ(units_of(*soil), units);
    soil->step({});
    EXPECT_EQ(soil->checksum(), checksum);
    EXPECT_EQ(soil->step({}).block_active_count, 0);
}

TEST(GroundBodies, fill_before_and_after_a_body_is_the_same_soil) {
    std::vector<Mover> movers;
    movers.push_back(box_at(1, {-9, -9, -5}, {60, 60, 3.4}));
    movers.emplace_back(2, sphere_shape(4.3 * kVoxel), Vec3{20.2, 16.7, 6.1} * kVoxel, true);
    auto before = make_bed();
    before->step(bodies_of(movers));
    auto after = make_soil(grid_def(48, 32, 24));
    after->step(bodies_of(movers));
    ASSERT_TRUE(after->fill(voxel_box(*after, {0, 0, 0}, {48, 32, 10})));
    for (int x = 0; x < 48; ++x) {
        for (int y = 0; y < 32; ++y) {
            for (int z = 0; z < 24; ++z) {
                ASSERT_EQ(before->sample(x, y, z).volume, after->sample(x, y, z).volume)
                    << x << " " << y << " " << z;
            }
        }
    }
    EXPECT_GT(units_of(*before)[0], units_of(*after)[0]);
}

class GroundHeight : public testing::TestWithParam<double> {};

TEST_P(GroundHeight, wakes_no_tile_and_takes_no_memory_of_awake_ones) {
    auto soil = make_soil(grid_def(96, 96, 16));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {96, 96, 10})));
    const int64_t bytes = soil->memory_use().awake_bytes;
    std::vector<Mover> movers;
    movers.push_back(box_at(1, {-9, -9, -9}, {99, 99, GetParam()}));
    for (int i = 0; i < 40; ++i) {
        const StepReport report = soil->step(bodies_of(movers));
        ASSERT_EQ(report.tile_awake_count, 0);
        ASSERT_EQ(report.block_active_count, 0);
    }
    EXPECT_EQ(soil->memory_use().awake_bytes, bytes);
    EXPECT_NEAR(soil->surface_height_m(40, 40), 10 * kVoxel, 1e-9);
    // One that moves wakes what it would without ground.
    movers.emplace_back(2, sphere_shape(3 * kVoxel), Vec3{44, 44, 12} * kVoxel);
    auto bare = make_soil(grid_def(96, 96, 16));
    ASSERT_TRUE(bare->fill(voxel_box(*bare, {0, 0, 0}, {96, 96, 10})));
    const int awake = bare->step({&movers[1].body, 1}).tile_awake_count;
    EXPECT_GT(awake, 0);
    EXPECT_EQ(soil->step(bodies_of(movers)).tile_awake_count, awake);
}

TEST_P(GroundHeight, carries_soil_that_slides_onto_it_and_lets_it_rest) {
    auto soil = make_soil(grid_def(48, 32, 24));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {16, 8, 0}, {32, 24, 14})));
    const std::vector<int64_t> units = units_of(*soil);
    std::vector<Mover> movers;
    movers.push_back(box_at(1, {-9, -9, -9}, {60, 60, GetParam()}));
    settle(*soil, movers);
    EXPECT_EQ(units_of(*soil), units);
    EXPECT_GT(soil->surface_height_m(13, 16), std::max(0.0, GetParam()) * kVoxel);
}

INSTANTIATE_TEST_SUITE_P(Voxels, GroundHeight, testing::Values(-3, 0, 0.02, 0.4, 1, 2.6, 5.5),
                         [](const auto& parameter) {
                             std::string name = std::to_string(parameter.param);
                             std::replace(name.begin(), name.end(), '.', '_');
                             std::replace(name.begin(), name.end(), '-', 'm');
                             return name;
                         });

// What the free surface is must not depend on whether somebody has woken a tile.
TEST(GroundBodies, surface_of_a_tile_asleep_is_that_of_it_awake) {
    auto soil = make_bed();
    std::vector<Mover> movers;
    movers.push_back(box_at(1, {-9, -9, -5}, {60, 60, 2.6}));
    movers.push_back(box_at(2, {3, 3, 2}, {9, 9, 13.3}));       // a wall
    movers.push_back(box_at(3, {12, 2, 14}, {22, 12, 16}));     // a roof
    movers.push_back(box_at(4, {26, 4, 10.7}, {36, 9, 12.9}));  // hardly above the soil
    movers.emplace_back(5, sphere_shape(4.3 * kVoxel), Vec3{30, 22, 8} * kVoxel, true);
    soil->step(bodies_of(movers));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {12, 2, 16}, {18, 12, 16.4})));
    Soil::Impl& impl = SoilProbe::impl(*soil);
    std::vector<int32_t> asleep, awake;
    const auto surfaces = [&](std::vector<int32_t>& out) {
        for (size_t index = 0; index < impl.tiles.size(); ++index) {
            std::vector<int32_t> words(kTileColumns);
            if (const int slot = impl.tiles[index]->slot; slot >= 0) {
                impl.device->read(Buffer::spans,
                                  impl.tiles.column_array_offset(kColumnSurface, slot), words);
            } else {
                const auto kept = impl.contacts.surface().of_ground(static_cast<int>(index));
                words.assign(kept.begin(), kept.end());
            }
            out.insert(out.end(), words.begin(), words.end());
        }
    };
    surfaces(asleep);
    for (size_t index = 0; index < impl.tiles.size(); ++index) {
        impl.tiles.wake(static_cast<int>(index));
    }
    ++impl.step_index;  // as if they woke in the next step
    for (int slot = 0; slot < impl.tiles.slot_count(); ++slot) impl.tiles.look_anew(slot);
    --impl.step_index;
    soil->step(bodies_of(movers));
    surfaces(awake);
    EXPECT_EQ(asleep, awake);
    const auto word_at = [&](int x, int y) {
        return asleep[static_cast<size_t>(impl.tile_index(x / 8, y / 8)) * 64 +
                      static_cast<size_t>(y % 8 * 8 + x % 8)];
    };
    EXPECT_EQ(word_at(40, 20), 10 * kVoxelFull);
    EXPECT_NEAR(kTerrainTop - word_at(6, 6), 13.3 * kVoxelFull, 1);
    EXPECT_EQ(word_at(20, 8), 10 * kVoxelFull);
    EXPECT_NEAR(word_at(14, 8), 16.4 * kVoxelFull, 1);
    EXPECT_NEAR(kTerrainTop - word_at(30, 6), 12.9 * kVoxelFull, 1);
}

TEST(GroundBodies, roof_is_no_ground_surface_but_soil_on_it_is) {
    auto soil = make_bed();
    std::vector<Mover> movers;
    movers.push_back(box_at(1, {16, 8, 14}, {32, 24, 16}));
    soil->step(bodies_of(movers));
    EXPECT_NEAR(soil->surface_height_m(24, 16), 10 * kVoxel, 1e-9);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {22, 14, 16}, {26, 18, 18})));
    const std::vector<int64_t> units = units_of(*soil);
    settle(*soil, movers);
    EXPECT_GT(soil->surface_height_m(24, 16), 16.5 * kVoxel);
    EXPECT_NEAR(soil->surface_height_m(17, 9), 10 * kVoxel, 1e-9);
    settle(*soil, {});  // the roof goes
    EXPECT_LT(soil->surface_height_m(24, 16), 13 * kVoxel);
    EXPECT_GT(soil->surface_height_m(24, 16), 10.5 * kVoxel);
    EXPECT_EQ(units_of(*soil), units);
}

// What hills become over a floor is remembered for each tile; what the floor covers of a tile, 16
// kB, once. 2500 tiles would take 41 MB.
TEST(GroundBodies, under_hills_are_remembered_once) {
    auto soil = make_soil(grid_def(400, 400, 64));
    NoiseFill hills;
    hills.base_m = 1;
    hills.amplitude_m = 0.3;
    hills.wavelength_m = 8;
    ASSERT_TRUE(soil->fill(hills));
    const auto most_kb = [] {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        return usage.ru_maxrss;
    };
    const long before_kb = most_kb();
    std::vector<Mover> floor;
    floor.push_back(box_at(1, {-9, -9, -9}, {409, 409, 0.5}));
    const auto report = soil->settle(0, bodies_of(floor));
    ASSERT_TRUE(report) << report.error();
    EXPECT_LT(most_kb() - before_kb, 20000);
    EXPECT_NEAR(soil->sample(200, 200, 0).volume, 0.5, 1e-3) << "the floor is there";
}

// As hosts do that have a lift of a static body: it pushes while it moves and is ground where it
// stops.
TEST(GroundBodies, static_lift_raises_soil_and_becomes_ground_again) {
    auto soil = make_bed();
    const std::vector<int64_t> units = units_of(*soil);
    std::vector<Mover> movers;
    movers.push_back(box_at(1, {16, 8, 1}, {32, 24, 4}));
    soil->step(bodies_of(movers));
    EXPECT_TRUE(SoilProbe::impl(*soil).bodies.tracks().at(1).is_ground);
    for (int i = 0; i < 60; ++i) {
        movers[0].body.pose.position.z += 0.05 * kVoxel;
        soil->step(bodies_of(movers));
        ASSERT_EQ(units_of(*soil), units) << i;
    }
    EXPECT_FALSE(SoilProbe::impl(*soil).bodies.tracks().at(1).is_ground);
    const StepReport report = settle(*soil, movers);
    for (int i = 0; i < 40; ++i) soil->step(bodies_of(movers));
    EXPECT_TRUE(SoilProbe::impl(*soil).bodies.tracks().at(1).is_ground);
    EXPECT_EQ(soil->step(bodies_of(movers)).block_active_count, 0);
    EXPECT_EQ(report.status_bits, 0u);
    EXPECT_EQ(units_of(*soil), units);
    EXPECT_GT(soil->surface_height_m(24, 16), 11.5 * kVoxel);
}

TEST(GroundBodies, soil_falls_into_the_room_of_a_body_that_goes) {
    auto soil = make_soil(grid_def(48, 32, 24));
    std::vector<Mover> movers;
    movers.push_back(box_at(1, {8, 8, 0}, {40, 24, 6}));
    soil->step(bodies_of(movers));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {48, 32, 10})));
    const std::vector<int64_t> units = units_of(*soil);
    EXPECT_EQ(soil->step(bodies_of(movers)).tile_awake_count, 0);
    settle(*soil, {});
    EXPECT_LT(soil->surface_height_m(24, 16), 8.5 * kVoxel);
    EXPECT_EQ(units_of(*soil), units);
}

TEST(GroundBodies, settle_knows_that_what_was_filled_rests_on_them) {
    auto soil = make_soil(grid_def(48, 32, 24));
    std::vector<Mover> movers;
    movers.push_back(box_at(1, {-9, -9, -5}, {60, 60, 5.6}));
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 6}, {48, 32, 10})));
    auto settled = soil->settle(0, bodies_of(movers));
    ASSERT_TRUE(settled) << settled.error();
    EXPECT_TRUE(settled->is_at_rest);
    EXPECT_EQ(settled->tile_awake_count, 0);
    EXPECT_EQ(soil->step(bodies_of(movers)).block_active_count, 0);
    soil->step({});  // they go, and it falls
    settled = soil->settle(200);
    ASSERT_TRUE(settled) << settled.error();
    EXPECT_TRUE(settled->is_at_rest);
    EXPECT_LT(soil->surface_height_m(24, 16), 4.5 * kVoxel);
}

TEST(GroundBodies, level_ground_under_level_soil_is_kept_once) {
    const auto asleep_bytes = [](int side) {
        auto soil = make_soil(grid_def(side, side, 24));
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {1.0 * side, 1.0 * side, 10})));
        std::vector<Mover> movers;
        movers.push_back(box_at(1, {-9, -9, -5}, {500, 500, 5.3}));
        EXPECT_EQ(soil->step(bodies_of(movers)).tile_awake_count, 0);
        EXPECT_NEAR(soil->sample(side / 2, side / 2, 5).volume, 0.7, 1e-4);
        return soil->memory_use().asleep_bytes;
    };
    const int64_t tiles = 30 * 30 - 10 * 10;
    EXPECT_EQ(asleep_bytes(240) - asleep_bytes(80), tiles * static_cast<int64_t>(sizeof(Tile)));
}

TEST(GroundBodies, terrain_added_later_buries_no_soil_that_a_body_has_buried) {
    auto soil = make_bed();
    std::vector<Mover> movers;
    movers.push_back(box_at(1, {8, 8, 0}, {40, 24, 6}));
    soil->step(bodies_of(movers));
    const uint64_t checksum = soil->checksum();
    EXPECT_FALSE(soil->add_terrain([](Vec3 at) { return 3 * kVoxel - at.z; }));
    EXPECT_EQ(soil->checksum(), checksum);
    EXPECT_TRUE(soil->add_terrain([](Vec3 at) { return at.z - 12 * kVoxel; }));
    soil->step(bodies_of(movers));
    soil->step({});
    EXPECT_EQ(soil->sample(24, 16, 2).volume, 1);
    EXPECT_EQ(soil->sample(24, 16, 2).coverage, 0);
    EXPECT_EQ(soil->sample(24, 16, 14).coverage, 1);
}

/// A blade over rocks and an uneven slab, one of the rocks going and one coming on the way.
class Yard {
  public:
    explicit Yard(const SoilDef& def) : soil(make_soil(def)) {
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {30, 32, 9})));
        movers.push_back(box_at(1, {-9, -9, -5}, {60, 60, 2.6}));
        for (int i = 0; i < 12; ++i) {
            movers.emplace_back(2 + i, sphere_shape((1.5 + 0.2 * i) * kVoxel),
                                Vec3{4.0 + 3.1 * i, 4.0 + i * 7 % 24, 3 + 0.4 * (i % 5)} * kVoxel,
                                true);
        }
        movers.push_back(box_at(20, {3, 9, 5}, {5, 23, 12}, false));
        movers.back().set_velocity({0.9, 0, 0});
    }
    StepReport step() {
        movers.back().advance(1.0 / 60);
        std::vector<SoilBody> bodies = bodies_of(movers);
        if (count > 20 && count < 60) bodies.erase(bodies.begin() + 5);
        ++count;
        return soil->step(bodies);
    }
    static SoilDef def() { return grid_def(56, 32, 24); }

    std::unique_ptr<Soil> soil;
    std::vector<Mover> movers;
    int count = 0;
};

TEST(GroundBodies, give_the_same_bits_on_threads_and_on_gl) {
    const auto run = [](SoilDef def, int steps) {
        Yard yard(def);
        std::vector<uint64_t> checksums;
        for (int i = 0; i < steps; ++i) {
            yard.step();
            if (i % 10 == 9) checksums.push_back(yard.soil->checksum());
        }
        return checksums;
    };
    SoilDef def = Yard::def();
    const std::vector<uint64_t> once = run(def, 80);
    def.thread_count = 3;
    EXPECT_EQ(run(def, 80), once);
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    def.backend = Backend::gl;
    EXPECT_EQ(run(def, 40), std::vector<uint64_t>(once.begin(), once.begin() + 4));
}

TEST(GroundBodies, a_loaded_soil_goes_on_over_them_like_the_saved_one) {
    for (const int saved_at : {1, 15, 21, 30}) {
        Yard first(Yard::def()), second(Yard::def());
        for (int i = 0; i < saved_at; ++i) first.step();
        second.soil = make_soil(Yard::def());
        const auto put = second.soil->prepare(first.soil->state());
        ASSERT_TRUE(put) << put.error();
        (*put)();
        EXPECT_EQ(second.soil->checksum(), first.soil->checksum());
        for (; second.count < saved_at; ++second.count) second.movers.back().advance(1.0 / 60);
        for (int i = 0; i < 50; ++i) {
            first.step();
            second.step();
            ASSERT_EQ(second.soil->checksum(), first.soil->checksum())
                << "saved at " << saved_at << ", step " << i + 1 << " after";
        }
        EXPECT_EQ(units_of(*second.soil), units_of(*first.soil));
    }
}

TEST(GroundBodies, a_snapshot_of_them_without_them_gives_the_soil_free) {
    auto soil = make_bed();
    const uint64_t checksum = soil->checksum();
    std::vector<Mover> movers;
    movers.emplace_back(1, sphere_shape(4.3 * kVoxel), Vec3{20.2, 16.7, 6.1} * kVoxel, true);
    soil->step(bodies_of(movers));
    auto other = make_soil(grid_def(48, 32, 24));
    const auto put = other->prepare(soil->state());
    ASSERT_TRUE(put) << put.error();
    (*put)();
    other->step({});
    EXPECT_EQ(other->checksum(), checksum);
}

}  // namespace
}  // namespace bsoil::ground_bodies_test
