/// A comparison in words.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "comparison.h"

namespace bsoil::experiment {

/// How tables and pictures call what is computed here.
inline constexpr const char* kSoilName = "BulletSoil";

/// "23 %" of 0.23, "-" of nothing.
std::string percent_text(const std::optional<double>& share, bool with_sign);
/// "pressure".
std::string quantity_title(const ComparedQuantity& quantity);
/// How many points there are, in brackets those with a relative error where they are fewer.
std::string points_text(const std::vector<ComparedPoint>& points);
/// "37 %; 5.1 % of load".
std::string medians_text(const ErrorMedians& model);

/// A comparison in a few lines of plain text.
std::string comparison_text(const Comparison& comparison);

}  // namespace bsoil::experiment
