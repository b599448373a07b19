/// Chance by a number, the same each time.
#pragma once

#include <cstdint>

namespace bsoil::render {

/// 0..1, by a seed (the finalizer of MurmurHash3).
inline double random_share(uint32_t seed) {
    seed ^= seed >> 16;
    seed *= 0x85ebca6bu;
    seed ^= seed >> 13;
    seed *= 0xc2b2ae35u;
    seed ^= seed >> 16;
    return seed / 4294967296.0;
}

}  // namespace bsoil::render
