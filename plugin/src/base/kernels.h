/// The soil's kernels by number. Apart from layout.h, so that one more changes few sources.
#pragma once

#include "base/layout.h"

namespace bsoil::layout {

/// Kernels by number, in the order of kernel_list.h.
enum class Kernel {
#define PLAIN(name) name,
#define SCATTER(name) name,
#include "kernel_list.h"
#undef PLAIN
#undef SCATTER
};

}  // namespace bsoil::layout
