/// A run that goes on from a snapshot has its beginning behind it: what the scene says of that
/// since then is refused, and not passed over.
#include "run/scene_origin.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "reading/scene_load.h"
#include "run/scene_run.h"
#include "temporary_file.h"

namespace bsoil::scene::scene_origin_test {
namespace {

/// Rain and wind over sand, a source that has ended by step 12, one that begins later, a sink.
const std::string kScene = R"(
[world]
duration_s = 1
[soil]
size_m = [1.2, 1.2, 0.8]
voxel_m = 0.1
materials = ["damp"]
rain_m_s = 0.0001
drying_m_s = 1e-6
floor_drainage_m_s = 0.01
wind_m_s = [4, 0, 0]
open_sides = ["+x"]
[[material]]
name = "damp"
base = "fine_sand"
cohesion_pa = 500
[[fill]]
kind = "box"
min_m = [-0.6, -0.6, 0]
max_m = [0.6, 0.6, 0.3]
[[terrain]]
kind = "hills"
base_m = 0.1
amplitude_m = 0.05
[[source]]
shape = "disc"
center_m = [0.3, 0.3, 0.7]
radius_m = 0.1
rate_kg_s = 5
end_s = 0.1
[[source]]
shape = "rectangle"
center_m = [-0.3, 0.3, 0.7]
length_m = 0.2
width_m = 0.2
rate_m3_s = 0.01
start_s = 0.5
[[sink]]
shape = "box"
size_m = [0.2, 0.2, 0.2]
position_m = [-0.4, -0.4, 0.2]
rate_kg_s = 2
[[body]]
name = "block"
shape = "box"
size_m = [0.3, 0.3, 0.2]
mass_kg = 20
position_m = [0, 0, 0.45]
)";

struct Opened {
    Scene scene;
    std::unique_ptr<SceneRun> run;

