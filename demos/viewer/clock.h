/// The machine's clock.
#pragma once

#include <chrono>

namespace bsoil::viewer {

/// Seconds since some moment; never goes back.
inline double now_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

}  // namespace bsoil::viewer
