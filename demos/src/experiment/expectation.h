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

/// One for each [[expect]] of the experiment.
std::vector<Verdict> check_expectations(const Experiment& experiment, const CsvTable& results);

}  // namespace bsoil::experiment
