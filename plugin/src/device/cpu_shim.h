/// The words of the common kernel language in C++. Its GLSL twin is shaders/prelude.glsl. Only
/// cpu_kernels.cpp includes this. Built-in functions whose rounding GLSL leaves open (sqrt, dot,
/// division, ...) are not here on purpose.
#pragma once

#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#define CONST_INT(name, value) static constexpr int name = value;
#define CONST_FLOAT(name, value) static constexpr float name = value;
#define IN(type) const type&  // of structs: no copy is made
#define OUT(type) type&
#define INOUT(type) type&
#define PRECISE  // the build forbids contraction (-ffp-contract=off), so every float is

#define ATOMIC_ADD(word, value) bsoil::device::shim::atomic_add(word, value)
#define ATOMIC_MAX(word, value) bsoil::device::shim::atomic_max(word, value)
#define ATOMIC_OR(word, value) bsoil::device::shim::atomic_or(word, value)
#define ATOMIC_LOAD(word) bsoil::device::shim::atomic_load(word)
#define ATOMIC_ADD_OWNED(word, value) bsoil::device::shim::add_owned(word, value)
#define ATOMIC_MAX_OWNED(word, value) bsoil::device::shim::max_owned(word, value)
#define ATOMIC_MIN_OWNED(word, value) bsoil::device::shim::min_owned(word, value)
#define ATOMIC_OR_OWNED(word, value) ((word) |= (value))
#define ATOMIC_AND_OWNED(word, value) ((word) &= (value))

namespace bsoil::device::shim {

using glm::abs;
using glm::clamp;
using glm::floor;
using glm::ivec2;
using glm::ivec3;
using glm::ivec4;
using glm::max;
using glm::min;
using glm::sign;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using uint = uint32_t;
inline constexpr int kAllLanes = -1;  // of <kernel>_lanes(group, half)

// Relaxed: groups exchange nothing but these words themselves, and a dispatch ends with a full
// synchronisation.
inline int atomic_add(int32_t& word, int value) {
    return std::atomic_ref(word).fetch_add(value, std::memory_order_relaxed);
}
inline int atomic_or(int32_t& word, int value) {
    return std::atomic_ref(word).fetch_or(value, std::memory_order_relaxed);
}
inline int atomic_load(int32_t& word) {
    return std::atomic_ref(word).load(std::memory_order_relaxed);
}
inline int atomic_max(int32_t& word, int value) {
    const std::atomic_ref shared(word);
    int old = shared.load(std::memory_order_relaxed);
    while (old < value && !shared.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
    }
    return old;
}
// Wraps as the GL's does.
inline int add_owned(int32_t& word, int value) {
    const int old = word;
    word = static_cast<int>(static_cast<uint32_t>(old) + static_cast<uint32_t>(value));
    return old;
}
inline int max_owned(int32_t& word, int value) {
    const int old = word;
    word = old < value ? value : old;
    return old;
}
inline int min_owned(int32_t& word, int value) {
    const int old = word;
    word = old < value ? old : value;
    return old;
}

inline int float_as_int(float x) { return std::bit_cast<int>(x); }
inline float int_as_float(int bits) { return std::bit_cast<float>(bits); }
inline int mul_q16(int a, int b) { return static_cast<int>((int64_t{a} * b) >> 16); }
// floor(65536 part / whole) for 0 <= part <= whole < 2^27.
inline int fraction_q16(int part, int whole) {
    return static_cast<int>((int64_t{part} << 16) / whole);
}
// Whole square root, rounded down. A double's root is rounded by less than what lies between the
// roots of two such numbers.
inline int square_root(int square) {
    return square > 0 ? static_cast<int>(std::sqrt(static_cast<double>(square))) : 0;
}
inline int bit_count(int bits) { return std::popcount(static_cast<uint32_t>(bits)); }
inline int lowest_bit(int bits) { return std::countr_zero(static_cast<uint32_t>(bits)); }
inline float divide_exact(float a, float b) { return a / b; }

}  // namespace bsoil::device::shim
