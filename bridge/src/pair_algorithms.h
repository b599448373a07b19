/// Collision algorithms of pairs, made outside of Bullet's own search for contacts.
#pragma once

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

namespace bsoil::bullet {

/// Those that a pair's algorithm has made.
btManifoldArray manifolds_of(const btBroadphasePair& pair);

/// As Bullet's near callback does, but without asking the host's. How many manifolds there are
/// follows from the pair's shapes, boxes and poses, whatever a soil holds; their points do not
/// count.
void make_algorithm(btDiscreteDynamicsWorld& world, btBroadphasePair& pair);

/// Puts an algorithm as make_algorithm would make it in place of a pair's, with its points, where
/// that may be another.
void renew_algorithm(btDiscreteDynamicsWorld& world, btBroadphasePair& pair);

}  // namespace bsoil::bullet
