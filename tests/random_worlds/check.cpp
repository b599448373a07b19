#include "check.h"

#include <fmt/format.h>

#include <algorithm>

namespace bsoil::random_worlds {

std::string text_of(const Failure& f) {
    return fmt::format("seed {}: {}: {} at {:.4g} s: expected {}, found {}", f.seed, f.invariant,
                       f.body, f.time_s, f.expected, f.found);
}

void Failures::add(const std::string& invariant, const std::string& body, double time_s,
                   const std::string& expected, const std::string& found) {
    const bool is_known = std::any_of(list_.begin(), list_.end(), [&](const Failure& f) {
        return f.invariant == invariant && f.body == body;
    });
    if (!is_known) list_.push_back({invariant, seed_, body, time_s, expected, found});
}

void Failures::add(const Failures& others) {
    for (const Failure& f : others.list_) add(f.invariant, f.body, f.time_s, f.expected, f.found);
}

}  // namespace bsoil::random_worlds
