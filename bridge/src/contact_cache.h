/// Bullet's broadphase and contact cache as bytes and back.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include "bsoil/snapshot_file.h"

namespace bsoil::bullet {

/// Error: the world has a broadphase or dispatcher that serialize_contacts does not know.
Status check_contacts(btDiscreteDynamicsWorld& world);

/// The order in which Bullet finds pairs, and solves contacts, follows from the shape of its
/// bounding box trees and from all that has met before; a rebuilt world has another. So this writes
/// the trees, the pairs and the contact points in their order, and builds just these when it reads.
/// The objects' transforms must be in place. What algorithms keep besides contact points cannot be
/// written: those of compounds and triangle meshes are made anew when writing, too. Refuses what
/// does not fit.
void serialize_contacts(StateStream& stream, btDiscreteDynamicsWorld& world);

}  // namespace bsoil::bullet
