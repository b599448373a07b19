/// Time to mesh 100 dirty tiles of 64 columns x 72 voxels on one core. The aim for level ground is
/// 3 ms. "read" is the share of it that goes into reading voxels and finding the runs of columns.
#include <benchmark/benchmark.h>

#include <cmath>

#include "bsoil/surface_mesh.h"
#include "voxel_tiles.h"

namespace bsoil {
namespace {

using test::VoxelTiles;

double level_ground(double, double) { return 40.3; }
double rough_ground(double x, double y) {
    return 36 + 6 * std::sin(0.21 * x) * std::cos(0.17 * y) + 2 * std::sin(0.9 * x + 0.5 * y);
}

/// Everything changes a little in each iteration, so that all tiles are read and built.
void mesh_ground(benchmark::State& state, double (*height)(double, double), bool close_floor) {
    constexpr int kSide = 80, kHeight = 72;
    VoxelTiles tiles(kSide, kSide, kHeight);
    tiles.fill_heights(height);
    SurfaceMesher mesher(tiles, {.close_floor = close_floor});
    mesher.update();
    float change = 0.01f;
    int64_t built = 0;
    for (auto _ : state) {
        state.PauseTiming();
        change = -change;
        for (int y = 0; y < kSide; y += 8) {
            for (int x = 0; x < kSide; x += 8) {
                const auto top = static_cast<int>(height(x + 0.5, y + 0.5));
                tiles.volume(x, y, top) += change;
                tiles.touch(x, y);
            }
        }
        state.ResumeTiming();
        built += mesher.update().tile_built_count;
    }
    state.counters["tiles"] =
        benchmark::Counter(static_cast<double>(built), benchmark::Counter::kAvgIterations);
}

/// Tiles are touched but hold what they held: the cost of reading alone.
void read_ground(benchmark::State& state) {
    VoxelTiles tiles(80, 80, 72);
    tiles.fill_heights(level_ground);
    SurfaceMesher mesher(tiles);
    mesher.update();
    for (auto _ : state) {
        for (int y = 0; y < 80; y += 8) {
            for (int x = 0; x < 80; x += 8) tiles.touch(x, y);
        }
        benchmark::DoNotOptimize(mesher.update().tile_read_count);
    }
}

BENCHMARK_CAPTURE(mesh_ground, level, level_ground, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(mesh_ground, level_closed, level_ground, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(mesh_ground, rough, rough_ground, false)->Unit(benchmark::kMillisecond);
BENCHMARK(read_ground)->Name("read")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bsoil

BENCHMARK_MAIN();
