// Grids of any size: what lies beyond their sides is a wall, whether tiles of 8 x 8 columns end
// there or not.
#include <random>

#include "soil_fixture.h"

namespace bsoil::grid_edges_test {
namespace {

constexpr double kVoxel = 0.05;
constexpr int kSideMost = 17;  // two tiles and a column

/// Contacts of a step by what they add up to.
struct Touch {
    size_t count = 0;
    double area_m2 = 0, depth_m = 0;
};

Touch touch_of(const StepReport& report) {
    Touch sum;
    for (const ContactVoxel& contact : report.contacts) {
        ++sum.count;
        sum.area_m2 += contact.area_m2;
        sum.depth_m += contact.depth_m;
    }
    return sum;
}

bool all_in_grid(const StepReport& report, const GridFrame& frame) {
    return std::all_of(report.contacts.begin(), report.contacts.end(), [&](const auto& contact) {
        const Vec3 at = frame.to_grid(contact.center_m);
        return at.x > 0 && at.y > 0 && at.z > 0 && at.x < frame.size[0] && at.y < frame.size[1] &&
               at.z < frame.size[2];
    });
}

TEST(GridEdges, bodies_at_every_flank_have_their_contacts_in_the_grid) {
    for (int nx = 1; nx <= kSideMost; ++nx) {
        const int ny = kSideMost + 1 - nx;
        auto soil = make_soil(grid_def(nx, ny, 9));
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {1.0 * nx, 1.0 * ny, 5})));
        const std::vector<int64_t> units = soil->totals().units;
        std::vector<Mover> movers;
        const Vec3 middle{nx / 2.0, ny / 2.0, 4};
        const Vec3 half{1.3, 1.3, 2.4};
        const Vec3 sides[4] = {{-0.9, middle.y, 4},
                               {nx + 0.9, middle.y, 4},
                               {middle.x, -0.9, 4},
                               {middle.x, ny + 0.9, 4}};
        for (int i = 0; i < 4; ++i) {
            movers.emplace_back(i, box_shape(half * kVoxel), sides[i] * kVoxel);
            const Vec3 inwards = middle - sides[i];
            movers.back().set_velocity(inwards * (0.2 / length(inwards)));
        }
        size_t contacts = 0;
        for (int step = 0; step < 20; ++step) {
            for (Mover& mover : movers) mover.advance(1.0 / 60);
            const StepReport report = soil->step(bodies_of(movers));
            EXPECT_TRUE(all_in_grid(report, soil->frame())) << nx << " x " << ny;
            contacts += report.contacts.size();
        }
        if (nx > 4 && ny > 4) {
            EXPECT_GT(contacts, 0u) << nx << " x " << ny;
        }
        EXPECT_EQ(soil->totals().units, units) << nx << " x " << ny;
    }
}

// The same box pressed 2.3 voxels into each of the four flanks. With 13 columns three
// more fill up the last tiles, with 16 none do.
TEST(GridEdges, flanks_bear_alike_on_all_four_sides) {
    for (int side : {13, 16}) {
        std::vector<Touch> touches;
        const double middle = side / 2.0;
        for (const Vec3 at : {Vec3{0, middle, 3}, Vec3{1.0 * side, middle, 3}, Vec3{middle, 0, 3},
                              Vec3{middle, 1.0 * side, 3}}) {
            auto soil = make_soil(grid_def(side, side, 8));
            ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {1.0 * side, 1.0 * side, 6})));
            Mover box(0, box_shape(Vec3{2.3, 2.3, 2} * kVoxel), at * kVoxel);
            std::vector<SoilBody> bodies{box.body};
            soil->step(bodies);
            touches.push_back(touch_of(soil->step(bodies)));
        }
        ASSERT_GT(touches[0].count, 0u);
        for (const Touch& touch : touches) {
            EXPECT_EQ(touch.count, touches[0].count) << side;
            EXPECT_NEAR(touch.area_m2, touches[0].area_m2, 1e-9) << side;  // doubles' rounding
            // Heights of columns are whole numbers of their last digit.
            EXPECT_NEAR(touch.depth_m, touches[0].depth_m, 1e-4 * touches[0].depth_m) << side;
        }
    }
}

