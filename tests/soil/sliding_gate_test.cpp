// A gate that slides aside under a full silo: docs/decisions/silo_walls.md.
#include <algorithm>
#include <cmath>

#include "oracle/contacts.h"
#include "oracle/held_load.h"
#include "oracle/projectile.h"
#include "stage_bench.h"

namespace bsoil::sliding_gate_test {
namespace {

constexpr double kWidth = 0.5, kFill = 1.0, kFriction = 0.4, kGateTop = 0.6, kDensity = 1600;
constexpr double kGravity = 9.81, kWallTop = kGateTop + kFill + 0.2, kWall = 0.12;
constexpr double kWay = 0.65;  // until nothing of the gate is under the sand
constexpr int kGateId = 3, kWallId = 7;

struct Plan {
    int voxels = 10;  ///< to the silo's width
    double speed_m_s = 0.2;
    bool has_static_walls = false;
    Backend backend = Backend::cpu;
    int threads = 0;
};

/// A square silo of 0.5 m, two widths full, on a gate 0.6 m above the ground that slides along x.
struct Silo {
    Plan plan;
    double voxel_m, middle_x_m, middle_y_m, gone_m = 0;
    std::vector<Mover> bodies;
    std::unique_ptr<Soil> soil;
    StepReport report;

    explicit Silo(const Plan& of) : plan(of), voxel_m(kWidth / of.voxels) {
        const auto tiles = [&](double m) {
            return 8 * static_cast<int>(std::ceil(m / voxel_m / 8));
        };
        SoilDef def = grid_def(tiles(2.2), tiles(1.6), tiles(kWallTop + 0.2), voxel_m);
        def.material = fixed_density(sand(30));
        def.material.density_kg_m3 = kDensity;
        def.material.tool_friction = kFriction;
        def.backend = plan.backend;
        def.thread_count = plan.threads;
        soil = make_soil(def);
        middle_x_m = 0.8;
        middle_y_m = 0.8;
        bodies.emplace_back(kGateId, box_shape({0.4, 0.4, 0.06}),
                            Vec3{middle_x_m, middle_y_m, kGateTop - 0.06});
        const double half_m = (kWallTop - kGateTop) / 2, off_m = (kWidth + kWall) / 2;
        std::vector<ConvexShape> plates;
        for (const double side : {-1.0, 1.0}) {  // each from a corner to beyond the next
            ConvexShape along = box_shape({kWall / 2, off_m, half_m});
            along.local.position = {side * off_m, side * kWall / 2, 0};
            ConvexShape across = box_shape({off_m, kWall / 2, half_m});
            across.local.position = {-side * kWall / 2, side * off_m, 0};
            plates.push_back(along);
            plates.push_back(across);
        }
        Mover& wall = bodies.emplace_back(kWallId, plates.front(),
                                          Vec3{middle_x_m, middle_y_m, kGateTop + half_m},
                                          plan.has_static_walls);
        wall.shapes = plates;
        wall.body.shapes = &wall.shapes;
        soil->step(bodies_of(bodies));  // ground bodies have to be there before the soil
        EXPECT_TRUE(soil->fill(
            BoxFill{{{middle_x_m - kWidth / 2, middle_y_m - kWidth / 2, kGateTop},
                     {middle_x_m + kWidth / 2, middle_y_m + kWidth / 2, kGateTop + kFill}},
                    {}}));
        for (int i = 0; i < 8; ++i) report = soil->step(bodies_of(bodies));
    }

