/// CarriedLoads: the soil that bodies carry weighs on them and has to be accelerated by them, and
/// soil that falls on them pushes.
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
///
/// So the solver gives the load the body's change of velocity. What the body has really given the
/// soil is BodyLoad::impulse_n_s: more where soil has fallen on it or was taken aboard, less where
/// its load slides. The difference is a debt of momentum, which the body pays over the time of a
/// soil step, or of more where its load is much heavier than it is. Body and soil together keep
/// their momentum, but for the share of a debt that soil takes along when it leaves. What carries
/// nothing, or far more than its mass, and is held by no joint pays no more than makes it as fast
/// as the fastest soil.
///
/// Where walls hold up a part of a load (BodyLoad::held_kg), the weight of that part is taken off
/// the body that carries it and given to the wall, at one point.
///
/// A rigid body may get impulses between substeps, when it has its own mass alone: from the struts
/// of a vehicle, from the host. Its load takes its share in the next substep. A body that its host
/// has put elsewhere leaves its load behind, as the soil sees it.
class CarriedLoads {
  public:
    CarriedLoads(btDiscreteDynamicsWorld& world, Vec3 up, double gravity_m_s2);

    /// A soil step is through: what bodies have given soil in it.
    void note_given(std::span<const BodyLoad> loads);
    /// Loads of the last soil step. interval_s: time of the soil's steps since the last call.
    /// soil_speed_m_s: no soil is faster, but what bodies take along.
    void set_loads(std::span<const BodyState> bodies, std::span<const BodyLoad> loads,
                   double interval_s, double soil_speed_m_s);
    /// swept_most_m: a body that its host has moved further the soil puts down anew.
    void open_substep(double swept_most_m);
    /// substep_s: how long Bullet has solved with the loads; 0 where it has not.
    void close_substep(double substep_s);
    /// Weight of its load, less what walls hold of it, and push that a body felt in the last
    /// substep.
    Vec3 felt_n(int body) const;
    /// Forgets all loads. Between substeps.
    void let_go();

  private:
    friend class CouplingSnapshot;
    struct Loaded {
        BodyState body;
        BodyLoad load;
        /// What the body has given soil and not paid for; angular about its centre of mass.
        Vec3 debt_n_s, debt_n_m_s;
        Vec3 push_n, push_n_m;      ///< pays it
        Vec3 left_m;                ///< place at the end of the last substep
        Vec3 left_m_s, left_rad_s;  ///< speeds then, of a rigid body
        btScalar own_mass_kg = 0;
        btVector3 own_inertia{0, 0, 0};                   ///< 0 where the host has locked the axis
        btVector3 force_n{0, 0, 0}, torque_n_m{0, 0, 0};  ///< all that is applied while it is open
        btVector3 turned_rad_s{0, 0, 0};                  ///< and what its torque has turned it by
        Vec3 felt_n;                                      ///< of that, weight and push
        bool open = false;
    };
    /// What of a body's inertia is its load's.
    struct Share {
        double mass_kg = 0;
        btVector3 inertia_kg_m2{0, 0, 0};  ///< about the body's centre, in its axes
    };
    static Share share_of(const Loaded& loaded);
    Loaded* find_loaded(std::span<const BodyState> bodies, std::map<int, Loaded>& before,
                        const BodyLoad& load);
    static void share_debt(Loaded& loaded, const Share& before);
    void forgive_excess(std::span<const BodyState> bodies, double soil_speed_m_s,
                        Loaded& loaded) const;
    bool is_left_behind(const Loaded& loaded, double swept_most_m) const;
    bool is_put_elsewhere(const Loaded& loaded, double substep_s) const;
    void open(Loaded& loaded, bool is_only_soil);
    static void note_left(const BodyState& body, Loaded& loaded);
    void add_push_since_left(const btRigidBody& rigid, Loaded& loaded) const;

    btDiscreteDynamicsWorld& world_;
    Vec3 up_;
    double gravity_m_s2_;
    double swept_most_m_ = 0;       ///< of the last open_substep
    std::map<int, Loaded> loaded_;  ///< by SoilBody::id
    std::map<int, Vec3> given_;     ///< since the last set_loads() [N s]
    std::map<int, Vec3> felt_n_;    ///< in the last substep
};

}  // namespace bsoil::bullet
