/// The classical model's figures beside an experiment's results.
#pragma once

#include <string>

#include "csv_table.h"
#include "experiment.h"

namespace bsoil::experiment {

/// "Bekker", "Wong and Reece", ...: what a classical model is called.
std::string classical_name(const std::string& classical);

/// Adds `NAME_classical`, and `NAME_classical_error` where NAME was measured, for each result that
/// the model of [validation] knows. Gives the model's parameters as a sentence. The error says
/// which parameters are missing.
Result<std::string> add_classical(CsvTable& results, const Experiment& experiment);

}  // namespace bsoil::experiment
