#include "figures.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "line_fit.h"
#include "measured_data.h"

namespace bsoil::experiment {
namespace {

/// Rows with equal numbers follow each other only once: the next row of a rising column.
using Curve = std::vector<std::pair<double, double>>;

bool holds(const CsvTable& results, size_t row, const RowCondition& condition) {
    const auto number = results.number(row, condition.column);
    if (condition.to) {
        // ends of a range count, and rounding in files does not
        return number && (*number > *condition.from || same_value(*number, *condition.from)) &&
               (*number < *condition.to || same_value(*number, *condition.to));
    }
    if (condition.from && number) return same_value(*condition.from, *number);
    return results.rows[row][static_cast<size_t>(results.column_index(condition.column))] ==
           condition.text;
}

Curve curve_of(const CsvTable& results, const std::vector<size_t>& rows, const std::string& x,
               const std::string& y) {
    Curve curve;
    for (const size_t r : rows) {
        const auto at = results.number(r, x), value = results.number(r, y);
        if (at && value) curve.push_back({*at, *value});
    }
    std::sort(curve.begin(), curve.end());
    return curve;
}

std::vector<double> least_rise(const Curve& curve) {
    std::vector<double> rises;
    for (size_t i = 1; i < curve.size(); ++i) {
        rises.push_back(curve[i].second - curve[i - 1].second);
    }
    if (rises.empty()) return {};
    return {*std::min_element(rises.begin(), rises.end())};
}

/// Slope of the least squares line through the logarithms.
std::vector<double> exponent(const Curve& curve) {
    const auto size = static_cast<Eigen::Index>(curve.size());
    Eigen::VectorXd x(size), y(size);
    for (Eigen::Index i = 0; i < size; ++i) {
        std::tie(x[i], y[i]) = curve[static_cast<size_t>(i)];
        if (!(x[i] > 0) || !(y[i] > 0)) return {};
    }
    const auto line = fit_line(x.array().log(), y.array().log(), Eigen::VectorXd::Ones(size));
    return line ? std::vector{line->slope} : std::vector<double>{};
}

/// Where a curve that starts at 0 first reaches 1 - 1/e of its largest value.
std::vector<double> janosi_k(const Curve& curve) {
    double largest = 0;
    for (const auto& [x, y] : curve) largest = std::max(largest, y);
    const double reached = largest * (1 - 1 / std::numbers::e);
    std::pair<double, double> last{0, 0};
    for (const auto& point : curve) {
        if (largest > 0 && point.second >= reached) {
            const double share = (reached - last.second) / (point.second - last.second);
            return {last.first + share * (point.first - last.first)};
        }
        last = point;
    }
    return {};
}

}  // namespace

const std::vector<std::string>& statistic_names() {
    static const std::vector<std::string> names{
        "each",   "mean",      "median", "median_magnitude", "max_magnitude", "max",
        "spread", "deviation", "last",   "least_rise",       "exponent",      "janosi_k"};
    return names;
}

bool follows_column(const std::string& statistic) {
    return statistic == "least_rise" || statistic == "exponent" || statistic == "janosi_k";
}

std::vector<size_t> rows_at(const CsvTable& results, const std::vector<RowCondition>& conditions) {
    std::vector<size_t> rows;
    for (size_t r = 0; r < results.rows.size(); ++r) {
        if (std::all_of(conditions.begin(), conditions.end(),
                        [&](const RowCondition& c) { return holds(results, r, c); })) {
            rows.push_back(r);
        }
    }
    return rows;
}

std::vector<std::vector<size_t>> grouped(const CsvTable& results, const std::vector<size_t>& rows,
                                         const std::vector<std::string>& by) {
    std::vector<std::vector<size_t>> groups;
    for (const size_t r : rows) {
        const auto agrees = [&](const std::vector<size_t>& group) {
            return std::all_of(by.begin(), by.end(), [&](const std::string& name) {
                const auto c = static_cast<size_t>(results.column_index(name));
                return results.rows[group.front()][c] == results.rows[r][c];
            });
        };
        auto group = std::find_if(groups.begin(), groups.end(), agrees);
        if (group == groups.end()) group = groups.insert(groups.end(), std::vector<size_t>{});
        group->push_back(r);
    }
    return groups;
}

std::vector<double> figures(const CsvTable& results, const std::vector<size_t>& rows,
                            const std::string& column, const std::string& statistic,
                            const std::string& over) {
    if (follows_column(statistic)) {
        const Curve curve = curve_of(results, rows, over, column);
        if (statistic == "least_rise") return least_rise(curve);
        return statistic == "exponent" ? exponent(curve) : janosi_k(curve);
    }
    std::vector<double> values;
    for (const size_t r : rows) {
        if (const auto value = results.number(r, column)) values.push_back(*value);
    }
    if (statistic == "each" || values.empty()) return values;
    if (statistic.ends_with("magnitude")) {
        for (double& value : values) value = std::abs(value);
    }
    const auto [least, largest] = std::minmax_element(values.begin(), values.end());
    if (statistic == "max" || statistic == "max_magnitude") return {*largest};
    if (statistic == "spread") return {*largest - *least};
    if (statistic == "deviation") {
        if (values.size() < 2 || values.front() == 0) return {};
        return {std::max(*largest - values.front(), values.front() - *least) /
                std::abs(values.front())};
    }
    if (statistic == "last") return {values.back()};
    if (statistic == "mean") {
        double sum = 0;
        for (const double value : values) sum += value;
        return {sum / static_cast<double>(values.size())};
    }
    return {median(std::move(values))};
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

}  // namespace bsoil::experiment
