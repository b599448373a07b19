/// Results beside measurements and a classical model: what [[validation.compare]] asks for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "csv_table.h"
#include "expectation.h"
#include "experiment.h"

namespace bsoil::experiment {

/// A force below this share of the load is too near zero for a relative error.
inline constexpr double kLoadShareMin = 0.03;

/// One model's figure at a point.
struct ComparedFigure {
    std::optional<double> value;
    std::optional<double> error;       ///< relative: value / measured - 1
    std::optional<double> load_error;  ///< (value - measured) / load
};
struct ComparedPoint {
    std::vector<std::string> keys;  ///< cells of ComparedQuantity::key_columns
    double measured = 0;
    ComparedFigure soil, classical;
};
/// Medians over points; nothing where no point has such an error.
struct ErrorMedians {
    std::optional<double> relative, of_load;  ///< of the errors' magnitudes
};
struct ComparedQuantity {
    CompareItem item;
    std::vector<std::string> key_columns;
    std::vector<ComparedPoint> points;
    size_t relative_count = 0;  ///< points with a relative error
    ErrorMedians soil, classical;
};

/// Of the figures of one model at these points.
ErrorMedians medians_of(const std::vector<ComparedPoint>& points,
                        ComparedFigure ComparedPoint::*model);

/// Whether a force that is far enough from zero for a relative error acts against the measured one.
bool has_wrong_sign(const ComparedFigure& figure);

/// An experiment that has been run and compared.
struct Comparison {
    std::string name;  ///< of its file, without folder and ending
    const Experiment* experiment = nullptr;
    CsvTable results;                  ///< with measured and classical columns
    std::string classical_parameters;  ///< as a sentence, may be empty
    std::vector<ComparedQuantity> quantities;
    std::vector<Verdict> verdicts;
    bool holds() const;  ///< no verdict failed
};

/// `results` as result_table makes them, of an experiment with [validation] and measured data.
Result<Comparison> compare(const Experiment& experiment, CsvTable results);

}  // namespace bsoil::experiment
