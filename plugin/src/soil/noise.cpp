#include "soil/noise.h"

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

double smooth(double t) { return t * t * t * (t * (t * 6 - 15) + 10); }

}  // namespace

double fractal_noise(double x, double y, int octaves, double persistence, unsigned seed) {
    double sum = 0, amplitude = 1;
    for (int o = 0; o < octaves; ++o) {
        const double fx = std::floor(x), fy = std::floor(y);
        const auto ix = static_cast<int64_t>(fx), iy = static_cast<int64_t>(fy);
        const double u = smooth(x - fx), v = smooth(y - fy);
        const unsigned s = seed + static_cast<unsigned>(o) * 7919u;
        const double low = lattice_value(ix, iy, s) * (1 - u) + lattice_value(ix + 1, iy, s) * u;
        const double high =
            lattice_value(ix, iy + 1, s) * (1 - u) + lattice_value(ix + 1, iy + 1, s) * u;
        sum += amplitude * (low * (1 - v) + high * v);
        amplitude *= persistence;
        x *= 2;
        y *= 2;
    }
    return sum;
}

}  // namespace bsoil
