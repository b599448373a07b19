/// Files that an earlier run of the same command has left in a folder.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "bsoil/result.h"

namespace bsoil::scene {

/// Whether a name is `before`, at least so many digits, `after`, and nothing else.
bool is_numbered(std::string_view name, std::string_view before, size_t digits_least,
                 std::string_view after);

/// Removes the files of a folder whose names the command writes itself. Links and folders stay, and
/// what is in them. Nothing where there is no such folder. Error: one that cannot be removed.
Status remove_own_files(const std::string& folder,
                        const std::function<bool(std::string_view name)>& is_own);

}  // namespace bsoil::scene
