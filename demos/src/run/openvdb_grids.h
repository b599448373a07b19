/// The soil's voxels as grids of OpenVDB.
#pragma once

#include <string>

#include "bsoil/soil.h"

namespace bsoil::scene {

/// Writes the grids `volume` (soil, fraction of a voxel), `density` [kg/m3], `velocity` [m/s],
/// `material` and `terrain`, in world coordinates; empty voxels are background. The error names the
/// file, or the package that the build lacked.
Status write_openvdb(const Soil& soil, const std::string& path);

}  // namespace bsoil::scene
