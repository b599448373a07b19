// What a body has covered is free behind it, wherever the soil's top has gone meanwhile.
#include "soil_fixture.h"

namespace bsoil::cleared_coverage_test {
namespace {

constexpr double kVoxel = 0.05;

/// Of bodies in the first tile, from two blocks below the body's to the grid's top [voxels].
double coverage_of_first_tile(const Soil& soil) {
    double sum = 0;
    for (int z = 16; z < soil.frame().size[2]; ++z) {
        for (int y = 0; y < 8; ++y) {
            for (int x = 0; x < 8; ++x) sum += soil.sample(x, y, z).body_coverage;
        }
    }
    return sum;
}

class ClearedCoverage : public testing::TestWithParam<Backend> {
  protected:
    void SetUp() override {
        if (GetParam() == Backend::gl && !gl_missing().empty()) GTEST_SKIP() << gl_missing();
    }
    /// A lump falls from beside a box, 34 voxels up, onto level soil. The box waits, then goes on
    /// until it has left the first tile by two voxels.
    void lump_falls_beside_a_box(int waiting_steps, double voxels_a_step) const {
        SoilDef def = grid_def(32, 8, 48, kVoxel);
        def.backend = GetParam();
        const auto soil = make_soil(def);
        ASSERT_TRUE(soil);
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {32, 8, 2})));
        ASSERT_TRUE(soil->fill(voxel_box(*soil, {1, 3, 34}, {4, 6, 38})));
        std::vector<Mover> movers;
        movers.emplace_back(1, box_shape(Vec3{1.5, 1.5, 1.5} * kVoxel), Vec3{6, 4, 36} * kVoxel);
        for (int i = 0; i < waiting_steps; ++i) soil->step(bodies_of(movers));
        movers[0].set_velocity({voxels_a_step * kVoxel / def.step_s, 0, 0});
        EXPECT_NEAR(coverage_of_first_tile(*soil), waiting_steps > 0 ? 27 : 0, 0.5);
        while (movers[0].body.pose.position.x < 11.5 * kVoxel) {
            movers[0].advance(def.step_s);
            soil->step(bodies_of(movers));
        }
        ASSERT_TRUE(SoilProbe::impl(*soil).tiles[0]->is_awake());
        EXPECT_EQ(coverage_of_first_tile(*soil), 0);
    }
};

// The lump is out of the box's block after 15 to 20 steps: by then the box has gone two voxels.
TEST_P(ClearedCoverage, goes_with_a_body_while_soil_beside_it_falls) {
    lump_falls_beside_a_box(0, 0.12);
}

TEST_P(ClearedCoverage, goes_with_a_body_that_stood_while_soil_beside_it_fell) {
    lump_falls_beside_a_box(30, 0.3);
}

INSTANTIATE_TEST_SUITE_P(Backends, ClearedCoverage, testing::Values(Backend::cpu, Backend::gl),
                         [](const auto& tested) {
                             return tested.param == Backend::cpu ? "cpu" : "gl";
                         });

}  // namespace
}  // namespace bsoil::cleared_coverage_test
