/// The window, under a virtual display: a script goes through every control, and what the window
/// shows is compared with pictures of how it has to look.
#include <gtest/gtest.h>
#include <stb/stb_image.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "camera_rig.h"
#include "field_overlay.h"
#include "hand.h"
#include "levers.h"
#include "reading/scene_load.h"
#include "surface_patches.h"

namespace bsoil::viewer {
namespace {

namespace fs = std::filesystem;

struct Pixels {
    int width = 0, height = 0;
    std::vector<uint8_t> rgb;
};

Pixels read_png(const fs::path& path) {
    Pixels pixels;
    int channels = 0;
    uint8_t* data = stbi_load(path.c_str(), &pixels.width, &pixels.height, &channels, 3);
    EXPECT_NE(data, nullptr) << path << " cannot be read";
    if (!data) return pixels;
    pixels.rgb.assign(
        data, data + 3 * static_cast<size_t>(pixels.width) * static_cast<size_t>(pixels.height));
    stbi_image_free(data);
    return pixels;
}

/// Of two pictures of a size: the mean difference [grey levels] and the share of pixels that differ
/// by more than a tenth of the range.
struct Difference {
    double mean = 255, share = 1;
};
Difference difference(const Pixels& a, const Pixels& b) {
    if (a.width != b.width || a.height != b.height || a.rgb.empty()) return {};
    double sum = 0;
    size_t far = 0;
    for (size_t p = 0; p < a.rgb.size(); p += 3) {
        int most = 0;
        for (size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(a.rgb[p + c] - b.rgb[p + c]));
        sum += most;
        far += most > 25;
    }
    const double count = static_cast<double>(a.rgb.size() / 3);
    return {sum / count, static_cast<double>(far) / count};
}

/// Runs the command under a virtual display of software GL, each under one of its own: xvfb-run
/// takes a number that the server before it has just let go, and then does not start. It is given
/// the file of keys: now and then it fails to remove the folder that it makes for one.
std::string under_display(const std::string& options = {}) {
    static const struct Keys {
        fs::path path = fs::path(BSOIL_VIEWER_OUT) / ("keys_" + std::to_string(getpid()));
        Keys() {
            fs::create_directories(path.parent_path());
            std::ofstream{path};
        }
        ~Keys() { fs::remove(path); }
    } keys;
    static int count = 0;
    const int display = 100 + (getpid() * 16 + count++) % 50000;
    return "LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -n " + std::to_string(display) + " -f '" +
           keys.path.string() + "' " + options + " '" BSOIL_COMMAND "' ";
}

/// Runs the script once for all tests; the folder with its pictures, or why there is none.
struct Played {
    fs::path folder;
    std::string skipped;
    int exit_code = -1;
    Played() {
        if (std::system("command -v xvfb-run >/dev/null") != 0) {
            skipped = "xvfb-run is not installed (Debian: xvfb, xauth)";
            return;
        }
        folder = fs::path(BSOIL_VIEWER_OUT) / "script";
        fs::remove_all(folder);
        fs::create_directories(folder);
        std::ifstream source(fs::path(BSOIL_VIEWER_TESTS) / "play.txt");
        std::stringstream text;
        text << source.rdbuf();
        std::ofstream(folder / "play.txt")
            << std::regex_replace(text.str(), std::regex("FOLDER"), folder.string());
        // llvmpipe on any machine: what the reference pictures were made with.
        const std::string command =
            "cd '" + folder.string() + "' && " + under_display("-s '-screen 0 1280x1024x24'") +
            "view '" BSOIL_VIEWER_TESTS
            "/play.toml' --script play.txt --backend cpu --width 800 --height 560 > log.txt 2>&1";
        exit_code = std::system(command.c_str());
    }
    std::string log() const {
        std::ifstream file(folder / "log.txt");
        std::stringstream text;
        text << file.rdbuf();
        return text.str();
    }
};

class ViewerWindow : public testing::Test {
  protected:
    void SetUp() override {
        static const Played once;
        played_ = &once;
        if (!once.skipped.empty()) {
            GTEST_SKIP() << once.skipped;
        }
        ASSERT_EQ(once.exit_code, 0) << once.log();
    }
    Pixels picture(const std::string& name) const {
        return read_png(played_->folder / (name + ".png"));
    }
    const Played* played_ = nullptr;
};

// Other versions of Mesa may round edges, shadows and letters otherwise: one grey level in the mean
// and one pixel in a hundred are left for that. A control that does nothing, a body or a field that
// is missing changes whole percents.
constexpr double kMeanMost = 1.0, kShareMost = 0.01;

TEST_F(ViewerWindow, looks_as_the_reference_pictures) {
    for (const char* name :
         {"pushed", "disturbed", "slice", "volume", "lines", "cab", "dug", "flowing", "plots"}) {
        SCOPED_TRACE(name);
        const fs::path reference =
            fs::path(BSOIL_VIEWER_TESTS) / "reference" / (std::string(name) + ".png");
        if (std::getenv("BSOIL_WRITE_REFERENCES")) {
            fs::copy_file(played_->folder / (std::string(name) + ".png"), reference,
                          fs::copy_options::overwrite_existing);
            continue;
        }
        const Difference d = difference(picture(name), read_png(reference));
        EXPECT_LT(d.mean, kMeanMost);
        EXPECT_LT(d.share, kShareMost);
    }
}

TEST_F(ViewerWindow, every_control_changes_the_picture) {
    const std::pair<const char*, const char*> unlike[] = {
        {"start", "settled"},   {"settled", "pushed"}, {"pushed", "pulled_back"},
        {"disturbed", "slice"}, {"slice", "volume"},   {"volume", "lines"},
        {"lines", "cab"},       {"cab", "orbit"},      {"orbit", "dug"},
        {"dug", "plots"},       {"plots", "times"},    {"loaded", "reset"},
        {"reset", "bare"}};
    for (const auto& [before, after] : unlike) {
        EXPECT_GT(difference(picture(before), picture(after)).share, 0.001)
            << before << " and " << after;
    }
}

// Gravel of 4 deg runs level where a hand and a brush had left heaps; of its own angle again it
// lies as it lies, and its sliders say what the scene says.
TEST_F(ViewerWindow, sliders_of_the_soil_change_it_while_it_runs) {
    EXPECT_GT(difference(picture("dug"), picture("flowing")).share, 0.05);
    const double panel_alone = difference(picture("flowing"), picture("as_it_was")).share;
    EXPECT_GT(panel_alone, 0.0005);
    EXPECT_EQ(played_->log().find("cannot change"), std::string::npos) << played_->log();
}

TEST_F(ViewerWindow, reset_begins_again_with_the_same_bits) {
    // The panel is at the same tab, the pointer is nowhere: every pixel has to be the same.
    EXPECT_EQ(picture("start").rgb, picture("reset").rgb);
}

TEST_F(ViewerWindow, load_brings_back_what_save_wrote) {
    // Only the line that says so, and the plots, differ: a corner of the window.
    const Difference d = difference(picture("loaded"), picture("pulled_back"));
    EXPECT_LT(d.share, 0.05);
}

TEST(ViewScripts, mistakes_are_named_with_their_line) {
    // By the command: what a person sees.
    if (std::system("command -v xvfb-run >/dev/null") != 0) {
        GTEST_SKIP() << "no xvfb-run";
    }
    const fs::path folder = fs::path(BSOIL_VIEWER_OUT) / "mistakes";
    fs::create_directories(folder);
    const auto run = [&](const std::string& script) {
        std::ofstream(folder / "script.txt") << script;
        const std::string command =
            under_display() + "view '" BSOIL_VIEWER_TESTS "/play.toml' --backend cpu --script '" +
            (folder / "script.txt").string() + "' > '" + (folder / "log.txt").string() + "' 2>&1";
        const int exit_code = WEXITSTATUS(std::system(command.c_str()));
        std::ifstream file(folder / "log.txt");
        std::stringstream text;
        text << file.rdbuf();
        return std::pair(exit_code, text.str());
    };
    const auto [bad_verb, verb_text] = run("frames 1\npush Run\n");
    EXPECT_EQ(bad_verb, 2);
    EXPECT_NE(verb_text.find("script.txt:2: no action `push`"), std::string::npos) << verb_text;
    const auto [bad_name, name_text] = run("frames 2\nclick Fly\n");
    EXPECT_EQ(bad_name, 2);
    EXPECT_NE(name_text.find("script.txt:2: no widget `Fly` is shown"), std::string::npos)
        << name_text;
}

TEST(ViewCommand, steps_in_the_window_are_those_of_a_run) {
    if (std::system("command -v xvfb-run >/dev/null") != 0) {
        GTEST_SKIP() << "no xvfb-run";
    }
    const fs::path folder = fs::path(BSOIL_VIEWER_OUT) / "steps";
    fs::create_directories(folder);
    std::ofstream(folder / "script.txt") << "frames 2\nsteps 60\nkey F5\nframes 2\n";
    const auto run = [&](const std::string& command) {
        EXPECT_EQ(
            std::system(("cd '" + folder.string() + "' && " + command + " > log.txt 2>&1").c_str()),
            0)
            << command;
    };
    const std::string scene = "'" BSOIL_VIEWER_TESTS "/play.toml' --backend cpu";
    run(under_display() + "view " + scene + " --script script.txt");
    run("'" BSOIL_COMMAND "' run " + scene + " --steps 60 --out run");
    // All voxels, and all bodies where they are: bit for bit.
    for (const std::string ending : {"vti", "obj"}) {
        std::string bytes[2];
        for (const int i : {0, 1}) {
            const std::string snapshot = i == 0 ? "view.snapshot" : "run/final.snapshot";
            const std::string file = (i == 0 ? "view." : "run.") + ending;
            run("'" BSOIL_COMMAND "' export " + snapshot + " --backend cpu --out " + file);
            std::ifstream exported(folder / file, std::ios::binary);
            bytes[i].assign(std::istreambuf_iterator<char>(exported), {});
        }
        EXPECT_GT(bytes[0].size(), 1000u);
        EXPECT_TRUE(bytes[0] == bytes[1]) << ending;
    }
}

TEST(ViewCommand, drives_a_raycast_vehicle) {
    if (std::system("command -v xvfb-run >/dev/null") != 0) {
        GTEST_SKIP() << "no xvfb-run";
    }
    const fs::path folder = fs::path(BSOIL_VIEWER_OUT) / "car";
    fs::create_directories(folder);
    std::ofstream(folder / "script.txt")
        << "frames 2\nsteps 60\nscreenshot stood.png\nsteps 30\nscreenshot still.png\n"
           "hold Up 60\nscreenshot ahead.png\nclick Drive\nslide Steering 1\nhold Up 40\n"
           "screenshot turned.png\nslide Brake 1\nslide Throttle 0.5\nsteps 60\n"
           "screenshot braked.png\nsteps 20\nscreenshot held.png\n";
    const std::string command = "cd '" + folder.string() + "' && " +
                                under_display("-s '-screen 0 1280x1024x24'") +
                                "view '" BSOIL_VIEWER_TESTS
                                "/car.toml' --script script.txt --backend cpu --width 800 --height "
                                "560 > log.txt 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
    const auto share = [&folder](const char* a, const char* b) {
        return difference(read_png(folder / a), read_png(folder / b)).share;
    };
    // The line that counts the steps changes; a car that drives off changes whole percents.
    EXPECT_LT(share("stood.png", "still.png"), 0.005);
    EXPECT_GT(share("still.png", "ahead.png"), 0.02);
    EXPECT_GT(share("ahead.png", "turned.png"), 0.02);
    EXPECT_LT(share("braked.png", "held.png"), 0.005);
}

/// Exit code and words of the window's command without a display: what is wrong before there is
/// one.
std::pair<int, std::string> without_display(const std::string& arguments) {
    const fs::path log = BSOIL_VIEWER_OUT ".log";
    const std::string command =
        "env -u DISPLAY -u WAYLAND_DISPLAY SDL_VIDEODRIVER=x11 '" BSOIL_COMMAND
        "' view '" BSOIL_VIEWER_TESTS "/play.toml' " +
        arguments + " > '" + log.string() + "' 2>&1";
    const int exit_code = WEXITSTATUS(std::system(command.c_str()));
    std::ifstream file(log);
    std::stringstream text;
    text << file.rdbuf();
    return {exit_code, text.str()};
}

TEST(ViewScripts, words_that_are_no_numbers_are_named_with_their_line) {
    fs::create_directories(BSOIL_VIEWER_OUT);
    const std::string script = BSOIL_VIEWER_OUT "/words.txt";
    const auto expect = [&](const std::string& line, const std::string& words) {
        std::ofstream(script) << "frames 1\n" << line << '\n';
        const auto [exit_code, text] = without_display("--script '" + script + "'");
        EXPECT_EQ(exit_code, 2) << line;
        EXPECT_NE(text.find("words.txt:2: " + words), std::string::npos) << text;
    };
    expect("steps 3O", "`3O` is no whole number from 1 to 100000");
    expect("frames 0", "`0` is no whole number");
    expect("hold A 1e30", "`1e30` is no whole number");
    expect("slide At nan", "`nan` is no number");
    expect("drag Left 0 0 1 1", "`Left` is none of left, right and middle");
}

TEST(ViewCommand, says_that_there_is_no_display) {
    fs::create_directories(BSOIL_VIEWER_OUT);
    const auto [exit_code, text] = without_display("");
    EXPECT_EQ(exit_code, 2);
    EXPECT_EQ(text.rfind("a window needs a display", 0), 0u) << text;
}

TEST(ViewCommand, a_snapshot_that_cannot_be_read_is_no_start) {
    fs::create_directories(BSOIL_VIEWER_OUT);
    const auto [exit_code, text] = without_display("--from /no/such/file.snapshot");
    EXPECT_EQ(exit_code, 2);
    EXPECT_NE(text.find("/no/such/file.snapshot"), std::string::npos) << text;
}

/// A sphere of 2 kg in a world of Bullet's.
struct World {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld bullet{&dispatcher, &broadphase, &solver, &configuration};
    btSphereShape shape{btScalar(0.5)};
    btRigidBody body{
        btRigidBody::btRigidBodyConstructionInfo(2, nullptr, &shape, btVector3(1, 1, 1))};
    World() {
        bullet.setGravity({0, 0, -10});
        bullet.addRigidBody(&body);
    }
    ~World() { bullet.removeRigidBody(&body); }
};

TEST(Hand, is_as_strong_in_substeps_of_any_length) {
    for (const double substep_s : {1.0 / 240, 1.0 / 1000, 0.02}) {
        World world;
        Hand hand(world.bullet, substep_s);
        ASSERT_TRUE(hand.take({&world.body, {0, 0, 0}}));
        hand.move_to({1000, 0, 0});
        world.bullet.stepSimulation(static_cast<btScalar>(substep_s), 0);
        // 40 times its weight is 400 m/s2.
        const double speed_m_s = static_cast<double>(world.body.getLinearVelocity().x());
        EXPECT_NEAR(speed_m_s / substep_s, 400, 4) << substep_s;
        hand.let_go();
    }
}

TEST(Hand, leaves_a_body_that_never_sleeps_as_it_was) {
    World world;
    Hand hand(world.bullet, 1.0 / 240);
    for (const auto& [before, after] :
         {std::pair{DISABLE_DEACTIVATION, DISABLE_DEACTIVATION}, {ISLAND_SLEEPING, ACTIVE_TAG}}) {
        world.body.forceActivationState(before);
        ASSERT_TRUE(hand.take({&world.body, {0, 0, 0}}));
        EXPECT_EQ(world.body.getActivationState(), DISABLE_DEACTIVATION);
        hand.let_go();
        EXPECT_EQ(world.body.getActivationState(), after);
    }
}

scene::Scene parsed(const std::string& text) {
    auto scene = scene::parse_scene(text, "s.toml");
    EXPECT_TRUE(scene) << scene.error();
    return scene ? *scene : scene::Scene{};
}

std::string wheel(const std::string& name, double x, double y, const std::string& axis) {
    std::ostringstream text;
    text << "[[body]]\nname = \"" << name
         << "\"\nshape = \"cylinder\"\nradius_m = 0.3\nheight_m = 0.2\naxis = \"y\"\nmass_kg = 10\n"
         << "position_m = [" << x << ", " << y << ", 0.3]\n"
         << "[[joint]]\nname = \"" << name << "\"\nkind = \"hinge\"\nparent = \"frame\"\nchild = \""
         << name << "\"\npoint_m = [" << x << ", " << y << ", 0.3]\naxis = " << axis
         << "\nmotor_torque_n_m = 100\n";
    return text.str();
}

TEST(Levers, wheels_roll_forward_together_and_turn_by_their_sides) {
    const scene::Scene scene = parsed(
        "[world]\nduration_s = 1\n[[body]]\nname = \"frame\"\nshape = \"box\"\nsize_m = [1, 1, "
        "0.2]\nmass_kg = 50\nposition_m = [0, 0, 0.5]\n" +
        wheel("left", 0, 0.6, "[0, 1, 0]") + wheel("right", 0, -0.6, "[0, -1, 0]") +
        wheel("third", 1, 0.6, "[0, 1, 0]"));
    const std::vector<Lever> levers = find_levers(scene);
    ASSERT_EQ(levers.size(), 3u);
    for (const Lever& lever : levers) EXPECT_TRUE(lever.is_wheel());
    // Axes point against each other: so do the speeds of one throttle.
    EXPECT_DOUBLE_EQ(wheel_speed(levers[0], 1, 0), -wheel_speed(levers[1], 1, 0));
    EXPECT_DOUBLE_EQ(wheel_speed(levers[0], 1, 0), wheel_speed(levers[2], 1, 0));
    // To the left: the left side stands, at half of each, and the right one runs.
    EXPECT_DOUBLE_EQ(wheel_speed(levers[0], 0.5, 0.5), 0);
    EXPECT_DOUBLE_EQ(std::abs(wheel_speed(levers[1], 0.5, 0.5)), levers[1].speed);
}

TEST(Levers, an_arm_is_as_fast_as_its_scene_drives_it) {
    const scene::Scene scene = parsed(
        "[world]\nduration_s = 9\n[[body]]\nname = \"arm\"\nshape = \"box\"\nsize_m = [1, 0.1, "
        "0.1]\nmass_kg = 10\n[[joint]]\nname = \"j\"\nkind = \"hinge\"\nparent = \"world\"\nchild "
        "= "
        "\"arm\"\npoint_m = [0, 0, 0]\naxis = [0, 0, 1]\nlower_deg = -90\nupper_deg = 90\n"
        "motor_torque_n_m = 10\n[[motion]]\njoint = \"j\"\ninterpolation = \"linear\"\nkey = [{ "
        "t_s "
        "= 0, position_deg = 0 }, { t_s = 2, position_deg = 60 }]\n");
    const std::vector<Lever> levers = find_levers(scene);
    ASSERT_EQ(levers.size(), 1u);
    EXPECT_FALSE(levers[0].is_wheel());
    EXPECT_NEAR(levers[0].speed, 60 * 3.14159265 / 180 / 2, 1e-6);
}

TEST(CameraRig, orbit_begins_with_the_scenes_camera_and_follow_goes_along) {
    render::Camera start;
    start.eye = {4, -3, 2};
    start.target = {1, 1, 0.5};
    start.up = {0, 0, 1};
    CameraRig rig(start);
    const render::Camera first = rig.camera({});
    EXPECT_NEAR(length(first.eye - start.eye), 0, 1e-12);
    EXPECT_NEAR(length(first.target - start.target), 0, 1e-12);
    rig.turn(0.5, 0.1);
    rig.zoom(0.5);
    EXPECT_NEAR(length(rig.camera({}).eye - start.target), 0.5 * length(start.eye - start.target),
                1e-12);
    rig.reset();
    Pose body;
    rig.set_mode(CameraMode::follow, body);
    body.position = {2, 0, 1};
    EXPECT_NEAR(length(rig.camera(body).eye - (start.eye + body.position)), 0, 1e-12);
    rig.set_mode(CameraMode::orbit, body);  // stays where it has got to
    EXPECT_NEAR(length(rig.camera({}).target - (start.target + body.position)), 0, 1e-12);
    rig.set_mode(CameraMode::cab, body);
    EXPECT_NEAR(length(rig.camera(body).eye - (body.position + rig.cab_eye_m())), 0, 1e-12);
}

// A velocity or what is active ends without a change of the surface.
TEST(SurfacePatches, fields_are_coloured_until_what_has_changed_is_settled) {
    SoilDef def;
    def.size_m = {2, 1, 2};
    def.voxel_m = 0.1;
    def.backend = Backend::cpu;
    auto soil = Soil::create(def);
    ASSERT_TRUE(soil) << soil.error();
    ASSERT_TRUE((*soil)->fill(BoxFill{{{-1, 0, -1}, {1, 0.3, 1}}, ""}));
    const SoilTiles tiles(**soil);
    SurfacePatches patches(tiles, SurfaceKind::soil, Backend::cpu);
    const auto colored = [&](long long step, bool has_field) {
        std::vector<SurfacePatch> added;
        size_t count = 0;
        const std::function<void(Mesh&)> color = [&count](Mesh&) { ++count; };
        patches.collect(added, {}, has_field ? color : std::function<void(Mesh&)>(), step);
        EXPECT_EQ(count, has_field ? added.size() : 0);
        return added.size();
    };
    const size_t all = colored(1, true);
    EXPECT_GT(all, 0u);
    EXPECT_EQ(colored(2, true), all);
    EXPECT_EQ(colored(2, true), 0u) << "no step was made";
    EXPECT_EQ(colored(3, false), 0u) << "the surface is the same";
    EXPECT_EQ(colored(500, true), 0u) << "long at rest";
}

TEST(Overlay, the_ramp_grows_brighter_all_the_way) {
    double before = -1;
    for (int i = 0; i <= 20; ++i) {
        const auto c = ramp_color(i / 20.0);
        const double luminance = 0.2126 * static_cast<double>(c[0]) +
                                 0.7152 * static_cast<double>(c[1]) +
                                 0.0722 * static_cast<double>(c[2]);
        EXPECT_GT(luminance, before);
        before = luminance;
    }
}

}  // namespace
}  // namespace bsoil::viewer
