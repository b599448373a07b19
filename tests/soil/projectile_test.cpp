// Support, advection (21) to (29) and overflow resolution against the oracle.
#include "oracle/projectile.h"

#include "stage_bench.h"

namespace bsoil {
namespace {

using namespace layout;

class Projectile : public Stage {};

TEST_P(Projectile, support_follows_the_oracle) {
    StageBench& bench = prepared(Backend::cpu);
    const oracle::Field got = bench.to_field(bench.read());
    const oracle::Field expected = oracle::find_support(bench.model(), got, bench.oracle_bodies());
    got.for_each([&](int x, int y, int z) {
        const oracle::Support &a = got.at(x, y, z).support, &b = expected.at(x, y, z).support;
        EXPECT_TRUE(a.kind == b.kind && a.body == b.body) << x << " " << y << " " << z;
    });
}

TEST_P(Projectile, advection_follows_the_oracle) {
    for (const auto& [substeps, substep] : {std::pair{1, 0}, std::pair{3, 0}, std::pair{3, 2}}) {
        StageBench& bench = prepared(Backend::cpu);
        const oracle::Field before = bench.to_field(bench.read());
        const oracle::Field expected = oracle::advect(bench.model(substeps, substep), before, bench.oracle_bodies());
        bench.advect(substeps, substep);
        const FieldDeviation deviation = compare(bench.to_field(bench.read()), expected, GetParam().material_count);
        // Drift is a whole number of 1/65536 voxels, cut off twice (velocity, sub-step); overlaps and amounts are rounded
        // down four times: at most 6 units for each voxel's worth of soil. A voxel sends to 7 and gets from 26.
        constexpr double kTolerance = 6.0 * 33 / kVoxelFull;
        EXPECT_LT(deviation.soil.value, kTolerance) << deviation.soil;
        EXPECT_LT(deviation.mass.value, kTolerance) << deviation.mass;
        EXPECT_LT(deviation.momentum.value, kTolerance) << deviation.momentum;
    }
}

TEST_P(Projectile, overflow_resolution_follows_the_oracle) {
    constexpr std::pair<OverflowHeuristic, oracle::Heuristic> kHeuristics[] = {
        {OverflowHeuristic::even, oracle::Heuristic::even},
        {OverflowHeuristic::up, oracle::Heuristic::up},
        {OverflowHeuristic::up_spread, oracle::Heuristic::up_spread},
    };
    for (const auto& [heuristic, oracle_heuristic] : kHeuristics) {
        StageBench& bench = prepared(Backend::cpu);
        bench.apply_force();  // soil without a body keeps its push, soil without excess loses it
        const oracle::Field before = bench.to_field(bench.read());
        const oracle::Field expected = oracle::resolve_overflow(bench.model(), before, oracle_heuristic);
        bench.resolve_overflow(heuristic);
        const FieldDeviation deviation = compare(bench.to_field(bench.read()), expected, GetParam().material_count);
        // Share of the excess, its division among up to 26 voxels and the amount are each rounded down: 3 units for each
        // of up to 2.5 voxels' worth of soil, with 26 voxels either way.
        constexpr double kTolerance = 3.0 * 52 * 2.5 / kVoxelFull;
        EXPECT_LT(deviation.soil.value, kTolerance) << deviation.soil;
        EXPECT_LT(deviation.mass.value, kTolerance) << deviation.mass;
        EXPECT_LT(deviation.momentum.value, kTolerance) << deviation.momentum;
        int moved_count = 0;
        before.for_each([&](int x, int y, int z) { moved_count += before.at(x, y, z).soil != expected.at(x, y, z).soil; });
        EXPECT_GT(moved_count, 5);
    }
}

TEST_P(Projectile, has_the_same_bits_on_gl) {
    expect_same_on_gl([](StageBench& bench) {
        bench.advect(1, 0);
        for (OverflowHeuristic heuristic : {OverflowHeuristic::even, OverflowHeuristic::up, OverflowHeuristic::up_spread}) {
            bench.resolve_overflow(heuristic);
        }
        bench.find_support();
        bench.advect(2, 1);
        return bench.read();
    });
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Projectile, testing::ValuesIn(all_scenarios()), testing::PrintToStringParamName());

}  // namespace
}  // namespace bsoil
