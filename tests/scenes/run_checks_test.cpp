/// What a run's checks measure, and the keys of bodies and materials that concern the soil.
#include "run/run_checks.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "reading/scene_load.h"
#include "temporary_file.h"

namespace bsoil::scene::run_checks_test {
namespace {

/// A bed of dry sand 0.2 m deep, and what else the text says.
Scene sand_scene(const std::string& more) {
    auto scene = parse_scene(
        "[world]\nduration_s = 1\nground_plane = false\n"
        "[soil]\nsize_m = [1.2, 1.2, 0.6]\nvoxel_m = 0.05\nmaterial = \"sand\"\n"
        "[[fill]]\nkind = \"box\"\nmin_m = [-0.6, -0.6, 0]\nmax_m = [0.6, 0.6, 0.2]\n" +
            more,
        "s.toml");
    EXPECT_TRUE(scene) << scene.error();
    return *scene;
}
const std::string kSand = "[[material]]\nname = \"sand\"\n";
const std::string kBlock =
    "[[body]]\nname = \"a\"\nshape = \"box\"\nsize_m = [0.3, 0.3, 0.2]\nmass_kg = 20\n"
    "position_m = [0, 0, 0.3]\n";

std::vector<CheckResult> results_of(const Scene& scene) {
    auto run = SceneRun::create(scene, {.backend = Backend::cpu, .thread_count = 1});
    EXPECT_TRUE(run) << run.error();
    if (!run) return {};
    RunChecks checks(**run);
    while (!(*run)->finished()) {
        (*run)->step();
        checks.observe();
    }
    return checks.results();
}

/// The verdict on the scene's only check; `soil_conserved` comes first.
CheckResult result_of(const std::string& scene) {
    const std::vector<CheckResult> results = results_of(sand_scene(scene));
    EXPECT_EQ(results.size(), 2u);
    return results.empty() ? CheckResult{} : results.back();
}
bool passes(const std::string& scene) {
    const CheckResult result = result_of(scene);
    EXPECT_NE(result.verdict, CheckResult::Verdict::not_reached) << result.figure;
    return result.verdict == CheckResult::Verdict::pass;
}

TEST(Steadiness, straight_line_is_steady) {
    const Steadiness s = steadiness({1, 2, 3, 4, 5});
    EXPECT_DOUBLE_EQ(s.mean, 3);
    EXPECT_NEAR(s.deviation, 0, 1e-12);
    EXPECT_NEAR(s.range, 0, 1e-12);
}

TEST(Steadiness, saw_has_its_deviation_and_range) {
    std::vector<double> saw;
    for (int i = 0; i < 1000; ++i) saw.push_back(10 + (i % 2 ? 1 : -1));
    const Steadiness s = steadiness(saw);
    EXPECT_NEAR(s.mean, 10, 1e-9);
    EXPECT_NEAR(s.deviation, 1, 1e-5);
    EXPECT_NEAR(s.range, 2, 1e-2);
}

// A pipe of 2 mm with soil that falls out of it has no room for 3 kg/s.
TEST(RunChecks, source_that_falls_short_is_a_status) {
    const auto source = [](const char* radius_m) {
        return kSand +
               "[[source]]\nshape = \"disc\"\ncenter_m = [0, 0, 0.5]\nrate_kg_s = 3\nradius_m = " +
               radius_m + "\n[[check]]\nkind = \"no_status\"\n";
    };
    EXPECT_TRUE(passes(source("0.2")));
    const CheckResult result = result_of(source("0.001"));
    EXPECT_EQ(result.verdict, CheckResult::Verdict::fail);
    EXPECT_NE(result.figure.find("source_short: a [[source]] has poured "), std::string::npos)
        << result.figure;
    EXPECT_EQ(result.figure.rfind("s.toml:", 0), 0u) << result.figure;
}

TEST(MechanicalEnergy, counts_motion_turning_and_height) {
    btBoxShape box(btVector3(1, 0.5f, 0.25f));
    btVector3 inertia;
    box.calculateLocalInertia(3, inertia);
    btRigidBody body(3, nullptr, &box, inertia);
    // a quarter turn about z brings the body's y axis to -x of the world
    body.setWorldTransform(
        btTransform(btQuaternion(btVector3(0, 0, 1), btScalar(SIMD_HALF_PI)), btVector3(0, 0, 2)));
    body.setLinearVelocity(btVector3(0, 4, 0));
    body.setAngularVelocity(btVector3(5, 0, 0));
    const double turning_j = 0.5 * static_cast<double>(inertia.y()) * 25;
    BodyItem item;
    item.mass_kg = 3;
    SceneBody in_scene;
    in_scene.item = &item;
    in_scene.object = in_scene.body = &body;
    EXPECT_NEAR(in_scene.mechanical_energy_j(btVector3(0, 0, -10)), 0.5 * 3 * 16 + 60 + turning_j,
                1e-4);
}

TEST(RunChecks, force_of_a_block_at_rest_is_its_weight) {
    const std::string check = kSand + kBlock +
                              "[[check]]\nkind = \"force_steady\"\nbody = \"a\"\nfrom_s = 0.7\n"
                              "max_deviation_fraction = 0.01\nmax_range_fraction = 0.05\n";
    EXPECT_TRUE(passes(check + "direction = [0, 0, 1]\nmin_n = 190\nmax_n = 202\n"));
    EXPECT_FALSE(passes(check + "direction = [0, 0, 1]\nmin_n = 220\n"));
    EXPECT_FALSE(passes(check + "direction = [0, 0, -1]\nmin_n = 190\n"));
}

TEST(RunChecks, rise_and_energy_see_a_body_come_up) {
    const std::string thrown = kSand + kBlock + "velocity_m_s = [0, 0, 1]\n";  // 51 mm up
    for (const bool enough : {true, false}) {
        const std::string most = enough ? "0.06" : "0.04";
        EXPECT_EQ(passes(thrown + "[[check]]\nkind = \"body_rise\"\nbody = \"a\"\nmax_m = " + most),
                  enough);
        EXPECT_EQ(passes(thrown +
                         "[[check]]\nkind = \"body_height\"\nbody = \"a\"\nto_s = 0.3\n"
                         "min_m = 0.2\nmax_m = 0." +
                         (enough ? "36" : "34")),
                  enough);
    }
    // in flight nothing rises; the motor lifts 20 kg at 0.5 m/s, 1.6 J a step of 1/60 s
    EXPECT_TRUE(passes(thrown + "[[check]]\nkind = \"energy_not_rising\"\ntolerance_j = 0.01\n"));
    const std::string lifted =
        kSand + kBlock +
        "[[joint]]\nname = \"j\"\nkind = \"slider\"\nparent = \"world\"\nchild = \"a\"\n"
        "point_m = [0, 0, 0.3]\nmotor_force_n = 1000\n"
        "[[motion]]\njoint = \"j\"\nkey = [{ t_s = 0, velocity_m_s = 0.5 }]\n"
        "[[check]]\nkind = \"energy_not_rising\"\nbodies = [\"a\"]\nfrom_s = 0.5\ntolerance_j = ";
    EXPECT_TRUE(passes(lifted + "1.8"));
    EXPECT_FALSE(passes(lifted + "1.5"));
}

TEST(RunChecks, speed_of_a_driven_body_is_steady) {
    const std::string driven =
        kSand +
        "[[body]]\nname = \"a\"\nshape = \"box\"\nsize_m = [0.1, 0.1, 0.1]\nmass_kg = 20\n"
        "position_m = [0, 0, 0.5]\n"
        "[[joint]]\nname = \"j\"\nkind = \"slider\"\nparent = \"world\"\nchild = \"a\"\n"
        "point_m = [0, 0, 0.5]\naxis = [1, 0, 0]\nmotor_force_n = 1000\n"
        "[[motion]]\njoint = \"j\"\nkey = [{ t_s = 0, velocity_m_s = 0.1 }]\n"
        "[[check]]\nkind = \"speed_steady\"\nbody = \"a\"\nmax_range_fraction = 0.01\n"
        "min_m_s = 0.099\nmax_m_s = 0.101\nfrom_s = ";
    EXPECT_TRUE(passes(driven + "0.1"));
    EXPECT_FALSE(passes(driven + "0")) << "it starts from rest";
}

// A body that had blown up was passed over by the comparisons of three of these.
TEST(RunChecks, what_is_no_number_passes_none) {
    const std::string check = "[[check]]\nbody = \"a\"\nkind = ";
    const Scene scene = sand_scene(kSand + kBlock + check + "\"body_rise\"\nmax_m = 10\n" + check +
                                   "\"body_height\"\nmin_m = -10\nmax_m = 10\n" + check +
                                   "\"speed_steady\"\nmax_deviation_fraction = 100\n" + check +
                                   "\"distance_travelled\"\nmax_m = 10\n" + check +
                                   "\"body_at_rest\"\nby_s = 0.9\n" +
                                   "[[check]]\nkind = \"energy_not_rising\"\ntolerance_j = 1e6\n");
    for (const bool blows_up : {false, true}) {
        auto run = SceneRun::create(scene, {.backend = Backend::cpu, .thread_count = 1});
        ASSERT_TRUE(run) << run.error();
        RunChecks checks(**run);
        while (!(*run)->finished()) {
            if (blows_up && (*run)->step_count() == 30) {
                btRigidBody& body = *(*run)->bullet().bodies().front().body;
                const btVector3 lost(btScalar(NAN), btScalar(NAN), btScalar(NAN));
                btTransform pose = body.getWorldTransform();
                pose.setOrigin(lost);
                body.setWorldTransform(pose);
                body.setLinearVelocity(lost);
            }
            (*run)->step();
            checks.observe();
        }
        const std::vector<CheckResult> results = checks.results();
        ASSERT_EQ(results.size(), 7u);
        for (size_t i = 1; i < results.size(); ++i) {  // behind soil_conserved
            EXPECT_EQ(results[i].verdict == CheckResult::Verdict::pass, !blows_up)
                << results[i].name << ": " << results[i].figure;
        }
    }
}

TEST(RunChecks, check_that_the_run_does_not_reach_says_so) {
    const Scene scene =
        sand_scene(kSand + kBlock + "[[check]]\nkind = \"body_rise\"\nbody = \"a\"\nmax_m = 1\n");
    auto run =
        SceneRun::create(scene, {.backend = Backend::cpu, .thread_count = 1, .step_count = 10});
    ASSERT_TRUE(run) << run.error();
    RunChecks checks(**run);
    while (!(*run)->finished()) {
        (*run)->step();
        checks.observe();
    }
    EXPECT_EQ(checks.results().back().verdict, CheckResult::Verdict::not_reached);
}

TEST(RunChecks, water_is_counted_from_the_start_in_a_run_that_goes_on) {
    Scene scene = sand_scene(kSand + "base = \"fine_sand\"\nplaced_saturation = 0.4\n");
    const RunDef def{.backend = Backend::cpu, .thread_count = 1};
    const TemporaryFile file("water.snapshot");
    auto saved = SceneRun::create(scene, def);
    ASSERT_TRUE(saved) << saved.error();
    (*saved)->step();
    ASSERT_GT((*saved)->totals_at_start().water_units, 0);
    ASSERT_TRUE((*saved)->save(file.path()));
    auto restored = SceneRun::create(scene, def);
    ASSERT_TRUE(restored) << restored.error();
    RunChecks checks(**restored);
    const Status loaded = (*restored)->load(file.path());
    ASSERT_TRUE(loaded) << loaded.error();
    EXPECT_EQ((*restored)->totals_at_start().water_units, (*saved)->totals_at_start().water_units);
    const CheckResult conserved = checks.results().front();
    EXPECT_EQ(conserved.verdict, CheckResult::Verdict::pass) << conserved.figure;
}

// `bsoil view` saves what its sliders have changed: the file fitted no run of its scene any more.
TEST(SceneRun, goes_on_with_the_soil_as_it_was_changed) {
    const Scene scene = sand_scene(kSand + kBlock);
    Scene heavier = scene;
    heavier.bodies[0].mass_kg *= 2;
    const RunDef def{.backend = Backend::cpu, .thread_count = 1};
    const TemporaryFile changed_file("changed.snapshot"), plain_file("plain.snapshot"),
        other_file("other.snapshot");
    auto saved = SceneRun::create(scene, def), restored = SceneRun::create(scene, def);
    ASSERT_TRUE(saved && restored);
    (*saved)->step();
    ASSERT_TRUE((*saved)->save(plain_file.path()));
    SoilDef changed = (*saved)->scene_soil();
    changed.wind_m_s = {1, 0, -2};
    changed.overflow = OverflowHeuristic::even;
    changed.substeps_max = 3;
    changed.materials[0].friction_angle_rad = 0.2;
    changed.materials[0].color = {0.25f, 0.5f, 1};
    ASSERT_TRUE((*saved)->soil().change(changed));
    (*saved)->step();
    ASSERT_TRUE((*saved)->save(changed_file.path()));
    const Status loaded = (*restored)->load(changed_file.path());
    ASSERT_TRUE(loaded) << loaded.error();
    const SoilDef& now = (*restored)->soil().def();
    EXPECT_EQ(length(now.wind_m_s - changed.wind_m_s), 0);
    EXPECT_EQ(now.overflow, OverflowHeuristic::even);
    EXPECT_EQ(now.substeps_max, 3);
    EXPECT_EQ(now.materials[0].friction_angle_rad, 0.2);
    EXPECT_EQ(now.materials[0].color, changed.materials[0].color);
    EXPECT_EQ((*restored)->soil().checksum(), (*saved)->soil().checksum());
    // A file that is refused leaves it so; one of the scene's own soil brings that back.
    const auto other = SceneRun::create(heavier, def);
    ASSERT_TRUE(other && (*other)->save(other_file.path()));
    EXPECT_FALSE((*restored)->load(other_file.path()));
    EXPECT_EQ((*restored)->soil().def().substeps_max, 3);
    ASSERT_TRUE((*restored)->load(plain_file.path()));
    EXPECT_EQ((*restored)->soil().def().substeps_max, (*saved)->scene_soil().substeps_max);
    EXPECT_NE((*restored)->soil().materials()[0].friction_angle_rad, 0.2);
}

// A patch without friction has a direction across it all the same. By rounding it was the normal's
// here, and the block that falls was thrown up again.
TEST(RunChecks, nothing_is_kicked_off_a_thin_layer_by_its_shape) {
    auto scene = load_scene(std::string(BSOIL_SCENES_DIR) + "/trapped_soil.toml");
    ASSERT_TRUE(scene) << scene.error();
    scene->soil->def.contact_law.faces_by_shape = true;
    for (const CheckResult& check : results_of(*scene)) {
        EXPECT_EQ(check.verdict, CheckResult::Verdict::pass) << check.name << ": " << check.figure;
    }
}

TEST(SoilKeys, body_that_ignores_soil_falls_through_it) {
    const std::string check =
        "[[check]]\nkind = \"body_height\"\nbody = \"a\"\nfrom_s = 0.9\nmax_m = -1\n";
    EXPECT_TRUE(passes(kSand + kBlock + "ignore_soil = true\n" + check));
    EXPECT_FALSE(passes(kSand + kBlock + check));
}

TEST(SoilKeys, smooth_body_slides_on_where_a_rough_one_stops) {
    const std::string shoved = kBlock + "velocity_m_s = [0.5, 0, 0]\n";
    const std::string check =
        "[[check]]\nkind = \"distance_travelled\"\nbody = \"a\"\nmin_m = 0.12\n";
    // 0.4 g of friction stop it within 0.03 m; the sand's own strength bounds adhesion
    EXPECT_FALSE(passes(kSand + shoved + check));
    EXPECT_TRUE(passes(kSand + shoved + "tool_friction = 0.05\n" + check));
    EXPECT_TRUE(passes(kSand + "tool_friction = 0.05\n" + shoved + check));
    EXPECT_FALSE(passes(kSand + "cohesion_pa = 2000\ntool_friction = 0.05\n" + shoved +
                        "tool_adhesion_pa = 2000\n" + check));
}

TEST(SoilKeys, material_takes_what_its_table_gives) {
    const Scene scene = sand_scene(
        "[[material]]\nname = \"sand\"\ndensity_kg_m3 = 1500\nloose_density_kg_m3 = 1400\n"
        "compacted_density_kg_m3 = 1700\ntool_adhesion_pa = 100\nshear_displacement_m = 0.02\n"
        "loose_cohesion_fraction = 0.3\ncohesion_pa = 500\n");
    const MaterialDef& def = scene.soil->def.materials.front();
    EXPECT_EQ(def.density_kg_m3, 1500);
    EXPECT_EQ(def.loose_density_kg_m3, 1400);
    EXPECT_EQ(def.compacted_density_kg_m3, 1700);
    EXPECT_EQ(def.cohesion_pa, 500);
    EXPECT_EQ(def.loose_cohesion_fraction, 0.3);
    EXPECT_EQ(def.tool_adhesion_pa, 100);
    EXPECT_EQ(def.shear_displacement_m, 0.02);
}

TEST(SoilKeys, density_given_alone_is_that_of_loose_soil) {
    const auto range = [](const std::string& keys) {
        const Scene scene = sand_scene("[[material]]\nname = \"sand\"\n" + keys);
        const MaterialDef& def = scene.soil->def.materials.front();
        return std::array{def.loose_density_kg_m3, def.density_kg_m3, def.compacted_density_kg_m3};
    };
    using Range = std::array<double, 3>;
    EXPECT_EQ(range("density_kg_m3 = 1500\n"), (Range{1500, 1500, 1875}));
    EXPECT_EQ(range(""), (Range{1430, 1600, 1750}));
    EXPECT_EQ(range("density_kg_m3 = 1500\nloose_density_kg_m3 = 0\n"
                    "compacted_density_kg_m3 = 0\n"),
              (Range{0, 1500, 0}));
    // No material is denser than 4000 kg/m3.
    EXPECT_EQ(range("density_kg_m3 = 3800\n"), (Range{3800, 3800, 4000}));
    EXPECT_EQ(range("density_kg_m3 = 4000\n"), (Range{0, 4000, 0}));
}

}  // namespace
}  // namespace bsoil::scene::run_checks_test
