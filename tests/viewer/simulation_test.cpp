/// The scene behind the window, without one.
#include "simulation.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "reading/scene_load.h"
#include "temporary_file.h"

namespace bsoil::viewer {
namespace {

/// What the simulation says once all its orders are carried out.
RunStatus status_of(Simulation& simulation) {
    WorldPicture picture;
    simulation.finish_orders();
    simulation.take(picture);  // it may be of before the orders
    simulation.set_debug_mode(0);
    for (int i = 0; i < 5000 && !simulation.take(picture); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return picture.status;
}

// Both were known to the window that had saved it alone.
TEST(Simulation, begins_with_the_sliders_and_brushes_of_a_snapshot) {
    const auto scene = scene::load_scene(BSOIL_VIEWER_TESTS "/play.toml");
    ASSERT_TRUE(scene) << scene.error();
    const scene::RunDef def{.backend = Backend::cpu, .thread_count = 1};
    const TemporaryFile file("sliders.snapshot");
    auto first = Simulation::create(*scene, def);
    ASSERT_TRUE(first) << first.error();
    SoilDef soil = (*first)->scene_soil();
    soil.materials[0].friction_angle_rad = 0.3;
    (*first)->change_soil(soil);
    (*first)->use_brush(Brush::dig, 0.3, {0, -1, 2}, {0, -1, -1});
    (*first)->make_steps(2);
    (*first)->finish_orders();
    (*first)->save(file.path());
    const RunStatus saved = status_of(**first);
    EXPECT_NE(saved.units_text.find(" 0 in, "), std::string::npos) << saved.units_text;
    EXPECT_EQ(saved.units_text.find(", 0 out"), std::string::npos) << "nothing was dug";

    auto second = Simulation::create(*scene, def, file.path());
    ASSERT_TRUE(second) << second.error();
    EXPECT_EQ((*second)->first_soil().materials[0].friction_angle_rad, 0.3);
    EXPECT_NE((*second)->scene_soil().materials[0].friction_angle_rad, 0.3);
    const RunStatus begun = status_of(**second);
    EXPECT_EQ(begun.units_text, saved.units_text);
    EXPECT_EQ(begun.step_count, saved.step_count);
}

}  // namespace
}  // namespace bsoil::viewer