TEST(GridEdges, a_body_beside_the_grid_touches_nothing) {
    for (int side : {1, 5, 12, 15}) {
        auto soil = make_soil(grid_def(side, side, 8));
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {1.0 * side, 1.0 * side, 6})));
        for (const Vec3 at : {Vec3{side + 1.0, side / 2.0, 3}, Vec3{side / 2.0, side + 1.0, 3}}) {
            Mover box(0, box_shape(Vec3{1, 1, 2} * kVoxel), at * kVoxel);
            std::vector<SoilBody> bodies{box.body};
            EXPECT_EQ(touch_of(soil->step(bodies)).count, 0u) << side;
        }
    }
}

TEST(GridEdges, level_soil_sleeps_in_a_grid_of_any_size) {
    for (int nx = 1; nx <= kSideMost; ++nx) {
        auto soil = make_soil(grid_def(nx, kSideMost + 1 - nx, nx));
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {20, 20, 0.7 * nx})));
        const StepReport report = soil->step({});
        EXPECT_EQ(report.block_active_count, 0) << nx;
        EXPECT_EQ(report.tile_awake_count, 0) << nx;
    }
}

TEST(GridEdges, a_grid_is_as_high_as_its_blocks) {
    for (int nz : {1, 7, 8, 9, 17}) {
        const auto soil = make_soil(grid_def(3, 3, nz));
        EXPECT_EQ(soil->frame().size[0], 3);
        EXPECT_EQ(soil->frame().size[2], (nz + 7) / 8 * 8);
        EXPECT_EQ(soil->voxels_total(), int64_t{9} * soil->frame().size[2]);
    }
}

TEST(GridEdges, far_from_the_origin_contacts_are_in_their_own_columns) {
    SoilDef def = grid_def(13, 13, 8);
    const Vec3 far{9.9e6, -9.9e6, 9.9e6};
    def.floor_center_m += far;
    auto soil = make_soil(def);
    const BoxFill near = voxel_box(*soil, {0, 0, 0}, {13, 13, 6});
    ASSERT_TRUE(soil->fill(BoxFill{{near.box.min + far, near.box.max + far}, {}}));
    Mover box(0, box_shape(Vec3{2.5, 2.5, 2} * kVoxel), Vec3{12, 6.5, 5} * kVoxel + far);
    std::vector<SoilBody> bodies{box.body};
    const StepReport report = soil->step(bodies);
    EXPECT_GT(touch_of(report).count, 0u);
    EXPECT_TRUE(all_in_grid(report, soil->frame()));
}

/// Columns that only fill up the last tile are rock, and no more than the grid's end all the same.
class FillUpColumns : public testing::TestWithParam<Backend> {
  protected:
    void SetUp() override {
        if (GetParam() == Backend::gl && !gl_missing().empty()) GTEST_SKIP() << gl_missing();
    }
    static SoilDef def_of(int nx, double voxel_m) {
        SoilDef def = grid_def(nx, 8, 24, voxel_m);
        def.backend = GetParam();
        return def;
    }
};

// Wind from where the grid ends 7 columns on. A lump is a voxel long, so that it has no lee itself.
TEST_P(FillUpColumns, have_no_lee) {
    const auto blown_to = [](int nx) {
        SoilDef def = def_of(nx, 0.1);
        def.material.fall_speed_m_s = 2;
        def.wind_m_s = {-3, 0, 0};
        def.shelter_m = 2;
        const auto soil = make_soil(def);
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {12, 3, 16}, {13, 6, 19})));
        for (int i = 0; i < 20; ++i) soil->step({});
        double moment = 0, volume = 0;
        for (int x = 0; x < nx; ++x) {
            for (int i = 0; i < 8 * 24; ++i) {
                const double here = soil->sample(x, i % 8, i / 8).volume;
                moment += here * (x + 0.5);
                volume += here;
            }
        }
        return moment / volume;
    };
    const double whole_tiles = blown_to(24);
    EXPECT_LT(whole_tiles, 10);                    // by hand: 5 voxels on from 12.5
    EXPECT_NEAR(blown_to(20), whole_tiles, 1e-6);  // nothing of it comes near either end
}

