/// A text as a cell of a table of commas.
#pragma once

#include <string>

namespace bsoil::scene {

/// In quotes where it holds what separates cells or lines (RFC 4180).
inline std::string csv_cell(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + '"';
}

}  // namespace bsoil::scene
