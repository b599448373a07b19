/// SoilGround: the soil as a static object of the world, for all that is not coupled with it.
#pragma once

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <functional>

#include "bsoil/bullet/soil_action_types.h"
#include "ground_shape.h"

namespace bsoil::bullet {

/// Owns the object that rays, sweeps and uncoupled bodies meet. The host may take it out of the
/// world, or delete it as it may any object of its world.
class SoilGround {
  public:
    /// surface: of the soil; must outlive this. is_coupled: whether the soil carries the object by
    /// other means; it has no contacts then.
    SoilGround(btDiscreteDynamicsWorld& world, GroundSurface& surface, const GridFrame& frame,
               const SoilActionDef& options,
               std::function<bool(const btCollisionObject&)> is_coupled);
    ~SoilGround();
    SoilGround(const SoilGround&) = delete;
    SoilGround& operator=(const SoilGround&) = delete;

    /// Null once the host has deleted it.
    btRigidBody* object() const;
    /// Whether the object is the ground of any soil.
    static bool is_ground(const btCollisionObject& object);

    /// To be called before Bullet looks for contacts: where its host has let it collide with an
    /// object again (setIgnoreCollisionCheck, removeConstraint), Bullet would ask about no pair.
    void open_substep();

    /// To be called after each soil step: where the surface under a body has changed, its cached
    /// contacts go and it is woken. Cost: a look at each contact manifold of the world.
    void drop_stale_contacts();

  private:
    class Object;
    /// Bullet asks whether the ground collides with an object right before it makes their contacts,
    /// which have the friction of both.
    void fit_arms(const btCollisionObject& other);
    btDiscreteDynamicsWorld& world_;
    Pose grid_to_world_;
    GroundSurface& surface_;
    GroundShape shape_;
    std::function<bool(const btCollisionObject&)> is_coupled_;
    Object* object_ = nullptr;                         // owned; the host may delete it
    btScalar rolling_arm_m_ = 0, spinning_arm_m_ = 0;  ///< as set last
};

}  // namespace bsoil::bullet
