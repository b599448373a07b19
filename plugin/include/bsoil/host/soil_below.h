/// SoilBelow: the surface of the soil that a body stands on or falls to.
#pragma once

#include <optional>

#include "bsoil/contact/underside.h"
#include "bsoil/host/ground_surface.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Looks for the surface that a body will meet or has met, from where the body is.
class SoilBelow {
  public:
    /// The references must outlive this.
    SoilBelow(const Soil& soil, const GroundSurface& surface, Vec3 up)
        : soil_(soil), surface_(surface), up_(up) {}

    /// The surface next below a point in the air, or next above one in the soil: what lies over a
    /// roof does not count. Empty outside of the grid and where the surface is rock or the floor.
    std::optional<SurfaceSoil> at(Vec3 world_m) const;
    /// The same under the middle of a body's box, world axes. Under its rim the plane is no higher
    /// than the surface gets somewhere under the box, and half a voxel: past the edge of a bank it
    /// would stand in the air. Cost: where it is steeper than that, a height for each column under
    /// the box, 16 x 16 at most.
    std::optional<SurfaceSoil> under(const Aabb& box) const;
    /// Whose surface it is.
    const Soil& soil() const { return soil_; }

  private:
    double highest_under_m(const Aabb& box) const;

    const Soil& soil_;
    const GroundSurface& surface_;
    Vec3 up_;
};

}  // namespace bsoil
#pragma GCC visibility pop
