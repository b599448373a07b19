// Soil is an integer per material, and stays that integer.
#include "moving_scene.h"

namespace bsoil::conservation_test {
namespace {

class Conservation : public testing::TestWithParam<unsigned> {};

TEST_P(Conservation, every_material_keeps_its_units_while_bodies_plough_through_it) {
    for (OverflowHeuristic heuristic :
         {OverflowHeuristic::even, OverflowHeuristic::up, OverflowHeuristic::up_spread}) {
        SoilDef def = MovingScene::default_def();
        def.overflow = heuristic;
        MovingScene scene(GetParam(), def);
        const std::vector<int64_t> before = scene.soil().totals().units;
        const uint64_t checksum = scene.soil().checksum();
        for (int i = 0; i < 10; ++i) {
            scene.run(20);
            ASSERT_EQ(scene.soil().totals().units, before)
                << "after " << scene.step_count() << " steps";
        }
        EXPECT_NE(scene.soil().checksum(), checksum);
        // Soil thrown about makes many falling spans in a column: that is reported, and loses
        // nothing.
        EXPECT_EQ(scene.soil().status_bits() & ~static_cast<uint32_t>(StatusBit::span_list_full),
                  0u)
            << testing::PrintToString(status_texts(scene.soil().status_bits()));
    }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Conservation, testing::Values(1u));
INSTANTIATE_TEST_SUITE_P(SlowSeeds, Conservation, testing::Values(2u, 3u));

}  // namespace
}  // namespace bsoil::conservation_test
