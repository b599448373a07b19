#include "expectation.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string_view>

#include "figures.h"

namespace bsoil::experiment {
namespace {

std::string range_of(const ExpectItem& expect) {
    std::string text;
    if (expect.value) text += fmt::format(" {:.6g} +- {:.6g}", *expect.value, *expect.tolerance);
    if (expect.min) text += fmt::format(" at least {:.6g}", *expect.min);
    if (expect.max) text += fmt::format(" at most {:.6g}", *expect.max);
    return text;
}

/// "peak: max shear_stress_pa at depth_m = 0.1: expected at most 3".
std::string description_of(const ExpectItem& expect) {
    std::string text = expect.title.empty() ? "" : expect.title + ": ";
    if (expect.statistic != "each") text += expect.statistic + ' ';
    text += expect.column;
    if (!expect.over.empty()) text += " over " + expect.over;
    const char* joint = " at ";
    for (const RowCondition& c : expect.at_values) {
        text += c.to ? fmt::format("{}{} = {:.6g} .. {:.6g}", joint, c.column, *c.from, *c.to)
                     : fmt::format("{}{} = {}", joint, c.column, c.text);
        joint = ", ";
    }
    return text + ": expected" + range_of(expect);
}

/// Columns that have a figure only where there is a measured one.
bool is_of_measured(const std::string& column) {
    return column.ends_with("_measured") || column.ends_with("_error");
}

/// Whether a row that has been measured has no relative error all the same: its result is no
/// number.
bool lacks_its_error(const CsvTable& results, size_t row, const std::string& column) {
    constexpr std::string_view kError = "_error";
    if (!column.ends_with(kError) || results.number(row, column)) return false;
    const std::string measured = column.substr(0, column.size() - kError.size()) + "_measured";
    return results.number(row, measured).value_or(0) != 0;
}

/// " with voxel_m = 0.1": which rows are meant.
std::string of_group(const ExpectItem& expect, const CsvTable& results,
                     const std::vector<size_t>& group) {
    std::string text;
    for (const std::string& name : expect.by) {
        text += fmt::format(
            "{}{} = {}", text.empty() ? " with " : ", ", name,
            results.rows[group.front()][static_cast<size_t>(results.column_index(name))]);
    }
    return text;
}

Verdict check(const ExpectItem& expect, const CsvTable& results) {
    Verdict verdict;
    verdict.text = description_of(expect);
    if (results.column_index(expect.column) < 0) {
        verdict.kind = Verdict::Kind::skip;
        verdict.text += ", the measured data is not there";
        return verdict;
    }
    const auto fail = [&verdict](const std::string& why) {
        verdict.kind = Verdict::Kind::fail;
        verdict.text += ", " + why;
        return verdict;
    };
    const std::vector<size_t> rows = rows_at(results, expect.at_values);
    const bool may_lack = is_of_measured(expect.column);
    const auto missing = std::ranges::count_if(rows, [&](size_t row) {
        return may_lack ? lacks_its_error(results, row, expect.column)
                        : !results.number(row, expect.column);
    });
    if (missing > 0) {
        return fail(fmt::format("{} of {} rows have no figure; choose rows that have one", missing,
                                rows.size()));
    }
    std::vector<double> values;
    for (const auto& group : grouped(results, rows, expect.by)) {
        const auto found = figures(results, group, expect.column, expect.statistic, expect.over);
        if (found.empty() && !may_lack) {
            return fail("there is no such figure" + of_group(expect, results, group) +
                        "; choose rows that have one");
        }
        values.insert(values.end(), found.begin(), found.end());
    }
    if (values.empty()) return fail("there is no such result; check its name");
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const double low = std::max(expect.value ? *expect.value - *expect.tolerance : -kNone,
                                expect.min.value_or(-kNone));
    const double high = std::min(expect.value ? *expect.value + *expect.tolerance : kNone,
                                 expect.max.value_or(kNone));
    const auto [least, largest] = std::minmax_element(values.begin(), values.end());
    if (*least < low || *largest > high) verdict.kind = Verdict::Kind::fail;
    verdict.text += values.size() == 1 ? fmt::format(", found {:.6g}", *least)
                                       : fmt::format(", found {:.6g} .. {:.6g}", *least, *largest);
    return verdict;
}

}  // namespace

std::vector<Verdict> check_expectations(const Experiment& experiment, const CsvTable& results) {
    std::vector<Verdict> verdicts;
    for (const ExpectItem& expect : experiment.expectations) {
        verdicts.push_back(check(expect, results));
    }
    return verdicts;
}

}  // namespace bsoil::experiment
