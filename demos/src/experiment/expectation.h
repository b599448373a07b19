/// The verdicts on an experiment's [[expect]] tables.
#pragma once

#include <string>
#include <vector>

#include "csv_table.h"
#include "experiment.h"

namespace bsoil::experiment {

struct Verdict {
    enum class Kind { pass, fail, skip };  ///< skip: the column rests on data that is not there
    Kind kind = Kind::pass;
    std::string text;  ///< what was expected and what was found
};

/// One for each [[expect]] of the experiment. It fails where a row or a group that it asks for has
/// no figure: a run that came to no end, or a statistic that the rows do not have. Columns of
/// measured values and of errors have one only where something was measured.
std::vector<Verdict> check_expectations(const Experiment& experiment, const CsvTable& results);

}  // namespace bsoil::experiment
