/// What the soil of a voxel looks like where it lies bare.
#pragma once

#include <array>

#include "bsoil/soil.h"

namespace bsoil::mesh {

using Color = std::array<float, 3>;  ///< linear RGB

/// Its material's colour with what has happened to the soil: moved soil is darker and richer,
/// compacted soil paler. In steps, so that a surface is not meshed again for what no one sees.
Color worn_color(const MaterialDef& material, const VoxelSample& sample);

}  // namespace bsoil::mesh