TEST_P(FillUpColumns, are_no_abutment_of_a_roof) {
    for (const int nx : {12, 16}) {
        SoilDef def = def_of(nx, kVoxel);
        def.material = sand(30, 5000);
        const auto soil = make_soil(def);
        ASSERT_TRUE(soil);
        const double end = nx;
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {end - 4, 8, 4})));
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 4}, {end, 8, 6})));
        ASSERT_TRUE(soil->settle(300));
        for (int x = nx - 3; x < nx; ++x) {
            EXPECT_GT(soil->sample(x, 4, 0).volume, 0.5) << x << " of " << nx;
        }
    }
}

TEST_P(FillUpColumns, are_no_terrain_beside_a_load) {
    const auto soil = make_soil(def_of(12, kVoxel));
    ASSERT_TRUE(soil);
    ASSERT_TRUE(soil->fill(voxel_box(*soil, {6, 2, 4}, {12, 6, 7})));
    std::vector<Mover> movers;
    movers.emplace_back(1, box_shape(Vec3{4, 4, 1} * kVoxel), Vec3{8, 4, 3} * kVoxel);
    StepReport report;
    for (int i = 0; i < 4; ++i) report = soil->step(bodies_of(movers));
    ASSERT_EQ(report.loads.size(), 1u);
    EXPECT_GT(report.loads[0].mass_kg, 0);
    const Soil::Impl& impl = SoilProbe::impl(*soil);
    const auto load = static_cast<size_t>(layout::kResultHeader +
                                          impl.bodies.tracks().at(1).index * layout::kLoadWords);
    EXPECT_EQ(impl.results.header()[load + layout::kLoadWalls], 0);
}

INSTANTIATE_TEST_SUITE_P(Backends, FillUpColumns, testing::Values(Backend::cpu, Backend::gl),
                         [](const auto& tested) {
                             return tested.param == Backend::cpu ? "cpu" : "gl";
                         });

/// A scene of any size: soils at random, bodies of all kinds that cross it, some from outside.
class RandomGrid {
  public:
    RandomGrid(unsigned seed, Backend backend, int threads) : random_(seed) {
        const int nx = side(), ny = side(), nz = side();
        SoilDef def = grid_def(nx, ny, nz, kVoxel);
        def.materials = {materials::dry_sand(), materials::clay()};
        def.up = pick(2) == 0 ? UpAxis::y : UpAxis::z;
        if (def.up == UpAxis::y) def.size_m = {def.size_m.y, def.size_m.z, def.size_m.x};
        def.backend = backend;
        def.thread_count = threads;
        soil_ = make_soil(def);
        const GridFrame& frame = soil_->frame();
        for (const char* material : {"dry_sand", "clay"}) {
            // Between the points at which fills sample, so that no rounding decides.
            const Vec3 low{pick(nx) - 0.41, pick(ny) - 0.41, pick(nz) - 0.41};
            const Vec3 high{low.x + 1 + pick(nx), low.y + 1 + pick(ny), low.z + 1 + pick(nz)};
            // May be refused: where all of its room is taken.
            (void)soil_->fill(FunctionFill{[&](Vec3 at) {
                                               const Vec3 g = frame.to_grid(at);
                                               return g.x > low.x && g.y > low.y && g.z > low.z &&
                                                              g.x < high.x && g.y < high.y &&
                                                              g.z < high.z
                                                          ? 1.0
                                                          : -1.0;
                                           },
                                           material});
        }
        const int count = 1 + pick(3);
        for (int i = 0; i < count; ++i) {
            const double size = 0.6 + 3 * unit();
            ConvexShape shapes[4] = {
                box_shape(Vec3{size, 1.3, 0.9} * kVoxel), sphere_shape(size * kVoxel),
                round_shape(ConvexShape::Kind::cylinder, size * kVoxel, 1.1 * kVoxel),
                octahedron_shape(size * kVoxel)};
            const Vec3 from{nx * (1.6 * unit() - 0.3), ny * (1.6 * unit() - 0.3), nz * unit()};
            const Vec3 to{nx * (1.6 * unit() - 0.3), ny * (1.6 * unit() - 0.3), nz * unit()};
            movers_.emplace_back(i, shapes[pick(4)], frame.to_world(from));
            movers_.back().set_velocity((frame.to_world(to) - frame.to_world(from)) * 1.5,
                                        {unit(), unit(), unit()});
        }
    }

