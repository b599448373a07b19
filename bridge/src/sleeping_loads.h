/// SleepingLoads: soil that comes to lie on sleeping bodies, or goes, wakes them.
#pragma once

#include <map>
#include <span>

#include "body_state.h"
#include "bsoil/body.h"

namespace bsoil::bullet {

/// Weight of a load, less what walls hold of it, and push of soil on its body in a soil step [N].
/// gravity_m_s2: of the soil, as a vector.
inline Vec3 force_of(const BodyLoad& load, Vec3 gravity_m_s2, double step_s) {
    return (load.mass_kg - load.held_kg) * gravity_m_s2 - load.impulse_n_s * (1 / step_s);
}

/// What lies on a sleeping body has neither weight nor inertia for Bullet. So a body is woken when
/// the force of its load has changed by more than SoilActionDef::wake_weight_fraction of its own
/// weight and that force together. Means are compared, as of its limits: what is poured for good
/// pushes by turns.
class SleepingLoads {
  public:
    SleepingLoads(const btCollisionWorld& world, double wake_weight_fraction)
        : world_(world), wake_weight_fraction_(wake_weight_fraction) {}

    /// Loads of the last soil step.
    void set_loads(std::span<const BodyState> bodies, std::span<const BodyLoad> loads,
                   Vec3 gravity_m_s2, double step_s);
    /// Forgets all bodies.
    void let_go() { sleepers_.clear(); }

  private:
    friend class CouplingSnapshot;
    struct Sleeper {
        int step_count = 0;  ///< soil steps since it fell asleep, as far as they are counted
        Vec3 mean_n, at_sleep_n;
    };
    bool has_changed(const BodyState& body, Vec3 force_n, Sleeper& sleeper) const;

    const btCollisionWorld& world_;
    double wake_weight_fraction_;
    std::map<int, Sleeper> sleepers_;  ///< by SoilBody::id
};

}  // namespace bsoil::bullet
