/// Random terrain, soil and bodies for single stages, and the fixture that puts them on a bench.
#pragma once

#include <iosfwd>
#include <vector>

#include "stage_bench.h"

namespace bsoil {

/// One random state: which grid, how many materials, what lies and moves in it.
struct Scenario {
    unsigned seed;
    int nx, ny, nz, material_count;
    SoilDef def() const;
    /// Terrain, piles, floating soil, soil in excess, random motion and force.
    StatePlanes planes(const StageBench& bench) const;
    /// A turning box, a moving octahedron and a fixed cylinder.
    std::vector<Mover> bodies(const StageBench& bench) const;
};
void PrintTo(const Scenario& scenario, std::ostream* out);
/// 16 x 16 x 16 and 24 x 16 x 24 voxels, one and three materials, several seeds.
std::vector<Scenario> all_scenarios();

/// Benches are made once per grid and backend: a GL device takes a while to compile its kernels.
StageBench& bench_of(const Scenario& scenario, Backend backend);

/// Stages against the oracle on the CPU, and bit for bit the same on software GL.
class Stage : public testing::TestWithParam<Scenario> {
  protected:
    /// A bench that holds the scenario's state, its bodies voxelized and supports found.
    StageBench& prepared(Backend backend) const;
    /// Runs `stage` on both backends and compares what it returns word for word; skips without GL.
    template <typename Run>
    void expect_same_on_gl(Run&& stage) const {
        if (!gl_missing().empty()) {
            GTEST_SKIP() << gl_missing();
        }
        const auto on_cpu = stage(prepared(Backend::cpu));
        const auto on_gl = stage(prepared(Backend::gl));
        EXPECT_TRUE(on_cpu == on_gl) << "CPU and GL differ";
    }
};

}  // namespace bsoil
