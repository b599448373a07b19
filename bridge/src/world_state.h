/// The state of a Bullet world as bytes and back: bodies, multibodies, constraints, contacts.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <span>

#include "bsoil/bullet/soil_action.h"
#include "bsoil/snapshot_file.h"

namespace bsoil::bullet {

/// Error: the world holds what world_state does not know.
Status check_world(btDiscreteDynamicsWorld& world, std::span<SoilAction* const> soils);

/// Error: a number is not finite.
Result<std::vector<uint8_t>> world_state(btDiscreteDynamicsWorld& world);

/// The world must hold the same objects, see check_same_objects. Error: other constraints or
/// multibodies, or damaged bytes; then the world is as before.
Status set_world_state(btDiscreteDynamicsWorld& world, std::span<const uint8_t> state);

}  // namespace bsoil::bullet
