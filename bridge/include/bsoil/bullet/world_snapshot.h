/// Snapshots of a whole Bullet world with its soils: a run restored from one goes on bit for bit as
/// the run that wrote it. See docs/snapshots.md for what is in it and what is not.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <span>
#include <string>

#include "bsoil/bullet/soil_action.h"
#include "bsoil/snapshot_file.h"

#pragma GCC visibility push(default)
namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION {

/// Writes the state of the world, of all its soils (`soils`: in any order, the same one at load;
/// none for a world without soil) and of the host (`host`: its own sections, whose names begin with
/// "host") into one file of at most 64 sections, two of which are the world's and two each soil's.
/// Between calls of stepSimulation.
///
/// Writing changes nothing that steps see, with one exception: contacts in which a compound or a
/// triangle mesh takes part are found anew, as they will be after loading.
///
/// Error: the file cannot be written; a pose, velocity or force is not finite; the world has a soil
/// that is not among `soils`, a soft body, a broadphase other than btDbvtBroadphase or a dispatcher
/// other than btCollisionDispatcher.
Status save_world(btDiscreteDynamicsWorld& world, std::span<SoilAction* const> soils,
                  const std::string& path, std::span<const SnapshotSection> host = {});

/// Puts a state back into a world that the host has built as the saved one was built: the same
/// objects, constraints and multibodies in the same order, with the same soils. Error: the file
/// cannot be read, is damaged, or is of another world; it names the first difference and changes
/// nothing.
Status load_world(btDiscreteDynamicsWorld& world, std::span<SoilAction* const> soils,
                  const std::string& path);

}  // namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION
#pragma GCC visibility pop
