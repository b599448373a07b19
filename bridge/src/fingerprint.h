/// Fingerprint: a number that changes with what went into it.
#pragma once

#include <bit>
#include <cstdint>

#include "bullet_types.h"

namespace bsoil::bullet {

/// FNV-1a over 64-bit words.
struct Fingerprint {
    uint64_t value = 14695981039346656037ull;
    void add(uint64_t word) { value = (value ^ word) * 1099511628211ull; }
    void add(double x) { add(std::bit_cast<uint64_t>(x)); }
    void add(Vec3 v) {
        add(v.x);
        add(v.y);
        add(v.z);
    }
    void add(const btVector3& v) { add(from_bullet(v)); }
};

}  // namespace bsoil::bullet
