#include "terrain_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace bsoil::scene {
namespace {

/// Octaves of noise that a terrain may take: 15 minutes.
constexpr double kNoiseCapacity = 2e10;
constexpr double kSamplesOfVoxel = 27;  ///< see Soil::add_terrain
constexpr double kWarpedNoises = 3;     ///< along two axes, then the surface's own
constexpr double kNoisesOfHollow = 10;  ///< as long as a hollow takes

/// Of a point of the lattice; beyond 32 bits it repeats itself.
uint32_t hash(int64_t x, int64_t y, int64_t z, uint32_t seed) {
    uint32_t h = seed * 0x9e3779b1u;
    for (const int64_t v : {x, y, z}) {
        h ^= static_cast<uint32_t>(v) * 0x85ebca6bu;
        h = (h ^ (h >> 15)) * 0x2c1b3c6du;
        h ^= h >> 13;
    }
    return h;
}

/// -1..1 at the corners of the unit lattice, smooth between them.
double value_noise(Vec3 p, uint32_t seed) {
    const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
    const auto ease = [](double t) { return t * t * (3 - 2 * t); };
    const double u = ease(p.x - fx), v = ease(p.y - fy), w = ease(p.z - fz);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
        const uint32_t h = hash(static_cast<int64_t>(fx) + i, static_cast<int64_t>(fy) + j,
                                static_cast<int64_t>(fz) + k, seed);
        sum += (i ? u : 1 - u) * (j ? v : 1 - v) * (k ? w : 1 - w) *
               (static_cast<double>(h) / 2147483647.5 - 1);
    }
    return sum;
}

/// Octaves of value noise, each half as long and `persistence` as high; -1..1 for the first.
double fractal_noise(Vec3 p, const TerrainItem& t, uint32_t seed) {
    double sum = 0, height = 1, frequency = 1 / t.wavelength_m;
    for (int octave = 0; octave < t.octaves; ++octave) {
        sum += height * value_noise(p * frequency, seed + static_cast<uint32_t>(octave));
        height *= t.persistence;
        frequency *= 2;
    }
    return sum;
}

/// No fractal_noise is further from 0.
double largest_noise(const TerrainItem& t) {
    double sum = 0, height = 1;
    for (int octave = 0; octave < t.octaves; ++octave, height *= t.persistence) sum += height;
    return sum;
}

/// Distance into the nearest hollow [m], positive inside: one ball in each cube of the lattice.
double hollow(Vec3 p, const TerrainItem& t) {
    const Vec3 cell = p * (1 / t.cave_spacing_m);
    const double reach = t.cave_radius_m / t.cave_spacing_m;
    const auto gap = [](double at, int cube) { return std::max({0.0, cube - at, at - cube - 1}); };
    const int cx = static_cast<int>(std::floor(cell.x)), cy = static_cast<int>(std::floor(cell.y)),
              cz = static_cast<int>(std::floor(cell.z));
    double deepest = -t.cave_spacing_m;
    for (int i = cx - 1; i <= cx + 1; ++i) {
        for (int j = cy - 1; j <= cy + 1; ++j) {
            for (int k = cz - 1; k <= cz + 1; ++k) {
                if (length({gap(cell.x, i), gap(cell.y, j), gap(cell.z, k)}) > reach) continue;
                const auto random = [&](uint32_t which) {
                    return hash(i, j, k, static_cast<uint32_t>(t.seed) + 100 + which) /
                           4294967295.0;
                };
                const Vec3 center{i + random(0), j + random(1), k + random(2)};
                const double radius = t.cave_radius_m * (0.4 + 0.6 * random(3));
                deepest = std::max(deepest, radius - length(p - center * t.cave_spacing_m));
            }
        }
    }
    return deepest;
}

}  // namespace

DensityFunction terrain_density(const TerrainItem& terrain, UpAxis up, Vec3 floor_center_m) {
    return [terrain, up, floor_center_m](Vec3 world) {
        const Vec3 d = world - floor_center_m;
        const Vec3 p = up == UpAxis::z ? d : Vec3{d.x, -d.z, d.y};  // z up
        // Only the sign counts: no noise above the highest rock, no hollows where there is no rock.
        const double highest_rock =
            terrain.base_m + terrain.amplitude_m * largest_noise(terrain) - p.z;
        if (highest_rock <= 0) return highest_rock;
        // Nor noise below the lowest rock; half a noise more than there can be, for roundings.
        const bool is_below =
            terrain.base_m - p.z > 1.5 * terrain.amplitude_m * largest_noise(terrain) + 1e-6;
        if (is_below) return terrain.kind == "caves" ? -hollow(p, terrain) : terrain.base_m - p.z;
        const auto seed = static_cast<uint32_t>(terrain.seed);
        Vec3 warped = p;
        if (terrain.overhang_m > 0) {
            warped.x += terrain.overhang_m * fractal_noise(p, terrain, seed + 40);
            warped.y += terrain.overhang_m * fractal_noise(p, terrain, seed + 80);
        }
        const double surface =
            terrain.base_m +
            terrain.amplitude_m * fractal_noise({warped.x, warped.y, 0}, terrain, seed);
        const double rock = surface - p.z;
        return rock > 0 && terrain.kind == "caves" ? std::min(rock, -hollow(p, terrain)) : rock;
    };
}

Status check_terrain_cost(const TerrainItem& terrain, const SoilDef& soil) {
    if (terrain.kind == "mesh") return Done{};
    const Vec3 voxels = soil.size_m * (1 / soil.voxel_m);
    const bool y_up = soil.up == UpAxis::y;
    const double height = y_up ? voxels.y : voxels.z;
    const double columns = voxels.x * (y_up ? voxels.z : voxels.y);
    const double rough = 3 * terrain.amplitude_m * largest_noise(terrain) / soil.voxel_m;
    const double samples = columns * kSamplesOfVoxel;
    const double noises = samples * std::min(height, rough) * terrain.octaves *
                          (terrain.overhang_m > 0 ? kWarpedNoises : 1);
    const double hollows = terrain.kind == "caves" ? samples * height * kNoisesOfHollow : 0;
    if (noises + hollows <= kNoiseCapacity) return Done{};
    return Error{fmt::format(
        "its noise would be computed {:.2g} times, at most {:.2g} are possible: take larger "
        "voxels, a smaller box, fewer octaves, no overhang, or a mesh",
        noises + hollows, kNoiseCapacity)};
}

}  // namespace bsoil::scene
