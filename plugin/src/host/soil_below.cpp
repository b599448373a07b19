#include "bsoil/host/soil_below.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bsoil {
namespace {

/// A voxel with this share of soil or rock in it is below the surface. Ours: half, where the error
/// of either answer is the same. Larger, and a loose crust is looked through.
constexpr double kMostlyFullShare = 0.5;
/// The topmost surface of a column is the one below a body unless it is this far [voxels] from what
/// the column holds there. Ours: a surface's heights and a column's voxels differ by one voxel at
/// most, so more means a roof or a gap between them. Larger, and a body under a roof lands on the
/// roof's height.
constexpr double kSameSurfaceVoxels = 1.5;
/// A plane may go higher than the surface under a body by this much [voxels]. Ours: between two
/// columns the surface is known no better. Larger, and a body beside a bank is held in the air;
/// smaller, and the bumps of a slope count.
constexpr double kHigherVoxels = 0.5;
/// Heights looked at along a side of a box, a voxel apart or more. Ours: as many columns as a
/// falling body's box has in most scenes. More take longer; with fewer a bank under a large body is
/// missed, which the body then meets by its contacts.
constexpr int kHeightsMost = 16;

/// Where soil of this density stands between loose (0) and compacted (1), by its own mixture:
/// volumes of its materials add up.
/// shares: by mass, of each material
double relative_density(std::span<const MaterialDef> materials, std::span<const double> shares,
                        double density_kg_m3) {
    double loose = 0, compacted = 0;  // volume of a unit of mass
    for (size_t m = 0; m < materials.size(); ++m) {
        const MaterialDef& material = materials[m];
        const bool has_range = material.has_density_range();
        loose += shares[m] / (has_range ? material.loose_density_kg_m3 : material.density_kg_m3);
        compacted +=
            shares[m] / (has_range ? material.compacted_density_kg_m3 : material.density_kg_m3);
    }
    return std::clamp((loose - 1 / density_kg_m3) / (loose - compacted), 0.0, 1.0);
}

}  // namespace

std::optional<SurfaceSoil> SoilBelow::at(Vec3 world_m) const {
    const GridFrame& frame = soil_.frame();
    const Vec3 at = frame.to_grid(world_m);
    if (!(at.x >= 0 && at.x < frame.size[0] && at.y >= 0 && at.y < frame.size[1])) return {};
    if (std::isnan(at.z)) return {};
    const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
    int z = static_cast<int>(std::floor(std::clamp(at.z, 0.0, frame.size[2] - 1.0)));
    const auto filled = [&](int level) {
        const VoxelSample voxel = soil_.sample_matter(x, y, level);
        return voxel.volume + voxel.coverage;
    };
    if (filled(z) >= kMostlyFullShare) {
        while (z + 1 < frame.size[2] && filled(z + 1) >= kMostlyFullShare) ++z;
    } else {
        while (z > 0 && filled(z) < kMostlyFullShare) --z;
    }
    double top = z + std::min(1.0, filled(z));
    if (top >= z + 1 && z + 1 < frame.size[2]) top += filled(z + 1);
    VoxelSample beneath = soil_.sample_matter(x, y, z);
    if (!(beneath.volume > 0)) return {};

    SurfaceSoil out;
    const std::optional<SurfacePoint> surface =
        surface_.at(at.x * frame.voxel_m, at.y * frame.voxel_m);
    if (surface && std::abs(surface->position_m.z / frame.voxel_m - top) < kSameSurfaceVoxels) {
        out.plane = {transform(frame.grid_to_world, surface->position_m),
                     rotate(frame.grid_to_world.rotation, surface->normal)};
    } else {
        out.plane = {frame.to_world({at.x, at.y, top}), up_};
    }
    out.material = beneath.material;
    out.saturation = beneath.saturation;
    out.undisturbed = beneath.undisturbed;
    if (soil_.materials()[static_cast<size_t>(beneath.material)].has_density_range()) {
        out.relative_density = relative_density(soil_.materials(), soil_.material_shares(x, y, z),
                                                beneath.density_kg_m3);
    }
    return out;
}

double SoilBelow::highest_under_m(const Aabb& box) const {
    const GridFrame& frame = soil_.frame();
    // Up is the world's y or z; the two others are level.
    const Vec3 size = box.max - box.min, across{size.x, 0, 0};
    const Vec3 along = size - across - dot(size, up_) * up_;
    const auto parts_of = [&](Vec3 side) {
        return static_cast<int>(
            std::clamp<double>(std::ceil(length(side) / frame.voxel_m), 1, kHeightsMost - 1));
    };
    const int across_count = parts_of(across), along_count = parts_of(along);
    double highest_m = -std::numeric_limits<double>::infinity();
    for (int i = 0; i <= across_count; ++i) {
        for (int k = 0; k <= along_count; ++k) {
            const Vec3 at = frame.to_grid(box.min + 1.0 * i / across_count * across +
                                          1.0 * k / along_count * along);
            if (const auto point = surface_.at(at.x * frame.voxel_m, at.y * frame.voxel_m)) {
                highest_m = std::max(highest_m,
                                     dot(transform(frame.grid_to_world, point->position_m), up_));
            }
        }
    }
    return highest_m;
}

std::optional<SurfaceSoil> SoilBelow::under(const Aabb& box) const {
    const Vec3 middle = 0.5 * (box.min + box.max);
    std::optional<SurfaceSoil> out = at(middle);
    if (!out) return out;
    SurfacePoint& plane = out->plane;
    const double upright = dot(plane.normal, up_);
    const Vec3 uphill = upright * up_ - plane.normal;  // level, as long as the slope's sine
    const double sine = length(uphill);
    if (!(upright > 0) || !(sine > 0)) return out;
    const Vec3 half = 0.5 * (box.max - box.min);
    const double reach_m =
        (std::abs(uphill.x) * half.x + std::abs(uphill.y) * half.y + std::abs(uphill.z) * half.z) /
        sine;
    const double higher_m = kHigherVoxels * soil_.frame().voxel_m;
    if (reach_m * sine <= higher_m * upright) return out;
    const double most_m =
        higher_m + std::max(0.0, highest_under_m(box) - dot(plane.position_m, up_));
    const double slope = most_m / reach_m;
    if (sine <= slope * upright) return out;
    const Vec3 normal = up_ - slope / sine * uphill;
    plane.normal = normal * (1 / length(normal));
    return out;
}

}  // namespace bsoil
