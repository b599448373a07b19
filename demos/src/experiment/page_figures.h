/// Figures within sentences, taken from the tables that commands write into pages.
#pragma once

#include <string>

#include "bsoil/result.h"

namespace bsoil::experiment {

/// Puts a figure of a table into every place of the page that names one:
///
///     sinks in to <!-- figure: ding_wheel / sinkage / 30, *, 0.6 / BulletSoil -->15.7<!-- / --> mm
///
/// The words are the block (`<!-- bsoil validate: ding_wheel -->` or that of another command in
/// `tables`), the table's title in it without its unit ("-" in a block of one table), what the
/// first cells of the row hold, and the column. A cell may be `*`, for any; a link's cell is named
/// by what it leads to. A second and third column of one name are told apart by the one before
/// them: "BulletSoil error". Where several rows fit, the place gets the least and the greatest,
/// "13.8 to 64.1", of those that have one. The error names the place that cannot be filled.
Result<std::string> fill_figures(std::string page, const std::string& tables);

/// Whether the page has such places.
bool names_figures(const std::string& page);

}  // namespace bsoil::experiment
