/// A scene as a Bullet world: bodies, joints and what drives them. No soil.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "motion.h"
#include "robots/bullet_file.h"
#include "scene/scene.h"
#include "scene_body.h"
#include "scene_multibody.h"
#include "scene_shapes.h"

namespace bsoil::scene {

/// One joint of a scene.
struct SceneJoint {
    std::string name;
    const JointItem* item = nullptr;
    /// Of a joint between rigid bodies; owned by the BulletScene.
    btTypedConstraint* constraint = nullptr;
    btRigidBody* parent = nullptr;
    btRigidBody* child = nullptr;
    btTransform parent_frame, child_frame;  ///< z: hinge and plane axis; x: slider, suspension
    /// Of a joint within a multibody.
    btMultiBody* multibody = nullptr;
    int link = -1;
    btMultiBodyJointMotor* link_motor = nullptr;
    double position = 0;  ///< rad or m, JointItem::start at the start; turns are counted

    bool has_motor() const {
        return (link_motor || constraint) &&
               (item->motor_torque_n_m > 0 || item->motor_force_n > 0);
    }
};

/// The world, its bodies and joints. Rebuild it to repeat a run: a reused Bullet world does not
/// repeat.
class BulletScene {
  public:
    /// The scene must outlive the world. The error names the body or joint that cannot be made.
    static Result<std::unique_ptr<BulletScene>> create(const Scene& scene);
    ~BulletScene();

    /// One Bullet step of WorldItem::substep_s: sets motors and kinematic bodies, then steps.
    void substep();

    btDiscreteDynamicsWorld& world() { return *world_; }
    btVector3 gravity_m_s2() const { return world_->getGravity(); }
    double time_s() const { return static_cast<double>(substep_count_) * substep_s_; }
    const std::vector<SceneBody>& bodies() const { return bodies_; }
    const std::vector<SceneJoint>& joints() const { return joints_; }
    /// What a run knows besides Bullet's own state: substeps made and the joints' counted turns.
    struct Progress {
        int64_t substep_count = 0;
        std::vector<double> joint_positions;
    };
    Progress progress() const;
    /// Of a scene with as many joints.
    void set_progress(const Progress& progress);
    const SceneBody* find_body(const std::string& name) const;
    /// From the next substep on a joint's motor aims at this velocity [rad/s or m/s], whatever the
    /// scene's motions say; none: they do again, and a joint without one holds. Nothing for a joint
    /// without a motor. Not part of the state: a lever stays where it is when another state is put
    /// in.
    void set_lever(size_t joint, std::optional<double> velocity);
    /// What the soil must not meet: the ground plane, since the soil has a floor of its own, and
    /// bodies that ignore it.
    std::vector<const btCollisionObject*> apart_from_soil() const;

  private:
    struct Drive {
        Motion motion;
        int joint = -1;
        int body = -1;
    };

    explicit BulletScene(const Scene& scene);
    Status build();
    void add_body(const BodyItem& item, const SceneShapes::BodyShape& shape);
    void add_to_multibody(const BodyItem& item, const SceneShapes::BodyShape& shape,
                          std::vector<MultibodyItem>& multibodies) const;
    void add_multibody(const MultibodyItem& item);
    void add_joint(const JointItem& item);
    void add_ground();
    Status add_bullet_file(const BulletFileItem& item);
    void separate_groups();
    void drive(const Drive& drive);
    void drive_mimics();
    /// The velocity [rad/s or m/s] that a joint's motor aims at, within what it may.
    void set_motor(const SceneJoint& joint, double velocity);
    void update_joint_positions();
    btVector3 up() const;

    const Scene& scene_;
    double substep_s_;
    int64_t substep_count_ = 0;
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btDbvtBroadphase broadphase_;
    GroupFilter group_filter_;
    std::unique_ptr<btConstraintSolver> solver_;
    std::unique_ptr<btDiscreteDynamicsWorld> world_;
    btMultiBodyDynamicsWorld* multibody_world_ = nullptr;  ///< world_, where there are multibodies
    SceneShapes shapes_;
    std::vector<std::unique_ptr<btMotionState>> motion_states_;
    std::vector<std::unique_ptr<btRigidBody>> owned_bodies_;
    const btRigidBody* ground_ = nullptr;
    std::vector<std::unique_ptr<SceneMultibody>> multibodies_;
    std::vector<std::unique_ptr<BulletFile>> bullet_files_;
    std::vector<std::unique_ptr<btTypedConstraint>> constraints_;
    std::vector<SceneBody> bodies_;
    std::vector<SceneJoint> joints_;
    std::vector<Drive> drives_;
    std::vector<std::optional<double>> levers_;  ///< by joint
};

}  // namespace bsoil::scene
