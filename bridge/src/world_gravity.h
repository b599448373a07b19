/// Whether a world pulls its bodies the way a soil pulls its own.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include "bsoil/soil_def.h"

namespace bsoil::bullet {

/// Of the soil, along the world's axes [m/s2].
Vec3 gravity_of(const SoilDef& def);

/// Soil and bodies weigh by gravities that differ by no more than a twentieth, or the world has
/// none (its host pulls each body by itself, or sets it later).
bool has_gravity_of(const btDiscreteDynamicsWorld& world, const SoilDef& def);

/// Error: they differ; it names the field of the definition.
Status check_gravity(const btDiscreteDynamicsWorld& world, const SoilDef& def);

}  // namespace bsoil::bullet