    explicit Opened(const std::string& text, UpAxis up = UpAxis::z) {
        auto parsed = parse_scene(text, "s.toml");
        EXPECT_TRUE(parsed) << parsed.error();
        if (parsed) scene = *parsed;
        set_up_axis(scene, up);
        auto made = SceneRun::create(scene, {.backend = Backend::cpu, .thread_count = 1});
        EXPECT_TRUE(made) << made.error();
        if (made) run = std::move(*made);
    }
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(SceneOrigin, what_a_scene_says_otherwise_is_refused) {
    const TemporaryFile file("origin.snapshot");
    Opened first(kScene);
    for (int s = 0; s < 12; ++s) first.run->step();
    ASSERT_TRUE(first.run->save(file.path()));

    for (const auto& [from, to, says] : {
             std::array<std::string, 3>{"rain_m_s = 0.0001", "rain_m_s = 0.0002",
                                        "`rain_m_s` 0.0001 in [soil], this one has `rain_m_s` "
                                        "0.0002; set it back, or run this scene anew"},
             {"drying_m_s = 1e-6", "drying_m_s = 0", "`drying_m_s` 1e-06 in [soil]"},
             {"floor_drainage_m_s = 0.01", "", "`floor_drainage_m_s` 0.01 in [soil]"},
             {"[4, 0, 0]", "[4, 1, 0]", "this one has `wind_m_s.y` [4, 1, 0]"},
             {"[\"+x\"]", "[\"-x\"]", "open_sides"},
             {"cohesion_pa = 500", "cohesion_pa = 900", "`cohesion_pa` 500 in material \"damp\""},
             {"rate_kg_s = 5", "rate_kg_s = 50", "`rate_kg_s` 5 in [[source]] 1"},
             {"end_s = 0.1", "end_s = 0.9", "`end_s` 0.1 in [[source]] 1"},
             {"rate_m3_s = 0.01", "rate_m3_s = 0.02", "`rate_m3_s` 0.01 in [[source]] 2"},
             {"rate_kg_s = 2", "rate_kg_s = 3", "`rate_kg_s` 2 in [[sink]] 1"},
             {"[-0.4, -0.4, 0.2]", "[-0.4, -0.3, 0.2]", "`position_m` [-0.4, -0.4, 0.2] in [[sink"},
             {"0.6, 0.3]", "0.6, 0.25]", "`max_m` [0.6, 0.6, 0.3] in [[fill]] 1"},
             {"base_m = 0.1", "base_m = 0.15", "`base_m` 0.1 in [[terrain]] 1"},
             {"amplitude_m = 0.05", "",
              "`amplitude_m` 0.05 in [[terrain]] 1, this one has "
              "`amplitude_m` 0.5"},
             {"[0, 0, 0.45]", "[0, 0.1, 0.45]", "`position_m` [0, 0, 0.45] in [[body]] 1 (block)"},
             {"mass_kg = 20", "mass_kg = 20\nvelocity_m_s = [0, 0, -1]",
              "`velocity_m_s` [0, 0, 0] in [[body]] 1 (block)"},
             {"[[sink]]",
              "[[source]]\nshape = \"disc\"\nradius_m = 0.1\ncenter_m = [0, 0, "
              "0.7]\nrate_kg_s = 1\n[[sink]]",
              "without [[source]] 3, which this one has"},
         }) {
        Opened edited(replaced(kScene, from, to));
        const uint64_t before = edited.run->soil().checksum();
        const Status loaded = edited.run->load(file.path());
        ASSERT_FALSE(loaded) << to;
        EXPECT_NE(loaded.error().find(says), std::string::npos) << loaded.error();
        EXPECT_NE(loaded.error().find(file.path()), std::string::npos) << loaded.error();
        EXPECT_EQ(edited.run->soil().checksum(), before) << "nothing has changed";
    }
    Opened turned(kScene, UpAxis::y);
    const Status loaded = turned.run->load(file.path());
    ASSERT_FALSE(loaded);
    EXPECT_NE(loaded.error().find("`up` \"z\" in [world]"), std::string::npos) << loaded.error();
}

// One source has ended, the other has not begun; numbers may be written in another way, defaults
// out, and what is not of the beginning may be another.
TEST(SceneOrigin, the_same_in_other_words_goes_on) {
    const TemporaryFile file("origin_same.snapshot");
    Opened first(kScene);
    for (int s = 0; s < 12; ++s) first.run->step();
    ASSERT_TRUE(first.run->save(file.path()));
    for (int s = 0; s < 40; ++s) first.run->step();

    std::string text = replaced(kScene, "rate_kg_s = 5", "rate_kg_s = 5.0\nspeed_m_s = 0");
    text = replaced(text, "duration_s = 1", "duration_s = 2");
    text = replaced(text, "name = \"block\"", "name = \"stone\"\ncolor = [1, 0, 0]");
    Opened same(text + "[[check]]\nkind = \"no_status\"\n");
    const Status loaded = same.run->load(file.path());
    ASSERT_TRUE(loaded) << loaded.error();
    for (int s = 0; s < 40; ++s) same.run->step();
    EXPECT_EQ(same.run->soil().checksum(), first.run->soil().checksum());
    EXPECT_GT(same.run->soil().moved_kg(FlowWay::in), 2) << "the second source has begun";
}

// A person at sliders changes the soil, not the scene.
TEST(SceneOrigin, a_soil_changed_while_it_ran_goes_on_as_it_was_changed) {
    const TemporaryFile file("origin_changed.snapshot");
    Opened first(kScene);
    SoilDef other = first.run->scene_soil();
    other.rain_m_s = 5e-4;
    ASSERT_TRUE(first.run->soil().change(other));
    first.run->step();
    ASSERT_TRUE(first.run->save(file.path()));
    Opened second(kScene);
    const Status loaded = second.run->load(file.path());
    ASSERT_TRUE(loaded) << loaded.error();
    EXPECT_EQ(second.run->soil().def().rain_m_s, 5e-4);
    // And so does what it saves in its turn.
    ASSERT_TRUE(second.run->save(file.path()));
    Opened third(kScene);
    EXPECT_TRUE(third.run->load(file.path()));
}

TEST(SceneOrigin, bytes_that_are_none_are_refused) {
    const Opened scene(kScene);
    const SoilDef& soil = scene.run->scene_soil();
    std::vector<uint8_t> bytes = scene_origin(scene.scene, &soil);
    EXPECT_TRUE(check_origin(bytes, scene.scene, &soil));
    bytes.pop_back();
    EXPECT_FALSE(check_origin(bytes, scene.scene, &soil));
}

}  // namespace
}  // namespace bsoil::scene::scene_origin_test
