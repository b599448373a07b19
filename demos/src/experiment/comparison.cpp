#include "comparison.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "classical_columns.h"
#include "figures.h"
#include "rig.h"

namespace bsoil::experiment {
namespace {

/// Load on the wheel of a point, 0 for other rigs.
double load_n_of(const Experiment& experiment, const CsvTable& results, size_t row) {
    const auto point = static_cast<size_t>(*results.number(row, "point"));
    const auto* wheel = std::get_if<TractionItem>(&experiment.points[point].setup.rig);
    return wheel ? wheel->load_n : 0;
}

/// Columns that tell the rows of a quantity apart: those of the sweep and the station that change.
std::vector<std::string> key_columns_of(const Experiment& experiment, const CsvTable& results,
                                        const CompareItem& item) {
    if (item.statistic != "each") return item.by;
    std::vector<std::string> names;
    for (const Parameter& p : experiment.points.front().parameters) names.push_back(p.name);
    const std::string station = station_column(experiment.rig);
    if (!station.empty()) names.push_back(station);
    std::vector<std::string> keys;
    for (const std::string& name : names) {
        const auto c = static_cast<size_t>(results.column_index(name));
        if (std::any_of(results.rows.begin(), results.rows.end(),
                        [&](const auto& row) { return row[c] != results.rows.front()[c]; })) {
            keys.push_back(name);
        }
    }
    return keys;
}

ComparedFigure compared(std::optional<double> value, double measured, double load_n,
                        const CompareItem& item) {
    ComparedFigure figure{value, {}, {}};
    if (!value) return figure;
    if (item.of_load && load_n > 0) figure.load_error = (*value - measured) / load_n;
    const double least = item.of_load ? kLoadShareMin * load_n : 0;
    if (std::abs(measured) > least) figure.error = *value / measured - 1;
    return figure;
}

ComparedQuantity quantity_of(const Experiment& experiment, const CsvTable& results,
                             const CompareItem& item) {
    ComparedQuantity quantity;
    quantity.item = item;
    quantity.key_columns = key_columns_of(experiment, results, item);
    // "each" is one figure a row
    const std::vector<std::string> by = item.statistic == "each" ? quantity.key_columns : item.by;
    for (const auto& rows : grouped(results, rows_at(results, item.at_values), by)) {
        const auto figure = [&](const std::string& suffix) -> std::optional<double> {
            const std::string column = item.column + suffix;
            if (results.column_index(column) < 0) return std::nullopt;
            // a model is compared only where there are measurements
            std::vector<size_t> measured;
            for (const size_t r : rows) {
                if (results.number(r, item.column + "_measured")) measured.push_back(r);
            }
            const auto found = figures(results, measured, column, item.statistic, item.over);
            return found.empty() ? std::nullopt : std::optional(found.front());
        };
        const auto measured = figure("_measured");
        if (!measured) continue;
        ComparedPoint& point = quantity.points.emplace_back();
        for (const std::string& key : quantity.key_columns) {
            point.keys.push_back(
                results.rows[rows.front()][static_cast<size_t>(results.column_index(key))]);
        }
        point.measured = *measured;
        const double load_n = load_n_of(experiment, results, rows.front());
        point.soil = compared(figure(""), *measured, load_n, item);
        point.classical = compared(figure("_classical"), *measured, load_n, item);
        quantity.relative_count += point.soil.error.has_value();
    }
    quantity.soil = medians_of(quantity.points, &ComparedPoint::soil);
    quantity.classical = medians_of(quantity.points, &ComparedPoint::classical);
    return quantity;
}

}  // namespace

ErrorMedians medians_of(const std::vector<ComparedPoint>& points,
                        ComparedFigure ComparedPoint::*model) {
    std::vector<double> relative, of_load;
    for (const ComparedPoint& point : points) {
        const ComparedFigure& figure = point.*model;
        if (figure.error) relative.push_back(std::abs(*figure.error));
        if (figure.load_error) of_load.push_back(std::abs(*figure.load_error));
    }
    const auto of = [](const std::vector<double>& errors) {
        return errors.empty() ? std::nullopt : std::optional(median(errors));
    };
    return {of(relative), of(of_load)};
}

bool has_wrong_sign(const ComparedFigure& figure) { return figure.error && *figure.error <= -1; }

bool Comparison::holds() const {
    return std::none_of(verdicts.begin(), verdicts.end(),
                        [](const Verdict& v) { return v.kind == Verdict::Kind::fail; });
}

Result<Comparison> compare(const Experiment& experiment, CsvTable results) {
    Comparison out;
    out.name = std::filesystem::path(experiment.path).stem().string();
    out.experiment = &experiment;
    out.results = std::move(results);
    auto parameters = add_classical(out.results, experiment);
    if (!parameters) return Error{parameters.error()};
    out.classical_parameters = std::move(*parameters);
    for (const CompareItem& item : experiment.validation->compares) {
        out.quantities.push_back(quantity_of(experiment, out.results, item));
    }
    out.verdicts = check_expectations(experiment, out.results);
    return out;
}

}  // namespace bsoil::experiment
