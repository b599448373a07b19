/// Mistakes in experiment files: each is reported with its place and the way out.
#include <gtest/gtest.h>

#include <filesystem>

#include "cure.h"
#include "experiment/experiment_load.h"

namespace bsoil::experiment::experiment_errors_test {
namespace {

const std::string kPlate = "[plate]\nreach_m = [0.01]\n";  // lines 1 and 2

std::string errors_of(const std::string& text, const std::string& rig = "plate") {
    const auto experiment = parse_experiment(text, "e.toml", rig);
    return experiment ? "no error" : experiment.error();
}

/// The experiment is the plate above with `more` from line 3 on.
void expect_error(const std::string& more, const std::string& expected) {
    const std::string errors = errors_of(kPlate + more);
    EXPECT_NE(errors.find(expected), std::string::npos)
        << "expected: " << expected << "\nfound:    " << errors;
    EXPECT_TRUE(says_what_to_do(errors)) << errors;
}

TEST(ExperimentErrors, smallest_experiment_is_valid) { EXPECT_EQ(errors_of(kPlate), "no error"); }

TEST(ExperimentErrors, syntax_error_has_its_place) { expect_error("[soil\n", "e.toml:3:6: "); }

TEST(ExperimentErrors, file_of_another_rig_names_its_command) {
    EXPECT_NE(errors_of(kPlate, "blade").find("this is an experiment for `bsoil plate`"),
              std::string::npos);
    expect_error("[blade]\ndepth_m = 0.1\n", "must have one of the tables");
}

TEST(ExperimentErrors, unknown_key_suggests_the_nearest) {
    expect_error("radus_m = 0.1\n",
                 "e.toml:3:1: unknown key `radus_m` in [plate]; did you mean `radius_m`?");
    expect_error("[swep]\n", "unknown key `swep` in an experiment; did you mean `sweep`?");
    expect_error("radius_cm = 3\n", "the key is `radius_m`: radius_m = 0.03");
}

TEST(ExperimentErrors, value_of_a_sweep_is_checked_like_that_of_the_key) {
    expect_error("[sweep]\nradius_m = [0.1, 1000]\n",
                 "e.toml:4:18: `radius_m`: 1000 is out of range 0.001 .. 100 (at radius_m = 1000)");
    expect_error("[sweep]\nradus_m = [0.1]\n", "did you mean `radius_m`?");
    expect_error("[sweep]\nradius_m = 0.1\n", "e.toml:4:12: `radius_m`: expected a list of values");
    expect_error("[soil]\nsize_m = [1, 1, 1]\n[sweep]\nsoil.voxel_m = [0.02, 20]\n",
                 "`voxel_m`: 20 is out of range");
}

TEST(ExperimentErrors, rows_of_a_sweep_give_the_same_parameters) {
    expect_error("[sweep]\nrow = [{radius_m = 0.1}, {speed_m_s = 0.1}]\n",
                 "every row of a sweep must give the same parameters");
}

TEST(ExperimentErrors, columns_are_parameters_or_results) {
    expect_error("[[plot]]\nx = \"sinkage\"\ny = \"force_n\"\n",
                 "e.toml:4:5: \"sinkage\" is no parameter of the sweep and no result");
    expect_error("[[expect]]\ncolumn = \"draft_n\"\nmin = 0\n", "\"draft_n\" is no parameter");
    expect_error("[[expect]]\ncolumn = \"force_n\"\nvalue = 0\n", "belong together");
    expect_error("[[expect]]\ncolumn = \"force_n\"\n", "needs `value`, `min` or `max`");
}

TEST(ExperimentErrors, rig_has_to_fit_the_bed) {
    EXPECT_NE(errors_of("[soil]\nsize_m = [1, 1, 1]\n[bed]\ndepth_m = 2\n" + kPlate)
                  .find("e.toml:4:11: `depth_m`: the bed must not be deeper"),
              std::string::npos);
    EXPECT_NE(errors_of("[soil]\nsize_m = [1, 1, 1]\n[blade]\ntravel_m = 2\n", "blade")
                  .find("`travel_m`: the bed is only 1 m long"),
              std::string::npos);
    EXPECT_NE(errors_of("[traction]\nslip_ratio = 1\n", "traction").find("has no end"),
              std::string::npos);
    expect_error("[soil]\nsize_m = [1, 1, 0.5]\n[bed]\ndepth_m = 0.01\n",
                 "e.toml:2:11: `reach_m`: the plate goes deeper than the bed");
}

// A braked wheel whose rim's speed is held goes farther than the rim rolls; a turned bed is as long
// as it is along the travel.
TEST(ExperimentErrors, ways_end_within_the_bed) {
    const std::string wheel = "[soil]\nsize_m = [1.2, 0.6, 0.4]\n[traction]\ntravel_m = 0.5\n";
    EXPECT_EQ(errors_of(wheel + "held = \"rim\"\nslip_ratio = -0.5\n", "traction"), "no error");
    EXPECT_NE(errors_of(wheel + "held = \"rim\"\nslip_ratio = -0.9\n", "traction")
                  .find("`travel_m`: the bed is only 1.2 m long"),
              std::string::npos);
    EXPECT_EQ(errors_of("[soil]\nyaw_deg = 90\nsize_m = [0.6, 1.2, 0.4]\n[blade]\ntravel_m = 1\n",
                        "blade"),
              "no error");
    EXPECT_NE(errors_of("[soil]\nyaw_deg = 90\nsize_m = [1.2, 0.6, 0.4]\n[blade]\ntravel_m = 1\n",
                        "blade")
                  .find("the bed is only 0.6 m long"),
              std::string::npos);
    EXPECT_NE(errors_of("[soil]\nsize_m = [0.3, 0.6, 0.4]\n[shear]\nhead = \"box\"\n"
                        "displacement_m = 0.5\n",
                        "shear")
                  .find("`displacement_m`: the bed is only 0.3 m long"),
              std::string::npos);
}

TEST(ExperimentErrors, absent_data_is_no_error) {
    const auto beside =
        parse_experiment(kPlate +
                             "[measured]\nfile = \"data:terramechanics/nowhere.csv\"\n"
                             "column = [{name = \"force_n\", column = \"F\"}]\n",
                         "e.toml", "plate");
    ASSERT_TRUE(beside) << beside.error();
    EXPECT_EQ(beside->points.size(), 1u);
    EXPECT_FALSE(beside->missing_data.empty());
    const auto needed = parse_experiment(
        "[sweep]\nfrom_measured = [\"radius_m\"]\n[measured]\nfile = \"data:nowhere.csv\"\n"
        "column = [{name = \"radius_m\", column = \"r\"}]\n" +
            kPlate,
        "e.toml", "plate");
    ASSERT_TRUE(needed) << needed.error();
    EXPECT_TRUE(needed->points_are_missing);
}

TEST(ExperimentErrors, sweep_combines_lists_in_the_order_of_the_file) {
    const auto made =
        parse_experiment(kPlate + "[sweep]\nspeed_m_s = [0.01, 0.02]\nradius_m = [0.1, 0.2, 0.3]\n",
                         "e.toml", "plate");
    ASSERT_TRUE(made) << made.error();
    ASSERT_EQ(made->points.size(), 6u);
    EXPECT_EQ(made->points[0].parameters[0].name, "speed_m_s");
    EXPECT_EQ(made->points[1].parameters[1].text, "0.2");
    EXPECT_EQ(std::get<PlateItem>(made->points[4].setup.rig).radius_m, 0.2);
    EXPECT_EQ(std::get<PlateItem>(made->points[4].setup.rig).speed_m_s, 0.02);
}

TEST(ExperimentErrors, flags_are_swept_and_set_like_other_values) {
    const std::string sweep = kPlate + "[sweep]\nunload = [true, false]\n";
    const auto swept = parse_experiment(sweep, "e.toml", "plate");
    ASSERT_TRUE(swept) << swept.error();
    ASSERT_EQ(swept->points.size(), 2u);
    EXPECT_TRUE(std::get<PlateItem>(swept->points[0].setup.rig).unload);
    EXPECT_FALSE(std::get<PlateItem>(swept->points[1].setup.rig).unload);
    EXPECT_EQ(swept->points[1].parameters[0].text, "false");
    const auto set = parse_experiment(kPlate, "e.toml", "plate", {"unload=true"});
    ASSERT_TRUE(set) << set.error();
    EXPECT_TRUE(std::get<PlateItem>(set->points[0].setup.rig).unload);
}

TEST(ExperimentErrors, what_a_sweep_gives_cannot_be_set) {
    const std::string sweep = kPlate + "[sweep]\nradius_m = [0.1, 0.2]\n";
    for (const char* name : {"radius_m", "plate.radius_m"}) {
        const auto made = parse_experiment(sweep, "e.toml", "plate", {name + std::string("=0.3")});
        EXPECT_NE(made.error().find("cannot be set: [sweep] gives it its values"),
                  std::string::npos);
    }
    EXPECT_TRUE(parse_experiment(sweep, "e.toml", "plate", {"speed_m_s=0.3"}));
}

TEST(ExperimentErrors, every_experiment_of_the_project_is_valid) {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(BSOIL_EXPERIMENTS_DIR)) {
        if (entry.path().extension() != ".toml") continue;
        ++count;
        bool valid = false;
        std::string errors;
        for (const char* rig : {"plate", "blade", "traction", "shear", "column"}) {
            const auto made = load_experiment(entry.path().string(), rig);
            valid |= made.ok();
            if (!made) errors += made.error() + '\n';
        }
        EXPECT_TRUE(valid) << errors;
    }
    EXPECT_GT(count, 0);
}

}  // namespace
}  // namespace bsoil::experiment::experiment_errors_test
