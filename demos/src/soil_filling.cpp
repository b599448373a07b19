#include "soil_filling.h"

#include <algorithm>
#include <cmath>

namespace bsoil::scene {
namespace {

uint32_t hash(int x, int y, int z, int seed) {
    uint32_t h = static_cast<uint32_t>(seed) * 0x9e3779b1u;
    for (const int v : {x, y, z}) {
        h ^= static_cast<uint32_t>(v) * 0x85ebca6bu;
        h = (h ^ (h >> 15)) * 0x2c1b3c6du;
        h ^= h >> 13;
    }
    return h;
}

/// -1..1 at the corners of the unit lattice, smooth between them.
double value_noise(Vec3 p, int seed) {
    const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
    const auto ease = [](double t) { return t * t * (3 - 2 * t); };
    const double u = ease(p.x - fx), v = ease(p.y - fy), w = ease(p.z - fz);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
        const uint32_t h = hash(static_cast<int>(fx) + i, static_cast<int>(fy) + j,
                                static_cast<int>(fz) + k, seed);
        sum += (i ? u : 1 - u) * (j ? v : 1 - v) * (k ? w : 1 - w) *
               (static_cast<double>(h) / 2147483647.5 - 1);
    }
    return sum;
}

/// Octaves of value noise, each half as long and `persistence` as high; -1..1 for the first.
double fractal_noise(Vec3 p, const TerrainItem& t, int seed) {
    double sum = 0, height = 1, frequency = 1 / t.wavelength_m;
    for (int octave = 0; octave < t.octaves; ++octave) {
        sum += height * value_noise(p * frequency, seed + octave);
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
    for (int i = cx - 1; i <= cx + 1; ++i)
        for (int j = cy - 1; j <= cy + 1; ++j)
            for (int k = cz - 1; k <= cz + 1; ++k) {
                if (length({gap(cell.x, i), gap(cell.y, j), gap(cell.z, k)}) > reach) continue;
                const auto random = [&](int which) {
                    return hash(i, j, k, t.seed + 100 + which) / 4294967295.0;
                };
                const Vec3 center{i + random(0), j + random(1), k + random(2)};
                const double radius = t.cave_radius_m * (0.4 + 0.6 * random(3));
                deepest = std::max(deepest, radius - length(p - center * t.cave_spacing_m));
            }
    return deepest;
}

Status at(const Scene& scene, const SceneItem& item, const Status& status) {
    if (status) return status;
    return Error{scene.message(item.at, status.error())};
}

Status put_in(const FillItem& item, const std::string& material, Soil& soil) {
    if (item.kind == "box") return soil.fill(BoxFill{{item.min_m, item.max_m}, material});
    if (item.kind == "cylinder")
        return soil.fill(CylinderFill{item.base_center_m, item.radius_m, item.height_m, material});
    if (item.kind == "height_map") {
        HeightMapFill fill = item.height_map;
        fill.material = material;
        return soil.fill(fill);
    }
    NoiseFill fill = item.noise;
    fill.material = material;
    return soil.fill(fill);
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
        Vec3 warped = p;
        if (terrain.overhang_m > 0) {
            warped.x += terrain.overhang_m * fractal_noise(p, terrain, terrain.seed + 40);
            warped.y += terrain.overhang_m * fractal_noise(p, terrain, terrain.seed + 80);
        }
        const double surface =
            terrain.base_m +
            terrain.amplitude_m * fractal_noise({warped.x, warped.y, 0}, terrain, terrain.seed);
        const double rock = surface - p.z;
        return rock > 0 && terrain.kind == "caves" ? std::min(rock, -hollow(p, terrain)) : rock;
    };
}

Status fill_soil(const Scene& scene, Soil& soil) {
    for (const TerrainItem& terrain : scene.terrains) {
        const Status added = terrain.kind == "mesh"
                                 ? soil.add_terrain(terrain.mesh)
                                 : soil.add_terrain(terrain_density(terrain, soil.def().up,
                                                                    soil.def().floor_center_m));
        if (!added) return at(scene, terrain, added);
    }
    for (const FillItem& fill : scene.fills) {
        const std::string material =
            fill.material.empty() ? soil.materials().front().name : fill.material;
        const Status filled = put_in(fill, material, soil);
        if (!filled) return at(scene, fill, filled);
    }
    return Done{};
}

Status set_surfaces(const Scene& scene, const BulletScene& world, bullet::SoilAction& action) {
    for (const SceneBody& body : world.bodies()) {
        if (!body.item->tool_friction && !body.item->tool_adhesion_pa) continue;
        const SurfaceFriction as_material;
        bullet::BodyOptions options = action.options(*body.object);
        options.surface = {body.item->tool_friction.value_or(as_material.friction),
                           body.item->tool_adhesion_pa.value_or(as_material.adhesion_pa)};
        const Status set = action.set_options(*body.object, options);
        if (!set) return Error{scene.message(body.item->at, set.error())};
    }
    return Done{};
}

}  // namespace bsoil::scene
