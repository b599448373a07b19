/// LeftPose: where Bullet has left an object that soil holds. Between substeps no time passes: only
/// its host moves it then, and soil that held it does not go with it.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

#include <optional>

#include "bsoil/geometry.h"

namespace bsoil {
class StateStream;
}

namespace bsoil::bullet {

class LeftPose {
  public:
    /// It is where contacts have found it.
    void set(const btCollisionObject& object) { pose_ = object.getWorldTransform(); }
    /// A substep has passed. opened: where it was at its start. slack_m: beyond what it can have
    /// moved by with its speed; what is more an action of its host has done.
    void close(const btCollisionObject& object, const btTransform& opened, btScalar substep_s,
               double slack_m);
    bool is_at(const btCollisionObject& object) const;
    /// How far its host has put a point of it, at an offset from its centre.
    double moved_m(const btCollisionObject& object, Vec3 offset_m) const;
    void list(StateStream& stream);

  private:
    std::optional<btTransform> pose_;  ///< none: nothing is known yet
};

}  // namespace bsoil::bullet
