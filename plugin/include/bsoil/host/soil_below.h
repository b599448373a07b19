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
    /// Whose surface it is.
    const Soil& soil() const { return soil_; }

  private:
    const Soil& soil_;
    const GroundSurface& surface_;
    Vec3 up_;
};

}  // namespace bsoil
#pragma GCC visibility pop
