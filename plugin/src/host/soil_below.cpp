#include "bsoil/host/soil_below.h"

#include <algorithm>
#include <cmath>

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

}  // namespace

std::optional<SurfaceSoil> SoilBelow::at(Vec3 world_m) const {
    const GridFrame& frame = soil_.frame();
    const Vec3 at = frame.to_grid(world_m);
    const int x = static_cast<int>(std::floor(at.x)), y = static_cast<int>(std::floor(at.y));
    if (x < 0 || y < 0 || x >= frame.size[0] || y >= frame.size[1]) return {};
    int z = static_cast<int>(std::floor(std::clamp(at.z, 0.0, frame.size[2] - 1.0)));
    const auto filled = [&](int level) {
        const VoxelSample voxel = soil_.sample(x, y, level);
        return voxel.volume + voxel.coverage;
    };
    if (filled(z) >= kMostlyFullShare) {
        while (z + 1 < frame.size[2] && filled(z + 1) >= kMostlyFullShare) ++z;
    } else {
        while (z > 0 && filled(z) < kMostlyFullShare) --z;
    }
    double top = z + std::min(1.0, filled(z));
    if (top >= z + 1 && z + 1 < frame.size[2]) top += filled(z + 1);
    VoxelSample beneath = soil_.sample(x, y, z);
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
    const MaterialDef& material = soil_.materials()[static_cast<size_t>(beneath.material)];
    if (material.has_density_range()) {
        out.relative_density =
            std::clamp(material.relative_density(beneath.density_kg_m3), 0.0, 1.0);
    }
    return out;
}

}  // namespace bsoil
