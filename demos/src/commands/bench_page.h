/// The figures of `bsoil bench` as a page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace bsoil::command {

/// Markdown: where it was measured, the thesis's experiments beside its figures, and each scene
/// with its passes and the checksum of its soil. figures: what `bsoil bench --out` writes; what is
/// not in them is left out.
std::string bench_page(const nlohmann::ordered_json& figures);

}  // namespace bsoil::command
