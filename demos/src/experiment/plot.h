/// The plot of an experiment, drawn by gnuplot.
#pragma once

#include <string>
#include <vector>

#include "csv_table.h"
#include "experiment.h"

namespace bsoil::experiment {

/// A column's name as it stands at an axis: "draft_n" is "draft, N".
std::string axis_title(const std::string& column);
/// The parameters that tell curves of a panel apart.
std::vector<std::string> curve_keys(const Experiment& experiment, const PlotItem& plot);

/// The gnuplot script for results.svg and results.png, with the data in it: a panel for each
/// [[plot]].
std::string plot_script(const Experiment& experiment, const CsvTable& results);

/// Writes the script into `folder` as results.gnuplot and runs gnuplot there. The error says that
/// gnuplot is missing or failed; the script is there all the same.
Status draw_plot(const Experiment& experiment, const CsvTable& results, const std::string& folder);

}  // namespace bsoil::experiment
