/// A plan come to life: a Bullet world with soils, stepped frame by frame.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Vehicle/btRaycastVehicle.h>
#include <btBulletDynamicsCommon.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bsoil/bullet/soil_action.h"
#include "bsoil/bullet/soil_raycaster.h"
#include "collision_shapes.h"
#include "world_plan.h"

namespace bsoil::random_worlds {

struct BuildOptions {
    Backend backend = Backend::cpu;
    int thread_count = 1;
};

class BuiltWorld {
  public:
    /// `start_step`: as the world stands structurally after so many steps, without stepping: for a
    /// snapshot to be loaded into.
    explicit BuiltWorld(const WorldPlan& plan, const BuildOptions& options = {},
                        int start_step = 0);
    ~BuiltWorld();
    BuiltWorld(const BuiltWorld&) = delete;
    BuiltWorld& operator=(const BuiltWorld&) = delete;

    /// What went wrong while it was built; empty: nothing.
    const std::string& error() const { return error_; }
    /// One frame: what the plan has for it, then Bullet.
    void step();
    /// Called after each of Bullet's steps, if set.
    std::function<void()> on_substep;

    const WorldPlan& plan() const { return plan_; }
    int step_count() const { return step_; }
    /// Of all worlds of this program.
    static int64_t all_step_count() { return all_step_count_; }
    double time_s() const { return time_s_; }
    double frame_s() const { return frame_s_; }  ///< of the last frame
    btMultiBodyDynamicsWorld& world() { return *world_; }
    std::vector<bullet::SoilAction*> soils() const;
    bullet::SoilAction& soil(int index) const { return *soils_[static_cast<size_t>(index)]; }
    /// Null while it is not in the world.
    btRigidBody* body(int index) const;
    struct Chain {
        std::unique_ptr<btMultiBody> multibody;
        std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
        std::unique_ptr<btMultiBodyConstraint> motor;
        double own_contact_work_j = 0;  ///< of links with each other; in contact_work_j() too
    };
    const std::vector<Chain>& chains() const { return chains_; }
    struct Car {
        btRigidBody* chassis = nullptr;
        std::unique_ptr<bullet::SoilRaycaster> caster;
        std::unique_ptr<btRaycastVehicle> vehicle;
    };
    const std::vector<Car>& cars() const { return cars_; }
    /// Whether the frame just stepped began with a change by hand: a body put in, taken out, moved
    /// or pushed, soil put in or switched.
    bool was_touched() const { return touched_; }
    /// Units per material that fills of this frame have put in.
    const std::vector<std::vector<int64_t>>& filled_units() const { return filled_; }
    /// And of water, by soil.
    const std::vector<int64_t>& filled_water_units() const { return filled_water_; }
    Vec3 up() const { return up_; }
    double gravity_m_s2() const { return plan_.soils[0].def.gravity_m_s2; }
    /// "body 3 (box)", for reports.
    std::string name_of_object(const btCollisionObject& object) const;
    /// The deepest overlap of two of Bullet's bodies that it met in the frame just stepped [m].
    double deepest_overlap_m() const { return deepest_overlap_m_; }
    /// What Bullet's joints have done on bodies at the soil so far: nothing but rounding, if they
    /// hold. A light body between heavy ones they do not hold; what pulls it back into place is
    /// work.
    double joint_work_j() const { return joint_work_j_; }
    /// What Bullet's contacts have done so far to take bodies apart that overlap.
    double contact_work_j() const { return contact_work_j_; }
    /// What soil has done on bodies so far that sources have poured or wind blows: with its speed,
    /// and with the speed that it fell with.
    double poured_work_j() const { return poured_work_j_; }
    /// Of every pose, velocity and soil, to the bit.
    uint64_t checksum() const;
    /// Whether nothing is awake: neither a body nor a block of soil.
    bool is_all_asleep() const;

  private:
    void add_soil(const SoilPlan& plan, const BuildOptions& options);
    Status fill(int soil, const FillPlan& fill);
    void add_floor();
    void build_bodies();
    void enter(int index);
    void leave(int index);
    void add_joint(const JointPlan& joint);
    void add_chain(const ChainPlan& chain);
    void add_car(const CarPlan& car);
    void add_flows(int soil);
    /// Moves those that are due, or takes them away.
    void change_flows(int step);
    void happen(const EventPlan& event, bool only_structure);
    void apply_step(int step, bool only_structure);
    void drive();
    /// In the world, now.
    Pose driven_pose(const BodyPlan& plan) const;
    void end_action();
    Pose to_world(int soil, const Pose& pose) const;

    WorldPlan plan_;
    std::string error_;
    Vec3 up_;
    CollisionShapes shapes_;
    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_{&configuration_};
    btDbvtBroadphase broadphase_;
    btMultiBodyConstraintSolver solver_;
    std::unique_ptr<btMultiBodyDynamicsWorld> world_;
    struct Body {
        std::unique_ptr<btRigidBody> bullet;
        std::unique_ptr<btDefaultMotionState> motion;
        bool is_in = false;
    };
    std::vector<Body> bodies_;
    std::unique_ptr<btRigidBody> floor_;
    struct Motion {
        btVector3 velocity{0, 0, 0}, spin{0, 0, 0};
    };
    struct Joint {
        std::unique_ptr<btTypedConstraint> bullet;
        JointPlan plan;
        std::unique_ptr<btJointFeedback> feedback;
    };
    /// Before the substep.
    struct Before {
        Motion motion;
        std::vector<BodyLoad> loads;  ///< by soil
    };
    static Motion motion_of(const btCollisionObject& object);
    Motion mean_motion_of(const btCollisionObject& object) const;
    void note_motion();
    void add_joint_work(double substep_s);
    void add_contact_work();
    void add_poured_work(double substep_s);
    class ContactWatch;
    std::vector<Joint> joints_;
    std::vector<Chain> chains_;
    std::vector<Car> cars_;
    std::vector<std::unique_ptr<btRigidBody>> chassis_;
    std::vector<std::unique_ptr<bullet::SoilAction>> soils_;
    std::vector<std::vector<int64_t>> filled_;
    std::vector<int64_t> filled_water_;
    std::vector<std::vector<int>> flow_ids_;  ///< by soil; 0: has none
    int step_ = 0;
    static inline int64_t all_step_count_ = 0;
    double time_s_ = 0, driven_s_ = 0, frame_s_ = 0;
    bool touched_ = false;
    std::unique_ptr<btActionInterface> contact_watch_;
    std::map<const btCollisionObject*, Before> before_;
    double deepest_overlap_m_ = 0, joint_work_j_ = 0, contact_work_j_ = 0, poured_work_j_ = 0;
};

}  // namespace bsoil::random_worlds
