#include "soil/noise.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace bsoil {
namespace {

/// Uniform in -1..1 for a lattice point.
double lattice_value(int64_t x, int64_t y, uint32_t seed) {
    uint64_t h = static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15ull ^
                 static_cast<uint64_t>(y) * 0xc2b2ae3d27d4eb4full ^
                 (static_cast<uint64_t>(seed) << 32 | seed);
    h = (h ^ (h >> 31)) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ (h >> 29)) * 0x94d049bb133111ebull;
    return static_cast<double>(h >> 11) / 4503599627370496.0 - 1;
}

/// The corners of a lattice's cell.
struct Corners {
    int64_t x = 0, y = 0;
    unsigned seed = 0;
    bool is_known = false;
    std::array<double, 4> values{};

    void find(int64_t at_x, int64_t at_y, unsigned of_seed) {
        if (is_known && x == at_x && y == at_y && seed == of_seed) return;
        *this = {
            at_x,
            at_y,
            of_seed,
            true,
            {lattice_value(at_x, at_y, of_seed), lattice_value(at_x + 1, at_y, of_seed),
             lattice_value(at_x, at_y + 1, of_seed), lattice_value(at_x + 1, at_y + 1, of_seed)}};
    }
};

double smooth(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

}  // namespace

double fractal_noise(double x, double y, int octaves, double persistence, unsigned seed) {
    // Columns beside each other mostly lie in one cell.
    constexpr size_t kKnownOctaves = 12;
    thread_local std::array<Corners, kKnownOctaves> known;
    double sum = 0, amplitude = 1;
    for (int o = 0; o < octaves; ++o) {
        const double fx = std::floor(x), fy = std::floor(y);
        const auto ix = static_cast<int64_t>(fx), iy = static_cast<int64_t>(fy);
        const double u = smooth(x - fx), v = smooth(y - fy);
        Corners& corners = known[static_cast<size_t>(o) % kKnownOctaves];
        corners.find(ix, iy, seed + static_cast<unsigned>(o) * 7919u);
        const std::array<double, 4>& at = corners.values;
        const double low = at[0] * (1 - u) + at[1] * u, high = at[2] * (1 - u) + at[3] * u;
        sum += amplitude * (low * (1 - v) + high * v);
        amplitude *= persistence;
        x *= 2;
        y *= 2;
    }
    return sum;
}

}  // namespace bsoil
