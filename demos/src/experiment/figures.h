/// Figures taken from rows of the results, for [[expect]] and [[validation.compare]].
#pragma once

#include <string>
#include <vector>

#include "csv_table.h"
#include "experiment.h"

namespace bsoil::experiment {

/// The words that `statistic` may be.
const std::vector<std::string>& statistic_names();
/// Whether a statistic looks along another column (`over`).
bool follows_column(const std::string& statistic);

/// Rows for which all conditions hold.
std::vector<size_t> rows_at(const CsvTable& results, const std::vector<RowCondition>& conditions);
/// The same rows in groups that agree in the columns `by`; one group where there are none.
std::vector<std::vector<size_t>> grouped(const CsvTable& results, const std::vector<size_t>& rows,
                                         const std::vector<std::string>& by);

/// The statistic of a column over rows: one figure, or each row's for "each"; none where no row has
/// a number, or too few have.
std::vector<double> figures(const CsvTable& results, const std::vector<size_t>& rows,
                            const std::string& column, const std::string& statistic,
                            const std::string& over);

/// 0 for no values.
double median(std::vector<double> values);

}  // namespace bsoil::experiment
