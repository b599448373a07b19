/// PatchRow: one contact patch as Bullet's solver sees it, the same for rigid bodies and multibody links.
#pragma once

#include <LinearMath/btVector3.h>

namespace bsoil::bullet {

/// One normal and two tangential rows at a point. Forces [N]: a row's impulse limit is its force times the substep.
struct PatchRow {
    btVector3 offset_m{0, 0, 0};  ///< from the centre of mass to the point, world axes
    btVector3 normal{0, 1, 0};    ///< unit, out of the body: the normal row pushes against it
    btVector3 tangent[2] = {{1, 0, 0}, {0, 0, 1}};  ///< unit, across the normal and each other
    btScalar normal_limit_n = 0;      ///< the normal row gives 0 up to this
    btScalar tangential_limit_n = 0;  ///< the tangential rows give up to this either way
};

}  // namespace bsoil::bullet
