/// What the soil of a voxel looks like where it lies bare.
#pragma once

#include <array>

#include "bsoil/soil.h"

namespace bsoil::mesh {

using Color = std::array<float, 3>;  ///< linear RGB

/// Its material's colour with what has happened to the soil: moved soil is darker and richer,
/// compacted soil paler. In steps, so that a surface is not meshed again for what no one sees.
Color worn_color(const MaterialDef& material, const VoxelSample& sample);

/// How bright soil is with water in this share of its pores, 0..1, of the dry one.
float wet_brightness(float saturation);
/// Saturation as Mesh::wetness has it, in the same steps.
uint8_t wetness_of(double saturation);

}  // namespace bsoil::mesh
