/// One sentence for a value out of its range.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "bsoil/result.h"

namespace bsoil {

/// Done when low <= value <= high; NaN fails.
inline Status check_range(const std::string& field, double value, double low, double high) {
    if (value >= low && value <= high) return Done{};
    return Error{fmt::format("{} is {}, must be {} to {}", field, value, low, high)};
}

}  // namespace bsoil
