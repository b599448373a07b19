/// Files as a whole, read up to a capacity and written.
#pragma once

#include <cstddef>
#include <string>

#include "bsoil/result.h"

namespace bsoil::scene {

/// The bytes of a file. Error: it cannot be read, or holds more than `capacity` bytes; no more than
/// that is read, so that endless files (devices, pipes) end too.
Result<std::string> read_file(const std::string& path, size_t capacity);

/// Into a folder that is there.
Status write_file(const std::string& path, const std::string& bytes);

/// The same where something is there that must not be lost: it stays until all of the new bytes are
/// on the disk, in `path`.part.
Status replace_file(const std::string& path, const std::string& bytes);

}  // namespace bsoil::scene
