#include "expectation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "measured_data.h"

namespace bsoil::experiment {
namespace {

/// The figures an expectation is about: one, or each row's.
std::vector<double> figures(const std::string& statistic, std::vector<double> values) {
    if (statistic == "each" || values.empty()) return values;
    if (statistic.ends_with("magnitude"))
        for (double& value : values) value = std::abs(value);
    if (statistic == "max_magnitude") return {*std::max_element(values.begin(), values.end())};
    if (statistic == "mean") {
        double sum = 0;
        for (const double value : values) sum += value;
        return {sum / static_cast<double>(values.size())};
    }
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    return {values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2};
}

std::string range_of(const ExpectItem& expect) {
    std::string text;
    if (expect.value) text += fmt::format(" {:.6g} +- {:.6g}", *expect.value, *expect.tolerance);
    if (expect.min) text += fmt::format(" at least {:.6g}", *expect.min);
    if (expect.max) text += fmt::format(" at most {:.6g}", *expect.max);
    return text;
}

Verdict check(const ExpectItem& expect, const CsvTable& results) {
    Verdict verdict;
    for (const Parameter& p : expect.at_values)
        verdict.text +=
            fmt::format("{}{} = {}", verdict.text.empty() ? " at " : ", ", p.name, p.text);
    verdict.text =
        fmt::format("{} {}{}: expected{}", expect.statistic == "each" ? "" : expect.statistic,
                    expect.column, verdict.text, range_of(expect));
    if (verdict.text.starts_with(' ')) verdict.text.erase(0, 1);
    if (results.column_index(expect.column) < 0) {
        verdict.kind = Verdict::Kind::skip;
        verdict.text += ", the measured data is not there";
        return verdict;
    }
    std::vector<double> values;
    for (size_t r = 0; r < results.rows.size(); ++r) {
        const bool at =
            std::all_of(expect.at_values.begin(), expect.at_values.end(), [&](const Parameter& p) {
                const auto number = results.number(r, p.name);
                if (p.number && number) return same_value(*p.number, *number);
                return results.rows[r][static_cast<size_t>(results.column_index(p.name))] == p.text;
            });
        const auto value = results.number(r, expect.column);
        if (at && value) values.push_back(*value);
    }
    values = figures(expect.statistic, std::move(values));
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
    for (const ExpectItem& expect : experiment.expectations)
        verdicts.push_back(check(expect, results));
    return verdicts;
}

}  // namespace bsoil::experiment