    StepReport step() {
        skip_step();
        return soil_->step(bodies_of(movers_));
    }
    /// Moves the bodies alone.
    void skip_step() {
        for (Mover& mover : movers_) mover.advance(1.0 / 60);
    }
    Soil& soil() { return *soil_; }
    std::string name() const {
        const int* size = soil_->frame().size;
        return std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
               std::to_string(size[2]);
    }

  private:
    int pick(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
    int side() { return 1 + pick(kSideMost); }
    double unit() { return static_cast<double>(random_()) / 4294967296.0; }

    std::mt19937 random_;
    std::unique_ptr<Soil> soil_;
    std::vector<Mover> movers_;
};

constexpr int kSteps = 40;

class RandomGrids : public testing::TestWithParam<unsigned> {
  protected:
    uint64_t checksum_after(Backend backend, int threads) {
        RandomGrid grid(GetParam(), backend, threads);
        for (int i = 0; i < kSteps; ++i) grid.step();
        return grid.soil().checksum();
    }
};

TEST_P(RandomGrids, keep_their_soil_and_have_their_contacts_inside) {
    RandomGrid grid(GetParam(), Backend::cpu, 1);
    const std::vector<int64_t> units = grid.soil().totals().units;
    for (int i = 0; i < kSteps; ++i) {
        ASSERT_TRUE(all_in_grid(grid.step(), grid.soil().frame())) << grid.name();
        ASSERT_EQ(grid.soil().totals().units, units) << grid.name() << " step " << i;
    }
}

TEST_P(RandomGrids, give_the_same_bits_on_two_threads) {
    EXPECT_EQ(checksum_after(Backend::cpu, 2), checksum_after(Backend::cpu, 1));
}

TEST_P(RandomGrids, go_on_from_a_snapshot_bit_for_bit) {
    RandomGrid grid(GetParam(), Backend::cpu, 1), other(GetParam(), Backend::cpu, 1);
    for (int i = 0; i < kSteps / 2; ++i) {
        grid.step();
        other.skip_step();
    }
    const auto put = other.soil().prepare(grid.soil().state());
    ASSERT_TRUE(put) << put.error();
    (*put)();
    for (int i = kSteps / 2; i < kSteps; ++i) {
        grid.step();
        other.step();
    }
    EXPECT_EQ(other.soil().checksum(), grid.soil().checksum()) << grid.name();
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomGrids, testing::Range(1u, 13u));
INSTANTIATE_TEST_SUITE_P(SlowSeeds, RandomGrids, testing::Range(13u, 25u));

class RandomGridsOnGl : public RandomGrids {};

TEST_P(RandomGridsOnGl, give_the_bits_of_the_cpu) {
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    EXPECT_EQ(checksum_after(Backend::gl, 0), checksum_after(Backend::cpu, 1));
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomGridsOnGl, testing::Range(1u, 5u));

}  // namespace
}  // namespace bsoil::grid_edges_test
