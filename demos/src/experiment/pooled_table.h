/// Errors over the points of all data sets of a kind, beside what the project asks of them.
#pragma once

#include <string>
#include <vector>

#include "comparison.h"

namespace bsoil::experiment {

/// Medians over the points of all experiments of one rig, quantity by quantity: of those that have
/// a bar, and of those that more than one experiment measures.
std::string pooled_table(const std::vector<Comparison>& comparisons);

}  // namespace bsoil::experiment
