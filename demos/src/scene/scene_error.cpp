#include "scene_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace bsoil::scene {

std::string error_text(std::vector<SchemaError> errors, const std::string& path) {
    std::stable_sort(errors.begin(), errors.end(), [](const SchemaError& a, const SchemaError& b) {
        return std::pair(a.at.line, a.at.column) < std::pair(b.at.line, b.at.column);
    });
    std::string all;
    for (const SchemaError& e : errors) {
        all += all.empty() ? "" : "\n";
        all += e.at.line == 0 ? fmt::format("{}: {}", path, e.text)
                              : fmt::format("{}:{}:{}: {}", path, e.at.line, e.at.column, e.text);
    }
    return all;
}

}  // namespace bsoil::scene
