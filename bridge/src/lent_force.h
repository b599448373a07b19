/// LentForce: forces that a body has for a substep and that are taken off it again, if its host has
/// not cleared all of its forces in between.
#pragma once

#include <LinearMath/btVector3.h>

namespace bsoil::bullet {

/// Bullet knows a body's sum of forces alone, and an action of its host ahead of the soil's may set
/// that to nothing and begin anew. The mark is the fourth number of the sum of torques: nobody
/// reckons with it, and who clears the three sets it to 0 too. It counts what is lent.
class LentForce {
  public:
    /// torque: the body's own sum, to which something has been added.
    static void lend(const btVector3& torque) { mark_of(torque) += 1; }
    /// Whether what was lent is still there, to be taken off.
    static bool take(const btVector3& torque) {
        if (mark_of(torque) == 0) return false;
        mark_of(torque) -= 1;
        return true;
    }

  private:
    /// Bullet shows its sums as constants, of bodies that are none.
    static btScalar& mark_of(const btVector3& torque) {
        return const_cast<btVector3&>(torque).m_floats[3];
    }
};

}  // namespace bsoil::bullet