    /// The gate goes on, or stands where it has come out.
    void step() {
        const double speed_m_s = gone_m < kWay ? plan.speed_m_s : 0;
        bodies.front().set_velocity({speed_m_s, 0, 0});
        bodies.front().advance(soil->def().step_s);
        gone_m += speed_m_s * soil->def().step_s;
        report = soil->step(bodies_of(bodies));
    }
    double mass_between(Vec3 low, Vec3 high) const {
        Pose pose;
        pose.position = 0.5 * (low + high);
        return soil->mass_inside_kg(box_shape(0.5 * (high - low)), pose);
    }
    double mass_below_kg() const { return mass_between({0, 0, 0}, {9, 9, kGateTop - 0.12}); }
    /// Higher than the sand stood, by a voxel, wherever.
    double mass_above_kg() const {
        return mass_between({0, 0, kGateTop + kFill + voxel_m}, {9, 9, 9});
    }
    BodyLoad gate_load() const {
        for (const BodyLoad& load : report.loads) {
            if (load.body == kGateId) return load;
        }
        return {};
    }
};

/// As docs/decisions/silo_walls.md has the criterion.
void expect_gate_slips_under_the_sand(const Plan& plan) {
    Silo silo(plan);
    const SoilTotals start = silo.soil->totals();
    const double mass_kg = start.mass_kg[0], step_s = silo.soil->def().step_s;
    double above_kg = 0, drag_over = 0, carried_kg = silo.gate_load().mass_kg;
    uint32_t status = 0;
    const int steps = static_cast<int>(std::lround((kWay / plan.speed_m_s + 2) / step_s));
    for (int i = 0; i < steps; ++i) {
        silo.step();
        status |= silo.report.status_bits;
        above_kg = std::max(above_kg, silo.mass_above_kg());
        const BodyLoad load = silo.gate_load();
        const double most = kFriction * kGravity * step_s * std::max(load.mass_kg, carried_kg);
        if (most > 0) drag_over = std::max(drag_over, load.impulse_n_s.x / most);
        carried_kg = load.mass_kg;
    }
    const auto record = [&](const char* what, double value) {
        testing::Test::RecordProperty(std::string(what) + "_" + std::to_string(plan.voxels) + "_" +
                                          (plan.speed_m_s < 0.5 ? "slow" : "fast") +
                                          (plan.has_static_walls ? "_static" : ""),
                                      std::to_string(value));
    };
    record("risen", above_kg / mass_kg);
    record("drag", drag_over);
    record("below", silo.mass_below_kg() / mass_kg);
    EXPECT_EQ(status, 0u);
    EXPECT_EQ(silo.soil->totals().units, start.units);
    EXPECT_LT(above_kg, 1e-3 * mass_kg);
    EXPECT_LT(drag_over, 1.02);  // momentum is rounded by voxel
    EXPECT_GT(silo.mass_below_kg(), 0.95 * mass_kg);
}

TEST(SlidingGate, slips_under_the_sand_of_a_full_silo) {
    for (const double speed_m_s : {0.2, 1.0}) {
        for (const bool has_static_walls : {false, true}) {
            expect_gate_slips_under_the_sand({10, speed_m_s, has_static_walls});
        }
    }
}

TEST(SlowSlidingGate, slips_under_the_sand_in_a_finer_grid) {
    for (const double speed_m_s : {0.2, 1.0}) expect_gate_slips_under_the_sand({20, speed_m_s});
}

TEST(SlidingGate, has_the_same_bits_on_threads_and_on_gl) {
    constexpr int kSteps = 50;
    const auto sums = [](Backend backend, int threads) {
        Silo silo({10, 1, false, backend, threads});
        std::vector<uint64_t> out;
        for (int i = 0; i < kSteps; ++i) {
            silo.step();
            if (i % 10 == 9) out.push_back(silo.soil->checksum());
        }
        return out;
    };
    const auto one = sums(Backend::cpu, 1);
    EXPECT_EQ(sums(Backend::cpu, 3), one);
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    EXPECT_EQ(sums(Backend::gl, 0), one);
}

// --- the rule itself, against the oracle

constexpr int kSide = 24, kLow = 6, kHigh = 15;  // soil lies in voxels kLow..kHigh along x and y
constexpr int kBottom = 4, kTop = 9;
constexpr Vec3 kPlateMiddle{12, 12, 2};

/// A block of soil on a plate that moves, with a heap on it.
struct Block {
    StageBench bench;
    StatePlanes planes;
    std::vector<Mover> bodies;

