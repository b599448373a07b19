/// What every backend says alike.
#pragma once

#include <string>

#include "device/device.h"

namespace bsoil::device {

/// "buffer state: cannot allocate 1024.0 MiB: <reason>; ...", with what helps.
Error allocation_error(const KernelSet& kernel_set, BufferIndex buffer, int64_t words,
                       const std::string& reason);

}  // namespace bsoil::device
