/// WorldAnchor: tells when a Bullet world opens a substep, and whether the world still exists.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include <functional>

#include "bsoil/soil.h"

namespace bsoil::bullet {

/// An invisible static object in a world: no contacts, no rays. Bullet asks for its box after the
/// pre-tick callback and before it looks at constraints, in every substep; no other additive hook
/// lies there.
class WorldAnchor {
  public:
    /// on_open is called at every request for the box; may add constraints to the world. on_deleted
    /// is called when the host deletes the anchor's object, after taking it out of the world.
    /// grid: of its soil.
    WorldAnchor(btCollisionWorld& world, const btVector3& position, std::function<void()> on_open,
                std::function<void()> on_deleted, const GridFrame& grid = {});
    ~WorldAnchor();
    WorldAnchor(const WorldAnchor&) = delete;
    WorldAnchor& operator=(const WorldAnchor&) = delete;

    /// False once the world was destroyed with the anchor in it.
    bool world_exists() const;
    /// Puts the anchor back if the host has taken it out. The world must exist.
    void ensure_in_world();
    const btCollisionObject* object() const;
    /// The grid of a soil whose anchor the object is; null for other objects.
    static const GridFrame* grid_of(const btCollisionObject& object);

  private:
    class Object;
    btCollisionWorld& world_;
    btVector3 position_;
    GridFrame grid_;
    std::function<void()> on_open_, on_deleted_;
    Object* object_ = nullptr;  // owned; the host may delete it as it may any object of its world
    bool listening_ = false;
};

}  // namespace bsoil::bullet
