/// CarriedLoads: the soil that bodies carry weighs on them and has to be accelerated by them.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <map>
#include <span>
#include <vector>

#include "body_state.h"
#include "bsoil/body.h"

namespace bsoil::bullet {

/// From open_substep to close_substep a loaded rigid body, multibody link or free base has its
/// load's mass besides its own, and the load's moment of inertia about the body's centre of mass,
/// so that Bullet's solver accelerates both; in between the host sees its own figures. The centre
/// of mass stays the body's: of the coupling between turning and shifting only the load's weight is
/// taken, not its inertia.
class CarriedLoads {
  public:
    CarriedLoads(btDiscreteDynamicsWorld& world, Vec3 up, double gravity_m_s2);

    /// Loads of this soil step.
    void set_loads(std::span<const BodyState> bodies, std::span<const BodyLoad> loads);
    void open_substep();
    void close_substep();
    /// Forgets all loads. Between substeps.
    void let_go();

  private:
    friend class CouplingSnapshot;
    struct Loaded {
        BodyState body;
        BodyLoad load;
        btScalar own_mass_kg = 0;
        btVector3 own_inertia{0, 0, 0};  ///< 0 where the host has locked the axis
        btVector3 weight_n{0, 0, 0}, arm_m{0, 0, 0};
        bool open = false;
    };
    void open(Loaded& loaded);

    btDiscreteDynamicsWorld& world_;
    Vec3 up_;
    double gravity_m_s2_;
    std::map<int, Loaded> loaded_;  ///< by SoilBody::id
};

}  // namespace bsoil::bullet
