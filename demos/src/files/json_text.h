/// JSON as text, whatever stands in its names.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace bsoil::scene {

/// Names out of URDF and .bullet files may be in any encoding: what is no UTF-8 in them becomes
/// U+FFFD. indent: -1 for one line.
inline std::string json_text(const nlohmann::ordered_json& json, int indent = -1) {
    return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace bsoil::scene
