// Same scene, same steps, same bits: on any number of threads, any backend, in any frame.
#include <fmt/format.h>

#include <cstdlib>
#include <numbers>

#include "moving_scene.h"

namespace bsoil::determinism_test {
namespace {

/// What falls, from 0.44 m at most, has come down after 18 steps; the blade, the wheel and the
/// stone move from the first one.
uint64_t checksum_after(int steps, const SoilDef& def, unsigned seed = 4) {
    MovingScene scene(seed, def);
    scene.run(steps);
    return scene.soil().checksum();
}

TEST(Determinism, threads_and_repetition_do_not_matter) {
    SoilDef def = MovingScene::default_def();
    const uint64_t once = checksum_after(60, def);
    EXPECT_EQ(checksum_after(60, def), once);
    def.thread_count = 2;
    EXPECT_EQ(checksum_after(60, def), once);
    EXPECT_EQ(checksum_after(60, def), once);
    EXPECT_NE(checksum_after(60, def, 5), once);
}

TEST(Determinism, gl_gives_the_bits_of_the_cpu) {
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    // tests/gpu/run.sh shows what is recorded here.
    const auto record = [](const std::string& key, uint64_t checksum) {
        testing::Test::RecordProperty(key, fmt::format("{:016x}", checksum));
    };
    for (unsigned seed : {4u, 5u, 6u}) {
        SoilDef def = MovingScene::default_def();
        const uint64_t on_cpu = checksum_after(30, def, seed);
        def.backend = Backend::gl;
        MovingScene scene(seed, def);
        scene.run(30);
        EXPECT_EQ(scene.soil().checksum(), on_cpu);
        testing::Test::RecordProperty("gl_device", scene.soil().device_name());
        record(fmt::format("cpu_{}", seed), on_cpu);
        record(fmt::format("gl_{}", seed), scene.soil().checksum());
    }
}

/// A scene whose kernels are dispatched as on a GPU: software lists the lanes that have work, a GPU
/// runs them all.
MovingScene scene_as_on_a_gpu() {
    SoilDef def = MovingScene::default_def();
    def.backend = Backend::gl;
    setenv("BULLETSOIL_GL", "hardware", 1);
    MovingScene scene(4, def);
    unsetenv("BULLETSOIL_GL");
    return scene;
}

// They are translated for the processor only when they run.
TEST(Determinism, kernels_as_for_a_gpu_compile_and_link) {
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    EXPECT_FALSE(scene_as_on_a_gpu().soil().device_name().empty());
}

// Slow, because software translates each kernel for it: a minute with an empty cache of shaders.
TEST(SlowDeterminism, gl_gives_the_same_bits_dispatched_as_on_a_gpu) {
    if (!gl_missing().empty()) {
        GTEST_SKIP() << gl_missing();
    }
    constexpr int kSteps = 12;
    const uint64_t on_cpu = checksum_after(kSteps, MovingScene::default_def());
    MovingScene scene = scene_as_on_a_gpu();
    scene.run(kSteps);
    EXPECT_EQ(scene.soil().checksum(), on_cpu);
}

TEST(Determinism, the_frame_of_the_grid_does_not_matter) {
    SoilDef def = MovingScene::default_def();
    const uint64_t z_up = checksum_after(40, def);
    def.floor_center_m = {1.7, -3.1, 0.9};
    def.yaw_rad = 0.4;
    EXPECT_EQ(checksum_after(40, def), z_up);
    // Y up: grid x and y run along world Z and X.
    SoilDef y_up = MovingScene::default_def();
    y_up.up = UpAxis::y;
    y_up.size_m = {def.size_m.y, def.size_m.z, def.size_m.x};
    EXPECT_EQ(checksum_after(40, y_up), z_up);
    y_up.yaw_rad = -std::numbers::pi / 3;
    EXPECT_EQ(checksum_after(40, y_up), z_up);
}

TEST(Determinism, the_order_of_bodies_does_not_matter) {
    // Three boxes that overlap no soil voxel twice, listed forwards and backwards.
    const auto run = [](bool backwards) {
        auto soil = make_soil(grid_def(40, 16, 16));
        EXPECT_TRUE(soil->fill(voxel_box(*soil, {0, 0, 0}, {40, 16, 6})));
        std::vector<Mover> movers;
        for (int i = 0; i < 3; ++i) {
            movers.emplace_back(i, box_shape(Vec3{1.5, 1.5, 1.5} * 0.05),
                                Vec3{6.0 + 13 * i, 5, 6} * 0.05);
            movers.back().set_velocity({0, 0.3, -0.1});
        }
        for (int s = 0; s < 40; ++s) {
            for (Mover& mover : movers) mover.advance(1.0 / 60);
            std::vector<SoilBody> bodies = bodies_of(movers);
            if (backwards) std::reverse(bodies.begin(), bodies.end());
            soil->step(bodies);
        }
        return soil->checksum();
    };
    EXPECT_EQ(run(false), run(true));
}

}  // namespace
}  // namespace bsoil::determinism_test
