/// Measured data beside the results of an experiment.
#pragma once

#include "csv_table.h"
#include "experiment.h"

namespace bsoil::experiment {

/// Takes the rows and columns an experiment asks for out of a CSV file, in the experiment's units.
/// Rows without a number in one of the columns are left out. The error names what the file lacks.
Result<MeasuredTable> select_measured(const CsvTable& file, const MeasuredItem& item);

/// Adds `NAME_measured` and `NAME_error` (relative: result / measured - 1) for every measured
/// column that is a result and no key. Keys are the columns that are parameters or the station: a
/// result is compared with the mean of the rows that agree with it in all of them.
void add_measured(CsvTable& results, const MeasuredTable& measured,
                  const std::vector<std::string>& keys);

/// Equal but for rounding in files.
bool same_value(double a, double b);

}  // namespace bsoil::experiment