    explicit Block(Backend backend, Vec3 velocity_m_s) : bench(def_on(backend)) {
        planes = bench.empty_planes();
        for (int z = kBottom; z <= kTop + 2; ++z) {
            const int in = z <= kTop ? 0 : z - kTop + 1;
            for (int y = kLow + in; y <= kHigh - in; ++y) {
                for (int x = kLow + in; x <= kHigh - in; ++x) put(x, y, z, layout::kVoxelFull);
            }
        }
        add(0, kPlateMiddle, {11, 11, 2}, velocity_m_s);
    }
    static SoilDef def_on(Backend backend) {
        SoilDef def = grid_def(kSide, kSide, 16);
        def.material = fixed_density(sand(30));
        def.material.tool_friction = kFriction;
        def.backend = backend;
        return def;
    }
    void put(int x, int y, int z, int volume) {
        const int mass = 3 * volume / 2;
        planes.at(layout::kPlaneVolume, x, y, z) = volume;
        planes.at(layout::kPlaneMaterial, x, y, z) = mass;
        planes.at(layout::kPlaneMomentumX, x, y, z) = mass * ((x + 2 * y + z) % 5 - 2) * 8;
        planes.at(layout::kPlaneMomentumY, x, y, z) = mass * ((2 * x + y + z) % 7 - 3) * 8;
    }
    /// A box by its middle and half its extents, voxels.
    Mover& add(int id, Vec3 middle, Vec3 half, Vec3 velocity_m_s) {
        Mover& body = bodies.emplace_back(id, box_shape(0.05 * half), 0.05 * middle);
        body.set_velocity(velocity_m_s);
        return body;
    }
    /// Plates along the four sides of the soil, up to a height: of a body at `middle`.
    static std::vector<ConvexShape> plates(Vec3 middle, double top) {
        const double side = (kLow + kHigh + 1) / 2.0, off = (kHigh + 1 - kLow) / 2.0 + 1;
        std::vector<ConvexShape> out;
        for (const Vec3 way : {Vec3{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}}) {
            const double half_x = way.x != 0 ? 1 : off, half_y = way.x != 0 ? off : 1;
            ConvexShape plate = box_shape(0.05 * Vec3{half_x, half_y, (top - kBottom) / 2});
            const Vec3 at{side + off * way.x, side + off * way.y, (top + kBottom) / 2};
            plate.local.position = 0.05 * (at - middle);
            out.push_back(plate);
        }
        return out;
    }
    void add_walls(double top, Vec3 velocity_m_s) {
        constexpr Vec3 kMiddle{11, 11, 8};
        Mover& walls = add(1, kMiddle, {1, 1, 1}, velocity_m_s);
        walls.shapes = plates(kMiddle, top);
        walls.body.shapes = &walls.shapes;
    }
    void place() {
        bench.write(planes);
        bench.place(bodies);
        bench.find_support();
    }
    /// How many voxels of the block the oracle holds back along x.
    int expect_oracle() {
        place();
        const oracle::Field before = bench.to_field(bench.read());
        const oracle::Model model = bench.model();
        const std::vector<oracle::Body> carriers = bench.oracle_bodies();
        const oracle::Field expected = oracle::advect(model, before, carriers);
        bench.advect(1);
        const FieldDeviation deviation = compare(bench.to_field(bench.read()), expected, 1);
        // As Projectile.advection_follows_the_oracle.
        constexpr double kTolerance = 6.0 * 33 / layout::kVoxelFull;
        EXPECT_LT(deviation.soil.value, kTolerance) << deviation.soil;
        EXPECT_LT(deviation.mass.value, kTolerance) << deviation.mass;
        EXPECT_LT(deviation.momentum.value, kTolerance) << deviation.momentum;
        int held_count = 0;
        const Vec3 fast{0.5, 0, 0};
        before.for_each([&](int x, int y, int z) {
            if (before.at(x, y, z).support.kind != oracle::Support::Kind::body) return;
            const Vec3 left = oracle::held_back(model, before, carriers, x, y, z, fast);
            held_count += left.x < fast.x;
        });
        return held_count;
    }
};

constexpr int kSoilVoxels = 600 + 36 + 16;
constexpr Vec3 kAskew{0.9, 0.6, 0};  // 0.3 and 0.2 voxels a step

TEST(HeldLoad, goes_where_nothing_stands_before_it) {
    EXPECT_EQ(Block(Backend::cpu, kAskew).expect_oracle(), 0);
}

TEST(HeldLoad, is_held_by_walls_with_all_that_lies_on_it) {
    for (const double top : {10.0, 6.0}) {  // low walls hold what is above them as well
        Block block(Backend::cpu, kAskew);
        block.add_walls(top, {});
        EXPECT_EQ(block.expect_oracle(), kSoilVoxels);
    }
}

TEST(HeldLoad, is_as_fast_as_walls_that_go_away) {
    Block block(Backend::cpu, kAskew);
    block.add_walls(10, {0.03, 0.9, 0});
    EXPECT_EQ(block.expect_oracle(), kSoilVoxels);
}

TEST(HeldLoad, goes_with_walls_of_its_own_body) {
    Block block(Backend::cpu, kAskew);
    Mover& plate = block.bodies.front();
    for (const ConvexShape& wall : Block::plates(kPlateMiddle, 10)) plate.shapes.push_back(wall);
    plate.body.shapes = &plate.shapes;
    EXPECT_EQ(block.expect_oracle(), 0);
}

// Room for a quarter of a voxel in the column (12, 12) opens the rows behind it.
TEST(HeldLoad, goes_where_a_row_has_room) {
    Block block(Backend::cpu, kAskew);
    block.add_walls(10, {});
    for (int z = kBottom; z <= kTop; ++z) block.put(12, 12, z, layout::kVoxelFull * 3 / 4);
    constexpr int kBehind = 6 * 6 + 4 + 3;  // in six layers, and in the two above them
    EXPECT_EQ(block.expect_oracle(), kSoilVoxels - kBehind);
}

// What fills all between the walls goes where they go: a contact with it pushes neither. A column
// with room opens the rows through it, and the heap above has none.
TEST(HeldLoad, is_between_walls_that_it_fills) {
    for (const bool has_room : {false, true}) {
        Block block(Backend::cpu, kAskew);
        block.add_walls(10, {});
        for (int z = kBottom; has_room && z <= kTop; ++z) {
            block.put(12, 12, z, layout::kVoxelFull * 3 / 4);
        }
        block.place();
        const auto got = block.bench.collect_contacts();
        const std::vector<oracle::Contact> expected =
            oracle::find_contacts(block.bench.model(), block.bench.to_field(block.bench.read()),
                                  block.bench.oracle_bodies());
        ASSERT_EQ(got.size(), expected.size());
        int between_count = 0;
        for (size_t i = 0; i < got.size(); ++i) {
            const bool is_between =
                got[i][layout::kContactUndisturbed] >= layout::kContactBetweenWalls;
            EXPECT_EQ(is_between, expected[i].is_between_walls) << i;
            between_count += is_between;
        }
        // Two voxels deep in each of four walls, in the five layers above that next to the plate;
        // the voxel in a corner has one normal.
        constexpr int kLayers = 5, kInLayer = 2 * 4 * (kHigh - kLow + 1) - 4;
        EXPECT_EQ(between_count, kLayers * (has_room ? kInLayer - 2 * 4 : kInLayer));
    }
}

// A row of soil on a plate that takes it towards a wall at 5 cm/s, at 1000 Hz: that is 64 units of
// 1/65536 voxel a step, and what counts as still is 8 there, 0.6 cm/s as at 60 Hz. It was 128 in
// any step, and such soil went on.
TEST(HeldLoad, is_held_in_short_steps) {
    SoilDef def = grid_def(16, 8, 8);
    def.step_s = 1e-3;
    StageBench bench(def);
    StatePlanes planes = bench.empty_planes();
    const auto put = [&](int plane, int x, int y, int z) {
        planes.at(plane, x, y, z) = layout::kVoxelFull;
    };
    for (int y = 0; y < 8; ++y) {
        for (int x = 4; x < 10; ++x) {
            put(layout::kPlaneVolume, x, y, 2);
            put(layout::kPlaneMaterial, x, y, 2);
            put(layout::kPlaneMomentumX, x, y, 2);
        }
        for (int x = 10; x < 16; ++x) {
            for (int z = 0; z < 8; ++z) put(layout::kPlaneTerrain, x, y, z);
        }
    }
    bench.write(planes);
    std::vector<Mover> movers;
    movers.emplace_back(0, box_shape({0.5, 0.5, 0.05}), Vec3{0.4, 0.2, 0.05});
    movers[0].set_velocity({0.05, 0, 0});
    bench.place(movers);
    bench.find_support();
    EXPECT_EQ(bench.impl().params.still_speed, 8);
    ASSERT_EQ(bench.read().at(layout::kPlaneSupport, 4, 4, 2), layout::kSupportBody);
    bench.advect(1);
    const StatePlanes after = bench.read();
    for (int x = 4; x < 10; ++x) EXPECT_EQ(after.at(layout::kPlaneMomentumX, x, 4, 2), 0) << x;
}

TEST(HeldLoad, has_the_same_bits_on_gl) {
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    const auto advected = [](Backend backend) {
        Block block(backend, kAskew);
        block.add_walls(8, {0.03, 0, 0});
        block.put(12, 12, 5, layout::kVoxelFull * 3 / 4);
        block.place();
        block.bench.advect(2);
        return block.bench.read();
    };
    EXPECT_TRUE(advected(Backend::cpu) == advected(Backend::gl));
}

}  // namespace
}  // namespace bsoil::sliding_gate_test
