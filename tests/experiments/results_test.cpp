/// What becomes of the results of a sweep: tables, comparison with measurements, verdicts, plots.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "experiment/expectation.h"
#include "experiment/measured_data.h"
#include "experiment/plot.h"
#include "temporary_file.h"

namespace bsoil::experiment::results_test {
namespace {

CsvTable results() {
    return {{"point", "depth_m", "draft_n"},
            {{"0", "0.1", "110"}, {"1", "0.2", "380"}, {"2", "0.3", "900"}}};
}

TEST(ExperimentResults, csv_is_read_as_it_was_written) {
    const CsvTable table{{"a", "b, with comma"}, {{"1", "say \"so\""}, {"", "two\nlines"}}};
    const TemporaryFile file("table.csv");
    ASSERT_TRUE(write_csv(table, file.path()));
    const auto read = read_csv(file.path());
    ASSERT_TRUE(read) << read.error();
    EXPECT_EQ(read->columns, table.columns);
    EXPECT_EQ(read->rows, table.rows);
    std::ofstream(file.path()) << "a,b\r\n1\r\n\r\n1,2,3\n";
    EXPECT_NE(read_csv(file.path()).error().find("row 3 has 3 cells"), std::string::npos);
    std::ofstream(file.path()) << "\xef\xbb\xbf"
                                  "a, b\n1 , 2 \n3, \n";  // of a spreadsheet
    const auto marked = read_csv(file.path());
    ASSERT_TRUE(marked) << marked.error();
    EXPECT_EQ(marked->number(0, "a"), 1);
    EXPECT_EQ(marked->number(0, " b"), 2);
    EXPECT_FALSE(marked->number(1, " b"));
    std::filesystem::remove(file.path());
    EXPECT_FALSE(read_csv(file.path()));
}

TEST(ExperimentResults, measured_columns_are_filtered_and_scaled) {
    const CsvTable file{{"wheel", "slip", "z_mm"},
                        {{"smooth", "0.10", "5"}, {"lugs", "0.1", "6"}, {"smooth", "0.2", ""}}};
    MeasuredItem item;
    item.columns.resize(2);
    item.columns[0].name = "slip_ratio";
    item.columns[0].column = "slip";
    item.columns[1].name = "sinkage_m";
    item.columns[1].column = "z_mm";
    item.columns[1].factor = 0.001;
    MeasuredFilterItem& filter = item.filters.emplace_back();
    filter.column = "wheel";
    filter.equals = {"smooth"};
    const auto table = select_measured(file, item);
    ASSERT_TRUE(table) << table.error();
    EXPECT_EQ(table->columns, (std::vector<std::string>{"slip_ratio", "sinkage_m"}));
    ASSERT_EQ(table->rows.size(), 1u);  // the row without a sinkage is no measurement
    EXPECT_DOUBLE_EQ(table->rows[0][1], 0.005);
    filter.column = "slip";
    filter.equals = {"0.1"};  // numbers are compared as numbers
    EXPECT_EQ(select_measured(file, item)->rows.size(), 2u);
    filter.equals = {"0.1", "0.2"};  // the row of 0.2 has no sinkage
    EXPECT_EQ(select_measured(file, item)->rows.size(), 2u);
    item.columns[0].column = "wheel";
    item.columns[0].values = {{"lugs", 10}};
    ASSERT_EQ(select_measured(file, item)->rows.size(), 1u);
    EXPECT_DOUBLE_EQ(select_measured(file, item)->rows[0][0], 10);
    item.columns[0].values.clear();  // no wheel is a number
    EXPECT_NE(select_measured(file, item).error().find("none of 3 rows has a number"),
              std::string::npos);
    filter.equals = {"7"};
    EXPECT_NE(select_measured(file, item).error().find("[[measured.where]]"), std::string::npos);
    filter.column = "weel";
    EXPECT_NE(select_measured(file, item).error().find("the columns are wheel, slip, z_mm"),
              std::string::npos);
}

TEST(ExperimentResults, result_stands_beside_the_mean_of_its_measurements) {
    CsvTable table = results();
    add_measured(table, {{"depth_m", "draft_n"}, {{0.1, 90}, {0.1, 110}, {0.2, 400}}}, {"depth_m"});
    EXPECT_EQ(table.columns[3], "draft_n_measured");
    EXPECT_EQ(table.columns[4], "draft_n_error");
    EXPECT_DOUBLE_EQ(*table.number(0, "draft_n_measured"), 100);
    EXPECT_DOUBLE_EQ(*table.number(0, "draft_n_error"), 0.1);
    EXPECT_DOUBLE_EQ(*table.number(1, "draft_n_error"), -0.05);
    EXPECT_FALSE(table.number(2, "draft_n_measured"));
}

Verdict::Kind verdict_on(const ExpectItem& expect) {
    Experiment experiment;
    experiment.expectations = {expect};
    return check_expectations(experiment, results())[0].kind;
}

TEST(ExperimentResults, expectations_are_held_against_their_rows) {
    ExpectItem expect;
    expect.column = "draft_n";
    expect.min = 100;
    EXPECT_EQ(verdict_on(expect), Verdict::Kind::pass);
    expect.min = 200;  // point 0 is below
    EXPECT_EQ(verdict_on(expect), Verdict::Kind::fail);
    expect.at_values = {{"depth_m", "0.2", 0.2, {}}};
    EXPECT_EQ(verdict_on(expect), Verdict::Kind::pass);
    expect.at_values = {{"depth_m", "0.5", 0.5, {}}};  // no such row
    EXPECT_EQ(verdict_on(expect), Verdict::Kind::fail);
    expect.at_values.clear();
    expect.statistic = "median";
    expect.min.reset();
    expect.value = 380;
    expect.tolerance = 1;
    EXPECT_EQ(verdict_on(expect), Verdict::Kind::pass);
    expect.column = "draft_n_error";  // nothing was measured
    EXPECT_EQ(verdict_on(expect), Verdict::Kind::skip);
}

// A heap that never rests has no time of rest, and no power law goes through a slope of 0.
TEST(ExperimentResults, expectations_fail_where_a_row_or_a_group_has_no_figure) {
    const CsvTable table{{"point", "phi_deg", "voxel_m", "rest_s", "slope_deg", "rest_s_error"},
                         {{"0", "20", "0.1", "2", "40", "0.1"},
                          {"1", "30", "0.1", "1", "30", ""},
                          {"2", "20", "0.2", "3", "40", "0.1"},
                          {"3", "30", "0.2", "", "0", ""}}};
    const auto verdict = [&table](const ExpectItem& expect) {
        Experiment experiment;
        experiment.expectations = {expect};
        return check_expectations(experiment, table)[0];
    };
    ExpectItem expect;
    expect.column = "rest_s";
    expect.max = 10;
    EXPECT_EQ(verdict(expect).kind, Verdict::Kind::fail);
    EXPECT_NE(verdict(expect).text.find("1 of 4 rows have no figure"), std::string::npos);
    expect.at_values = {{"phi_deg", "20", 20, {}}};
    EXPECT_EQ(verdict(expect).kind, Verdict::Kind::pass);
    expect.at_values.clear();
    expect.column = "slope_deg";
    expect.statistic = "exponent";
    expect.over = "phi_deg";
    expect.by = {"voxel_m"};
    EXPECT_EQ(verdict(expect).kind, Verdict::Kind::fail);
    EXPECT_NE(verdict(expect).text.find("with voxel_m = 0.2"), std::string::npos);
    expect.at_values = {{"voxel_m", "0.1", 0.1, {}}};
    EXPECT_EQ(verdict(expect).kind, Verdict::Kind::pass);
    ExpectItem error;  // measured are two of four
    error.column = "rest_s_error";
    error.max = 0.2;
    EXPECT_EQ(verdict(error).kind, Verdict::Kind::pass);
}

// It passed by the other rows.
TEST(ExperimentResults, expectation_on_errors_fails_where_a_measured_row_has_no_result) {
    CsvTable table{{"point", "draft_n"}, {{"0", "110"}, {"1", ""}, {"2", ""}}};
    add_measured(table, {{"point", "draft_n"}, {{0, 100}, {2, 100}}}, {"point"});
    Experiment experiment;
    ExpectItem expect;
    expect.column = "draft_n_error";
    expect.max = 0.2;
    experiment.expectations = {expect};
    const Verdict verdict = check_expectations(experiment, table)[0];
    EXPECT_EQ(verdict.kind, Verdict::Kind::fail);
    EXPECT_NE(verdict.text.find("1 of 3 rows have no figure"), std::string::npos) << verdict.text;
    table.rows.pop_back();  // that of point 1 was not measured
    EXPECT_EQ(check_expectations(experiment, table)[0].kind, Verdict::Kind::pass);
}

TEST(ExperimentResults, plot_shows_curves_and_measured_points) {
    Experiment experiment;
    experiment.rig = "blade";
    experiment.title = "A \"blade\"";
    experiment.points.resize(1);
    experiment.points[0].parameters = {{"depth_m", "0.1", 0.1}};
    experiment.measured_item.emplace().label = "Somebody 1970";
    experiment.measured = {{"depth_m", "draft_n"}, {{0.1, 90}}};
    PlotItem plot;
    plot.x = "depth_m";
    plot.y = "draft_n";
    experiment.plots = {plot};
    const std::string script = plot_script(experiment, results());
    for (const char* part : {"0.2 380\n", "0.1 90\n", "Somebody 1970", "\"draft, N\"",
                             "A \\\"blade\\\"", "results.svg", "results.png"}) {
        EXPECT_NE(script.find(part), std::string::npos) << part;
    }
}

}  // namespace
}  // namespace bsoil::experiment::results_test
