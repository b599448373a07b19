/// The rigs themselves: without soil they measure what statics says, with it the results do not
/// depend on the number of cores.
#include <gtest/gtest.h>

#include <cmath>

#include "experiment/experiment_load.h"
#include "experiment/rig.h"
#include "experiment/sweep_run.h"

namespace bsoil::experiment::rigs_test {
namespace {

CsvTable results_of(const std::string& text, const std::string& rig, int thread_count = 1) {
    const auto experiment = parse_experiment(text, "e.toml", rig);
    EXPECT_TRUE(experiment) << experiment.error();
    if (!experiment) return {};
    const auto runs = run_sweep(*experiment, thread_count, {});
    for (const PointRun& run : runs) EXPECT_EQ(run.error, "");
    return result_table(*experiment, runs);
}

// Bullet's floats carry 7 digits of forces up to some hundred newtons.
constexpr double kForceTolerance = 0.01;

TEST(Rigs, plate_in_the_air_weighs_nothing) {
    for (const char* shape :
         {"circle", "rectangle", "cone",
          "hull\"\npoints_m = [[0, 0, -0.1], [0.1, 0, 0], [-0.1, 0.1, 0], [-0.1, -0.1, 0]] #"}) {
        const CsvTable table = results_of(
            std::string("[plate]\nreach_m = [0.02]\nunload = true\nmass_kg = 12\nshape = \"") +
                shape + "\"\n",
            "plate");
        ASSERT_EQ(table.rows.size(), 1u);
        EXPECT_NEAR(*table.number(0, "force_n"), 0, kForceTolerance) << shape;
        EXPECT_DOUBLE_EQ(*table.number(0, "sinkage_m"), 0.02);
    }
}

TEST(Rigs, blade_in_the_air_has_no_draft_and_no_lift) {
    const CsvTable table =
        results_of("[blade]\nrake_deg = 60\ntravel_m = 0.3\nwindow_from_m = 0.1\n", "blade");
    EXPECT_NEAR(*table.number(0, "draft_n"), 0, kForceTolerance);
    EXPECT_NEAR(*table.number(0, "lift_n"), 0, kForceTolerance);
}

TEST(Rigs, wheel_hanging_free_measures_nothing) {
    const CsvTable table = results_of(
        "[traction]\nslip_ratio = 0.3\nslip_angle_deg = 20\ngrouser_count = 7\ntravel_m = 0.1\n"
        "window_from_m = 0.05\n",
        "traction");
    for (const char* column : {"drawbar_pull_n", "side_force_n", "vertical_load_n", "torque_n_m"}) {
        EXPECT_NEAR(*table.number(0, column), 0, kForceTolerance) << column;
    }
}

TEST(Rigs, wheel_on_a_rigid_plane_pulls_with_coulomb_friction) {
    // locked, spinning, and locked across the travel: 0.6 * 50 N against the motion of the rim
    const CsvTable table = results_of(
        "[world]\nground_plane = true\n"
        "[traction]\nload_n = 50\nfriction = 0.6\nradius_m = 0.1\ntravel_m = 0.1\n"
        "window_from_m = 0.05\n"
        "[sweep]\nrow = [{slip_ratio = -1, slip_angle_deg = 0}, {slip_ratio = 0.5, "
        "slip_angle_deg = 0}, {slip_ratio = -1, slip_angle_deg = 30}]\n",
        "traction");
    const double pull[] = {-30, 30, -30};
    // the motor drives the spinning wheel and holds the locked one; a yawed one slides along
    // its axle as well
    const double torque[] = {-3, 3, -3 * std::cos(30 * 3.14159265 / 180)};
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(*table.number(i, "drawbar_pull_n"), pull[i], 0.05);
        EXPECT_NEAR(*table.number(i, "side_force_n"), 0, 0.05);
        EXPECT_NEAR(*table.number(i, "torque_n_m"), torque[i], 0.02);
        EXPECT_NEAR(*table.number(i, "vertical_load_n"), 50, kForceTolerance);
        EXPECT_NEAR(*table.number(i, "sinkage_m"), 0, 1e-4);
    }
    // a wheel heading to its left slides to its right: the ground pushes it left
    EXPECT_NEAR(*table.number(2, "lateral_n"), 15, 0.05);
    EXPECT_NEAR(*table.number(2, "tractive_n"), -30 * std::cos(30 * 3.14159265 / 180), 0.05);
}

// Coulomb's friction is the same at any slip: it tells which way the rim slides, and the carriage
// how far it does.
TEST(Rigs, held_rim_speed_gives_the_same_slip) {
    struct Case {
        const char *slip_ratio, *held;
        double travel_m, pull_n;
    };
    for (const Case& c : {Case{"0.5", "travel", 0.1, 20}, Case{"0.5", "rim", 0.05, 20},
                          Case{"-0.5", "travel", 0.1, -20}, Case{"-0.5", "rim", 0.2, -20}}) {
        const auto experiment = parse_experiment(
            std::string("[world]\nground_plane = true\n[traction]\ntravel_m = 0.1\n"
                        "window_from_m = 0.05\nload_n = 40\nslip_ratio = ") +
                c.slip_ratio + "\nheld = \"" + c.held + "\"\n",
            "e.toml", "traction");
        ASSERT_TRUE(experiment) << experiment.error();
        const auto run = run_rig(experiment->points[0].setup, [](double) {});
        ASSERT_TRUE(run) << run.error();
        EXPECT_NEAR(run->results[0][0], c.pull_n, 0.05) << c.slip_ratio << ' ' << c.held;
        EXPECT_NEAR(run->series.back()[1], c.travel_m, 1e-3) << c.slip_ratio << ' ' << c.held;
    }
}

TEST(Rigs, shear_heads_on_a_rigid_plane_show_coulomb_friction) {
    const std::string head =
        "[world]\nground_plane = true\n[shear]\nfriction = 0.6\n"
        "grouser_count = 0\nsettle_s = 0.2\ndisplacement_m = 0.02\n"
        "normal_stress_pa = 10000\nhead = ";
    const CsvTable box = results_of(head + "\"box\"\n", "shear");
    EXPECT_EQ(box.rows.size(), 10u);
    EXPECT_NEAR(*box.number(9, "shear_stress_pa"), 6000, 10);
    EXPECT_NEAR(*box.number(9, "normal_stress_pa"), 10000, 10);
    EXPECT_NEAR(*box.number(9, "displacement_m"), 0.02, 1e-6);
    // Bullet keeps a few contacts of each sector, whose arms and friction directions are not
    // those of an even stress
    const CsvTable annulus = results_of(head + "\"annulus\"\n", "shear");
    EXPECT_NEAR(*annulus.number(9, "shear_stress_pa"), 6000, 400);
    EXPECT_NEAR(*annulus.number(9, "normal_stress_pa"), 10000, 10);
}

const std::string kSmallBed =
    "[soil]\nsize_m = [0.4, 0.3, 0.3]\nvoxel_m = 0.02\nstep_s = 0.02\n"
    "[world]\nsubstep_s = 0.005\n[bed]\ndepth_m = 0.2\n";

TEST(Rigs, results_do_not_depend_on_the_number_of_cores) {
    const std::string text = kSmallBed +
                             "[plate]\nradius_m = 0.06\nspeed_m_s = 0.05\nreach_m = [0.02, 0.04]\n"
                             "unload = true\n[sweep]\nsoil.voxel_m = [0.02, 0.025, 0.03]\n";
    const CsvTable one = results_of(text, "plate", 1), two = results_of(text, "plate", 2);
    ASSERT_EQ(one.rows.size(), 6u);
    EXPECT_EQ(one.rows, two.rows);
    EXPECT_GT(*one.number(0, "force_n"), 1);
}

// Its rim's voxels reach half a voxel and more beyond its radius: three voxels had run out by 0.138
// of it.
TEST(Rigs, column_that_stands_has_not_run_out) {
    const CsvTable table = results_of(
        "[soil]\nsize_m = [1.6, 1.6, 0.8]\nvoxel_m = 0.1\nmaterial = \"soil\"\n"
        "[[material]]\nname = \"soil\"\nbase = \"dry_sand\"\ncohesion_pa = 200000\n"
        "loose_cohesion_fraction = 1\n[column]\nradius_m = 0.3\nheight_m = 0.6\n",
        "column");
    ASSERT_EQ(table.rows.size(), 1u);
    EXPECT_DOUBLE_EQ(*table.number(0, "slope_deg"), 90);
    EXPECT_DOUBLE_EQ(*table.number(0, "run_out"), 0);
}

// Six steps are no time to come to rest in.
TEST(Rigs, heap_that_still_moves_at_the_end_fails) {
    for (const char* duration_s : {"0.1", "20"}) {
        const auto experiment = parse_experiment(
            "[soil]\nsize_m = [1.6, 1.6, 0.5]\nvoxel_m = 0.1\n[column]\nradius_m = 0.2\n"
            "height_m = 0.4\nduration_s = " +
                std::string(duration_s) + "\n",
            "e.toml", "column");
        ASSERT_TRUE(experiment) << experiment.error();
        const auto verdicts = verdicts_on(run_sweep(*experiment, 1, {}));
        ASSERT_EQ(verdicts.size(), duration_s[0] == '0' ? 1u : 0u) << duration_s;
        if (verdicts.empty()) continue;
        EXPECT_EQ(verdicts[0].kind, Verdict::Kind::fail);
        EXPECT_EQ(verdicts[0].text.find("point 0: moving"), 0u) << verdicts[0].text;
    }
}

TEST(Rigs, unloaded_plate_carries_nothing) {
    const auto experiment = parse_experiment(
        kSmallBed + "[plate]\nradius_m = 0.06\nspeed_m_s = 0.05\nreach_m = [0.03]\nunload = true\n",
        "e.toml", "plate");
    ASSERT_TRUE(experiment) << experiment.error();
    const auto run = run_rig(experiment->points[0].setup, [](double) {});
    ASSERT_TRUE(run) << run.error();
    double peak_n = 0;
    for (const auto& row : run->series) peak_n = std::max(peak_n, row[2]);
    EXPECT_GT(peak_n, 1);
    EXPECT_LT(run->series.back()[2], 1e-3 * peak_n);
}

TEST(Rigs, wheel_on_soil_carries_its_load) {
    const CsvTable table = results_of(
        kSmallBed +
            "[traction]\nload_n = 40\nspeed_m_s = 0.05\ntravel_m = 0.15\nwindow_from_m = 0.05\n"
            "settle_s = 0.5\n",
        "traction");
    EXPECT_NEAR(*table.number(0, "vertical_load_n"), 40, 2);  // what it still rises or sinks
    EXPECT_GT(*table.number(0, "sinkage_m"), 0);
}

}  // namespace
}  // namespace bsoil::experiment::rigs_test
