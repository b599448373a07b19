/// A btMultiBody from bodies and joints of a scene.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scene_shapes.h"

namespace bsoil::scene {

/// One body of a multibody.
struct MultibodyLink {
    const BodyItem* item = nullptr;
    const JointItem* joint = nullptr;  ///< that the body hangs on; null: it is the base
    int parent = -1;                   ///< index among the multibody's bodies; -1: the world
    size_t body_index = 0;             ///< in the scene
    SceneShapes::BodyShape shape;
};

/// Parents come before their children. Without a base among them the bodies hang on the world.
struct MultibodyItem {
    std::string name;
    std::vector<MultibodyLink> links;
};

/// Keeps the bodies of a group apart. Bullet's own list of bodies to ignore does not hold between
/// links of different multibodies.
class GroupFilter final : public btOverlapFilterCallback {
  public:
    /// Before the object enters the world. Nothing where the group has no name.
    void add(const btCollisionObject& object, const std::string& group);
    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override;

  private:
    std::map<const void*, std::string> group_of_;
};

/// Owns the multibody, its colliders, limits and motors, and takes them out of the world again.
class SceneMultibody {
  public:
    SceneMultibody(btMultiBodyDynamicsWorld& world, GroupFilter& filter, const MultibodyItem& item,
                   double substep_s);
    ~SceneMultibody();
    SceneMultibody(const SceneMultibody&) = delete;
    SceneMultibody& operator=(const SceneMultibody&) = delete;

    btMultiBody& multibody() const { return *multibody_; }
    /// Bullet's number of the i-th body: -1 for the base.
    int link_index(size_t i) const {
        return has_base_ ? static_cast<int>(i) - 1 : static_cast<int>(i);
    }
    btMultiBodyLinkCollider* collider(size_t i) const { return colliders_[i].get(); }
    /// Of the joint the i-th body hangs on; null where it has no motor.
    btMultiBodyJointMotor* motor(size_t i) const { return motors_[i]; }
    /// Before each substep: as much as friction and damping of the joints can do in it.
    void resist(double substep_s);

  private:
    void set_up_link(const MultibodyItem& item, size_t i);
    void add_collider(GroupFilter& filter, const MultibodyLink& link, size_t i);
    void add_limit_and_motor(const JointItem& joint, size_t i, double substep_s);

    btMultiBodyDynamicsWorld& world_;
    bool has_base_;
    std::unique_ptr<btMultiBody> multibody_;
    std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
    std::vector<std::unique_ptr<btMultiBodyConstraint>> constraints_;
    std::vector<btMultiBodyJointMotor*> motors_;
    /// Stops a joint with no more than its friction and damping; see JointResistance.
    struct Resistance {
        btMultiBodyJointMotor* brake = nullptr;
        int link = -1;
        double friction = 0, damping = 0;
    };
    std::vector<Resistance> resistances_;
};

}  // namespace bsoil::scene
