/// PatchRow: one contact patch as Bullet's solver sees it, the same for rigid bodies and multibody
/// links.
#pragma once

#include <LinearMath/btVector3.h>

#include "coupling_def.h"

namespace bsoil::bullet {

/// One normal and two tangential rows at a point. World axes. Forces [N]: a row's impulse limit is
/// its force times the substep.
struct PatchRow {
    static constexpr int kCount = 3;     ///< of a patch: along its normal and two across
    btVector3 offset_m[kCount];          ///< from the centre of mass to the point where a row acts
    btVector3 direction[kCount];         ///< unit: into the body, then across that and each other
    btVector3 carrier_offset_m[kCount];  ///< the same from that of the body that carries the soil
    btScalar lower_n[kCount] = {0, 0, 0}, upper_n[kCount] = {0, 0, 0};
    /// Along direction[i], of soil on a body that no force moves.
    btScalar carrier_velocity_m_s[kCount] = {0, 0, 0};
    /// Motion since the contact formed that the soil did not yield to: what the solver, which stops
    /// short of its solution, has let through. The rows work it off.
    btVector3 drift_m{0, 0, 0};
    btVector3 preload_n{0, 0, 0};  ///< given to the body before the solve, as a force

    /// Of the point along direction[i], relative to the carrier where the row acts on that too,
    /// that the row aims at [m/s].
    btScalar target_velocity(int i, btScalar substep_s) const {
        constexpr auto kRecovery = static_cast<btScalar>(kCoupling.drift_recovery_share);
        return carrier_velocity_m_s[i] - kRecovery * drift_m.dot(direction[i]) / substep_s;
    }
};

}  // namespace bsoil::bullet
