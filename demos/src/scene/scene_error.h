/// Mistakes in a scene file, with their places.
#pragma once

#include <string>
#include <vector>

#include "scene.h"

namespace bsoil::scene {

/// An error and its place in the scene file.
struct SchemaError {
    SourcePosition at;
    std::string text;
};

/// The errors in the order of the file, one a line, as "file:line:column: text"; without
/// the place where it is unknown.
std::string error_text(std::vector<SchemaError> errors, const std::string& path);

}  // namespace bsoil::scene
