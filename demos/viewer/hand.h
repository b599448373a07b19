/// A hand in the world: takes a body by a point of it and drags it along.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyPoint2Point.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <optional>

#include "bsoil/geometry.h"

namespace bsoil::viewer {

/// What a line of sight meets.
struct Sighting {
    const btCollisionObject* object = nullptr;
    Vec3 point_m;
};

/// The nearest thing on a line of sight that can move or is a kinematic or static body of the
/// world.
std::optional<Sighting> look_along(btDiscreteDynamicsWorld& world, Vec3 from_m, Vec3 to_m);

/// Holds one body at a time by a btPoint2PointConstraint (a link by its multibody's), as strongly
/// as 40 times the body's weight. Lets go at destruction, which has to come before the world's. A
/// body that may not fall asleep may not afterwards.
class Hand {
  public:
    /// substep_s: of the world's steps, for forces are impulses there.
    Hand(btDiscreteDynamicsWorld& world, double substep_s) : world_(world), substep_s_(substep_s) {}
    ~Hand() { let_go(); }
    Hand(const Hand&) = delete;
    Hand& operator=(const Hand&) = delete;

    /// False where the body cannot be dragged: fixed, kinematic.
    bool take(const Sighting& sighting);
    void move_to(Vec3 point_m);
    void let_go();
    const btCollisionObject* held() const { return held_; }
    Vec3 target_m() const { return target_m_; }

  private:
    btDiscreteDynamicsWorld& world_;
    double substep_s_;
    bool was_sleepless_ = false;  ///< what is held, before
    std::unique_ptr<btPoint2PointConstraint> joint_;
    std::unique_ptr<btMultiBodyPoint2Point> link_joint_;
    const btCollisionObject* held_ = nullptr;
    Vec3 target_m_;
};

}  // namespace bsoil::viewer
