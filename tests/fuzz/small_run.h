/// A few steps of a scene, and a soil of a few voxels.
#pragma once

#include <memory>

#include "bsoil/soil.h"
#include "scene/scene.h"

namespace bsoil::fuzz {

/// Makes two steps of a scene that takes milliseconds, and checks that its soil is conserved.
void run_if_small(const scene::Scene& scene);

/// An empty soil of 10 x 16 x 10 voxels.
std::unique_ptr<Soil> small_soil();

}  // namespace bsoil::fuzz
