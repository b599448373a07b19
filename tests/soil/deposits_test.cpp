// What is poured and lies: soil with roughness and viscosity, from a liquid to a solid.
#include <cstdio>
#include <numbers>

#include "soil_fixture.h"
#include "temporary_file.h"

namespace bsoil::deposits_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

MaterialDef deposit(double friction_deg, double roughness, double viscosity) {
    MaterialDef material = sand(friction_deg);
    material.roughness = roughness;
    material.viscosity = viscosity;
    return material;
}

/// A bank of soil against a wall, `wide` columns and `high` voxels, in a grid of `length` columns.
std::unique_ptr<Soil> bank(const MaterialDef& material, int wide, int high, int length,
                           SoilDef changes = {}) {
    SoilDef def = grid_def(length, 16, high + 4, changes.voxel_m);
    def.material = material;
    def.slides = changes.slides;
    def.step_s = changes.step_s;
    def.backend = changes.backend;
    def.thread_count = changes.thread_count;
    auto soil = make_soil(def);
    EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {1.0 * wide, 16, 1.0 * high})));
    return soil;
}

int settle(Soil& soil, int steps_most) {
    int steps = 0;
    while (steps < steps_most && soil.step({}).block_active_count > 0) ++steps;
    return steps;
}

struct Levels {
    double lowest = 1e9, highest = -1e9;
};
Levels levels(const Soil& soil) {
    Levels out;
    for (int y = 0; y < soil.frame().size[1]; ++y) {
        for (int x = 0; x < soil.frame().size[0]; ++x) {
            const double height = soil.surface_height_m(x, y) / soil.frame().voxel_m;
            out.lowest = std::min(out.lowest, height);
            out.highest = std::max(out.highest, height);
        }
    }
    return out;
}

TEST(Viscosity, of_zero_finds_its_level) {
    auto soil = bank(deposit(0, 0, 0), 12, 12, 40);
    const std::vector<int64_t> units = soil->totals().units;
    EXPECT_LT(settle(*soil, 6000), 6000);
    const Levels level = levels(*soil);
    // What slopes by less than 1/256 voxel per voxel stands: 40/256 over the length.
    EXPECT_LT(level.highest - level.lowest, 0.2);
    EXPECT_NEAR((level.highest + level.lowest) / 2, 12 * 12 / 40.0, 0.1);
    EXPECT_EQ(soil->totals().units, units);
    EXPECT_EQ(soil->status_bits(), 0u);
}

TEST(Viscosity, of_one_moves_nothing_and_sleeps) {
    for (const SlideMotion slides : {SlideMotion::settle, SlideMotion::run_out}) {
        SoilDef changes;
        changes.slides = slides;
        auto soil = bank(deposit(20, 0, 1), 12, 12, 40, changes);
        const uint64_t checksum = soil->checksum();
        EXPECT_LT(settle(*soil, 20), 20);
        for (int i = 0; i < 200; ++i) soil->step({});
        EXPECT_EQ(soil->checksum(), checksum);
    }
}

/// Steps until half of what will leave the bank's own columns has left them.
int steps_to_half(double viscosity, SoilDef changes = {}) {
    const int scale = static_cast<int>(std::lround(0.05 / changes.voxel_m));
    auto soil = bank(deposit(0, 0, viscosity), 12 * scale, 12 * scale, 36 * scale, changes);
    const double start_m = 12 * scale * soil->frame().voxel_m;
    int steps = 0;
    for (double mean_m = start_m; mean_m > start_m * 2 / 3 && steps < 20000; ++steps) {
        soil->step({});
        mean_m = 0;
        for (int x = 0; x < 12 * scale; ++x) mean_m += soil->surface_height_m(x, 8) / (12 * scale);
    }
    return steps;
}

// A pass moves 1 - viscosity of what fails. A steep slope of little viscosity makes up for that:
// it gets more passes.
TEST(Viscosity, slows_slides_by_the_share_it_holds_back) {
    const int none = steps_to_half(0), half = steps_to_half(0.5), most = steps_to_half(0.9),
              more = steps_to_half(0.95);
    std::printf("| viscosity | 0 | 0.5 | 0.9 | 0.95 |\n|---|---|---|---|---|\n");
    std::printf("| steps | %d | %d | %d | %d |\n", none, half, most, more);
    EXPECT_GT(half, 1.2 * none);
    EXPECT_GT(most, 5 * half);
    EXPECT_NEAR(more, 2.0 * most, 0.2 * most);
}

TEST(SlowViscosity, takes_the_same_time_with_any_step_and_in_any_grid) {
    SoilDef step, voxel;
    step.step_s = 1.0 / 120;
    voxel.voxel_m = 0.025;
    const double whole = steps_to_half(0.9);
    EXPECT_NEAR(steps_to_half(0.9, step) / 2.0, whole, 0.2 * whole);
    EXPECT_NEAR(steps_to_half(0.9, voxel), whole, 0.2 * whole);
}

// However slow: it goes on until it is level, and only then sleeps.
TEST(Viscosity, of_nearly_one_comes_to_the_same_level) {
    auto soil = bank(deposit(0, 0, 0.9), 6, 6, 16);
    const std::vector<int64_t> units = soil->totals().units;
    EXPECT_LT(settle(*soil, 20000), 20000);
    const Levels level = levels(*soil);
    EXPECT_LT(level.highest - level.lowest, 0.1);
    EXPECT_EQ(soil->totals().units, units);
}

