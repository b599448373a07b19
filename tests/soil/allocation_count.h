/// Allocations of this program.
#pragma once

#include <cstdint>

namespace bsoil {

/// Made by operator new since the program began.
int64_t allocation_count();

}  // namespace bsoil
