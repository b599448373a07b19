/// Whether the reason for which a body is refused also says what to do about it.
#pragma once

#include <string>

namespace bsoil::bullet {

/// A range of what may be, or behind a semicolon or a full stop what would help.
inline bool says_what_to_do(const std::string& reason) {
    return reason.find("must be") != std::string::npos || reason.find("; ") != std::string::npos ||
           reason.find(". ") != std::string::npos;
}

}  // namespace bsoil::bullet
