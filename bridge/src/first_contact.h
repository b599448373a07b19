/// FirstContacts: free bodies that come down onto soil, from the substep in which they meet it
/// until they have stopped.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <map>
#include <optional>
#include <vector>

#include "body_collector.h"
#include "bsoil/contact/impact.h"
#include "bsoil/host/soil_below.h"
#include "contact_coupling.h"

namespace bsoil::bullet {

/// The soil's contacts are as old as its last step. In that time a falling body moves further than
/// its impact is deep. So FirstContacts finds what the underside of a body from above will meet
/// during Bullet's substep, and solves its motion through that. It sets the limits of the body's
/// rows so that Bullet takes it to where the solution ends. After that the soil's contacts hold it.
/// Three cases wait for the soil's own step: a body on joints, which is not free, one that its host
/// has locked against the soil's push, and soil that a body carries, which yields together with its
/// carrier. Soil in a body's hollow or between its legs is not what it falls on: what its underside
/// meets lies below that.
class FirstContacts {
  public:
    /// The references must outlive this.
    FirstContacts(BodyCollector& collector, ContactCoupling& coupling, const SoilBelow& soil_below,
                  Vec3 up)
        : collector_(collector), coupling_(coupling), soil_below_(soil_below), up_(up) {}

    /// Start of a substep of the world's dispatch time, before the coupling's; may be called again
    /// within it. loads: as of the last soil step, and whether there was any: before it bodies
    /// count that are fast alone. Cost: lines through the shapes of each body in impact, 150 or one
    /// for each voxel of its underside.
    void open_substep(btDiscreteDynamicsWorld& world, std::span<const BodyLoad> loads,
                      bool has_stepped);
    /// End of a substep.
    void close_substep();
    /// After a step of the soil: lets go bodies that its contacts hold.
    void soil_has_stepped(double step_s);
    void let_go() { bodies_.clear(); }

  private:
    friend class CouplingSnapshot;
    struct Falling {
        SurfaceSoil surface;
        /// Bullet's speed into the soil is that of the substep's middle. At its end the body is
        /// faster by this much.
        double lead_m_s = 0;
        double next_lead_m_s = 0;  ///< once the substep is through
        double speed_m_s = 0;      ///< into the soil, at its end
        double age_s = 0;          ///< since it met the surface
        bool is_new = false;       ///< meets the surface in this substep
        bool is_open = false;      ///< met the soil in this substep
    };
    bool has_stopped(double speed_m_s, double duration_s) const;
    void find_jointed(btDiscreteDynamicsWorld& world);
    void find_carriers(const btDiscreteDynamicsWorld& world, std::span<const BodyLoad> loads,
                       bool has_stepped);
    bool is_over_carrier(const Aabb& box, const btCollisionObject& but) const;
    void open(btDiscreteDynamicsWorld& world, btRigidBody& body, double substep_s,
              bool has_stepped);
    void leave_what_meets(Vec3 up_m, const SurfacePoint& plane);
    /// A body that moves into the soil; impact_ is started for it.
    struct Approach {
        Fall fall;
        double bullet_m_s = 0;  ///< Bullet's speed of the point that meets the soil, into it
        BodyMotion direction;
    };
    /// Empty where it does not meet the soil in this substep.
    std::optional<Approach> approach(const BodyState& state, std::span<const ConvexShape> shapes,
                                     Vec3 acceleration_m_s2, double substep_s,
                                     const Falling& falling);
    bool meet(const BodyState& body, std::span<const ConvexShape> shapes, Vec3 acceleration_m_s2,
              double substep_s, Falling& falling);

    BodyCollector& collector_;
    ContactCoupling& coupling_;
    const SoilBelow& soil_below_;
    Vec3 up_;
    std::map<int, Falling> bodies_;                     ///< by body id
    std::vector<const btCollisionObject*> jointed_;     ///< sorted
    std::map<const btCollisionObject*, Vec3> given_n_;  ///< by other soils, before the solve
    std::vector<std::pair<const btCollisionObject*, Aabb>> carriers_;  ///< boxes of those of soil
    std::vector<ContactVoxel> elements_;
    Impact impact_;
    std::vector<ContactPatch> patches_;
};

}  // namespace bsoil::bullet
