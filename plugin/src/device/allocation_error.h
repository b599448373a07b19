/// What every backend checks and says alike.
#pragma once

#include <string>

#include "device/device.h"

namespace bsoil::device {

/// The buffer's name in the kernels.
const char* buffer_name(Buffer buffer);

/// "buffer state: cannot allocate 1024.0 MiB: <reason>".
Error allocation_error(Buffer buffer, int64_t words, const std::string& reason);

/// Whether the tiles of all colours together hold as many groups as the list.
bool covers_all_groups(const WorkList& work);

}  // namespace bsoil::device
