// Slides that keep their momentum: slide_soil against the oracle.
#include "oracle/sliding.h"

#include "stage_scenario.h"

namespace bsoil::sliding_test {
namespace {

class Sliding : public Stage {
  protected:
    static SoilDef def(Backend backend, double viscosity = 0) {
        SoilDef def = GetParam().def();
        def.backend = backend;
        def.slides = SlideMotion::run_out;
        def.material.viscosity = viscosity;
        if (!def.materials.empty()) def.materials[1].viscosity = viscosity;
        return def;
    }
    static void prepare(StageBench& bench) {
        bench.write(GetParam().planes(bench));
        bench.place(GetParam().bodies(bench));
        bench.find_support();
        bench.build_spans();
    }
};

TEST_P(Sliding, follows_the_oracle) {
    for (const double viscosity : {0.0, 0.3}) {
        StageBench bench(def(Backend::cpu, viscosity));
        for (const int passes : {1, 2, 8}) {
            SCOPED_TRACE("1 of " + std::to_string(passes) + " passes");
            prepare(bench);
            const oracle::Field before = bench.to_field(bench.read());
            bench.slide(passes);
            const oracle::Field expected = oracle::slide_soil(bench.model(), before);
            const FieldDeviation deviation =
                compare(bench.to_field(bench.read()), expected, GetParam().material_count);
            // A slide's speed is good to 2^-12 of itself, and up to 2.5 voxels thick here; soil
            // arrives from up to 8 columns.
            EXPECT_LT(deviation.soil.value, 8 * 1e-3) << deviation.soil;
            EXPECT_LT(deviation.mass.value, 8 * 1e-3) << deviation.mass;
            EXPECT_LT(deviation.momentum.value, 8 * 1e-3) << deviation.momentum;
            int moved_count = 0;
            before.for_each([&](int x, int y, int z) {
                moved_count += before.at(x, y, z).soil != expected.at(x, y, z).soil;
            });
            EXPECT_GT(moved_count, 100);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Sliding, testing::ValuesIn(all_scenarios()),
                         testing::PrintToStringParamName());

TEST(SlidingOnGl, has_the_same_bits) {
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    for (const Scenario& scenario : {Scenario{3, 16, 16, 16, 1}, Scenario{14, 24, 16, 24, 3}}) {
        std::vector<StatePlanes> after;
        for (const Backend backend : {Backend::cpu, Backend::gl}) {
            SoilDef def = scenario.def();
            def.backend = backend;
            def.slides = SlideMotion::run_out;
            StageBench bench(def);
            bench.write(scenario.planes(bench));
            bench.place(scenario.bodies(bench));
            bench.find_support();
            bench.build_spans();
            bench.impl().params.slide_kick = bench.impl().params.gravity_q16;
            bench.slip(1);
            bench.build_spans();
            bench.slide(2);
            after.push_back(bench.read());
        }
        EXPECT_TRUE(after[0] == after[1]) << "CPU and GL differ";
    }
}

}  // namespace
}  // namespace bsoil::sliding_test
