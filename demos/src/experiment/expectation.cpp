#include "expectation.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

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

Verdict check(const ExpectItem& expect, const CsvTable& results) {
    Verdict verdict;
    verdict.text = description_of(expect);
    if (results.column_index(expect.column) < 0) {
        verdict.kind = Verdict::Kind::skip;
        verdict.text += ", the measured data is not there";
        return verdict;
    }
    std::vector<double> values;
    for (const auto& group : grouped(results, rows_at(results, expect.at_values), expect.by)) {
        const auto found = figures(results, group, expect.column, expect.statistic, expect.over);
        values.insert(values.end(), found.begin(), found.end());
    }
    if (values.empty()) {
        verdict.kind = Verdict::Kind::fail;
        verdict.text += ", there is no such result";
        return verdict;
    }
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
