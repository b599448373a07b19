/// A few steps of a scene.
#pragma once

#include "scene/scene.h"

namespace bsoil::fuzz {

/// Makes two steps of a scene that takes milliseconds, and checks that its soil is conserved.
void run_if_small(const scene::Scene& scene);

}  // namespace bsoil::fuzz