TEST(Viscosity, takes_the_momentum_of_slides) {
    const auto end_of = [](double viscosity) {
        SoilDef changes;
        changes.slides = SlideMotion::run_out;
        auto soil = bank(deposit(31, 0, viscosity), 8, 16, 64, changes);
        EXPECT_LT(settle(*soil, 4000), 4000);
        int end = 0;
        for (int x = 0; x < 64; ++x) end = soil->surface_height_m(x, 8) > 0.004 ? x + 1 : end;
        return end;
    };
    const int none = end_of(0), thick = end_of(0.8);
    EXPECT_LT(thick, none - 3);
}

/// Height of a bank's flank above its foot over its length, and how far it is from straight
/// [voxels].
struct Flank {
    double slope = 0, unevenness = 0;
};
Flank flank(const Soil& soil) {
    double n = 0, sx = 0, sh = 0, sxx = 0, sxh = 0;
    std::vector<std::array<double, 2>> points;
    const double voxel = soil.frame().voxel_m;
    const double peak = soil.surface_height_m(0, 8) / voxel;
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < soil.frame().size[0]; ++x) {
            const double h = soil.surface_height_m(x, y) / voxel;
            if (h < 0.2 * peak || h > 0.8 * peak) continue;
            points.push_back({1.0 * x, h});
            n += 1;
            sx += x;
            sh += h;
            sxx += x * x;
            sxh += x * h;
        }
    }
    Flank out;
    const double tilt = (n * sxh - sx * sh) / (n * sxx - sx * sx);
    out.slope = -tilt;
    for (const auto& [x, h] : points) {
        out.unevenness += std::pow(h - sh / n - tilt * (x - sx / n), 2) / n;
    }
    out.unevenness = std::sqrt(out.unevenness);
    return out;
}

TEST(Roughness, lets_slopes_stand_steeper_and_unevenly) {
    const double slope_of_phi = std::tan(30 * kDegree);
    auto smooth = bank(deposit(30, 0, 0), 20, 20, 64);
    settle(*smooth, 2000);
    const Flank of_smooth = flank(*smooth);
    double before = of_smooth.slope;
    std::printf("| roughness | slope | unevenness, voxels |\n|---|---|---|\n| 0 | %.3f | %.2f |\n",
                of_smooth.slope, of_smooth.unevenness);
    for (const double roughness : {0.2, 0.5}) {
        auto rough = bank(deposit(30, roughness, 0), 20, 20, 64);
        const std::vector<int64_t> units = rough->totals().units;
        EXPECT_LT(settle(*rough, 2000), 2000);
        const Flank got = flank(*rough);
        EXPECT_GT(got.slope, slope_of_phi + 0.25 * roughness) << roughness;
        EXPECT_LT(got.slope, slope_of_phi + roughness) << roughness;
        EXPECT_GT(got.slope, before);
        EXPECT_GT(got.unevenness, of_smooth.unevenness) << roughness;
        EXPECT_EQ(rough->totals().units, units);
        const uint64_t checksum = rough->checksum();
        for (int i = 0; i < 300; ++i) rough->step({});
        EXPECT_EQ(rough->checksum(), checksum) << "creeps";
        before = got.slope;
        std::printf("| %.1f | %.3f | %.2f |\n", roughness, got.slope, got.unevenness);
    }
}

// What lets rough soil stand steeper holds what slides, too: it comes to rest as smooth soil does,
// and steeper.
TEST(Roughness, holds_what_slides) {
    const auto bank_of = [](double roughness, int& steps) {
        SoilDef changes;
        changes.slides = SlideMotion::run_out;
        auto soil = bank(deposit(26, roughness, 0), 14, 14, 28, changes);
        steps = settle(*soil, 2000);
        return flank(*soil).slope;
    };
    int of_smooth = 0, of_rough = 0;
    const double smooth = bank_of(0, of_smooth), rough = bank_of(3, of_rough);
    std::printf("smooth %.3f after %d steps, rough %.3f after %d\n", smooth, of_smooth, rough,
                of_rough);
    EXPECT_LT(of_rough, 1.25 * of_smooth);
    EXPECT_GT(rough, smooth + 0.25);
}

TEST(Roughness, of_40_makes_a_solid) {
    auto soil = bank(deposit(10, 40, 0), 12, 40, 24);
    const uint64_t checksum = soil->checksum();
    for (int i = 0; i < 100; ++i) soil->step({});
    EXPECT_EQ(soil->checksum(), checksum);
}

TEST(Deposits, have_the_same_bits_on_gl_on_threads_and_from_a_snapshot) {
    const MaterialDef snow = deposit(25, 0.6, 0.7);
    auto soil = bank(snow, 12, 14, 32);
    const TemporaryFile file("deposits.snapshot");
    const std::vector<int64_t> units = soil->totals().units;
    std::vector<uint64_t> sums;
    for (int i = 0; i < 30; ++i) {
        if (i == 13) {
            ASSERT_TRUE(soil->save(file.path()));
        }
        soil->step({});
        sums.push_back(soil->checksum());
    }
    EXPECT_EQ(soil->totals().units, units);
    EXPECT_NE(sums.front(), sums.back());
    SoilDef def = soil->def();
    def.thread_count = 3;
    auto twin = make_soil(def);
    ASSERT_TRUE(twin->load(file.path()));
    for (size_t i = 13; i < sums.size(); ++i) {
        twin->step({});
        ASSERT_EQ(twin->checksum(), sums[i]) << "step " << i << " from a snapshot, on threads";
    }
    if (!gl_missing().empty()) GTEST_SKIP() << gl_missing();
    SoilDef on_gl;
    on_gl.backend = Backend::gl;
    auto other = bank(snow, 12, 14, 32, on_gl);
    for (size_t i = 0; i < sums.size(); ++i) {
        other->step({});
        ASSERT_EQ(other->checksum(), sums[i]) << "step " << i << " on GL";
    }
}

}  // namespace
}  // namespace bsoil::deposits_test
