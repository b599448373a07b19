/// TOML from files of unknown origin.
#pragma once

#include <string>

#include "schema_table.h"

namespace bsoil::scene {

/// Bytes of a scene or an experiment. A value takes up to a hundred times its text in memory.
inline constexpr size_t kTomlCapacity = size_t{8} << 20;
/// Parts of a dotted key or of a table's name, as [a.b.c]: each is a table inside the one before,
/// and tables are taken apart recursively. Scenes need 3.
inline constexpr int kKeyPartCapacity = 16;

/// The tables of `text`, with their places in it. The error begins with `path` and has line and
/// column: bad syntax, or more than the capacities above.
Result<toml::table> parse_toml(const std::string& text, const std::string& path);
/// The same of a file.
Result<toml::table> read_toml(const std::string& path);

}  // namespace bsoil::scene
