/// What the examples share: the ground they stand on, sand or Bullet's box, and how they are
/// watched until they rest.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "bsoil/bullet/soil_action.h"
#include "bullet_scene.h"

namespace bsoil::bullet {

/// Bullet alone says how far an example can be trusted: how much energy its solver makes, whether
/// and how soon its bodies sleep.
enum class Ground { rigid, sand };

constexpr double kGravity_m_s2 = 9.81;
constexpr int kFramesPerS = 60;

/// What was seen of an example over a time.
struct Course {
    double slept_s = 0;  ///< when the last body fell asleep; as long as it was watched: never
    double risen_j = 0;  ///< most energy above the least there was before
    /// Most, as a mean over a second in which all were awake, of soil force less weight that the
    /// momentum of the bodies does not explain.
    double unbalanced_n = 0;
    double top_speed_m_s = 0;
    double drift_m = 0;  ///< how far the bodies' common centre of mass went sideways
    /// Of a frame, at most: elements of bodies against soil, and columns of 8 voxels that the
    /// kernels looked at. The same on every machine, where milliseconds are not.
    size_t contacts_most = 0;
    int64_t columns_most = 0;
};

/// A world of Bullet's examples, y up, whose ground ends at y = 0.
class Example {
  public:
    struct Bed {
        double side_m = 4, depth_m = 0.5, voxel_m = 0.05;
        int threads = 0;
    };
    Example(Ground ground, const Bed& bed) {
        if (ground == Ground::rigid) {
            // Of the examples' own size.
            scene_.add_box(0, btVector3(50, 50, 50), btVector3(0, -50, 0));
            return;
        }
        SoilDef def;
        def.size_m = {bed.side_m, bed.depth_m + 1, bed.side_m};
        def.floor_center_m = {0, -bed.depth_m, 0};
        def.voxel_m = bed.voxel_m;
        def.backend = Backend::cpu;
        def.thread_count = bed.threads;
        auto made = SoilAction::create(*scene_.world, def);
        if (!made) {
            ADD_FAILURE() << made.error();
            return;
        }
        soil_ = std::move(*made);
        const double far = bed.side_m;
        fill(BoxFill{{{-far, -far, -far}, {far, 0, far}}, "dry_sand"});
    }
    virtual ~Example() {
        if (soil_) {
            EXPECT_EQ(soil_->soil().totals().units, units_);
            EXPECT_EQ(soil_->soil().status_bits(), 0u);
            EXPECT_TRUE(soil_->refused().empty());
        }
        for (const auto& joint : joints_) scene_.world->removeConstraint(joint.get());
    }
    Example(const Example&) = delete;
    Example& operator=(const Example&) = delete;

    /// One frame of 1/60 s.
    void step() {
        before_.clear();
        for (const auto& joint : joints_) {
            before_.emplace_back(joint->getRigidBodyA().getWorldTransform(),
                                 joint->getRigidBodyB().getWorldTransform());
        }
        scene_.world->stepSimulation(btScalar(1) / kFramesPerS, 0);
        ++frame_;
        paid_j_ += joint_work_j() + drive_work_j();
        const double now_j = kept_j();
        least_j_ = std::min(least_j_, now_j);
        risen_j_ = std::max(risen_j_, now_j - least_j_);
    }
    /// Most energy above the least there was before, less what joints, their motors and engines
    /// have done [J]. Soil and ground can only take energy: this came from nowhere.
    double unpaid_j() const { return risen_j_; }
    void run(double seconds) {
        for (int i = 0; i < std::lround(seconds * kFramesPerS); ++i) step();
    }
    /// Runs until all sleep, at most so long. `before_step` drives it.
    Course watch(
        double most_s, const std::function<void()>& before_step = [] {}) {
        Course out;
        const int first = frame_, count = static_cast<int>(std::lround(most_s * kFramesPerS));
        const int all = awake_count();
        bool were_awake = true;  // all of them, in this second: what falls asleep stops dead
        double least_j = energy_j(), impulse_n_s = 0, momentum_n_s = this->momentum_n_s();
        const btVector3 from = center_m();
        int64_t columns = column_count();
        while (frame_ - first < count && awake_count() > 0) {
            before_step();
            step();
            were_awake = were_awake && awake_count() == all;
            const double now_j = energy_j();
            out.risen_j = std::max(out.risen_j, now_j - least_j);
            least_j = std::min(least_j, now_j);
            out.top_speed_m_s = std::max(out.top_speed_m_s, top_speed_m_s());
            if (has_soil()) {
                out.contacts_most =
                    std::max(out.contacts_most, soil_->last_report().contacts.size());
                const int64_t before = std::exchange(columns, column_count());
                out.columns_most = std::max(out.columns_most, columns - before);
                impulse_n_s += (soil_force_n() - weight_n() - damping_n()) / kFramesPerS;
            }
            if ((frame_ - first) % kFramesPerS == 0) {
                const double now_n_s = this->momentum_n_s();
                const double change_n_s = now_n_s - momentum_n_s;
                if (were_awake) {
                    out.unbalanced_n =
                        std::max(out.unbalanced_n, std::abs(impulse_n_s - change_n_s));
                }
                momentum_n_s = now_n_s;
                impulse_n_s = 0;
                were_awake = true;
            }
        }
        out.slept_s = static_cast<double>(frame_ - first) / kFramesPerS;
        btVector3 way = center_m() - from;
        way.setY(0);
        out.drift_m = static_cast<double>(way.length());
        return out;
    }
    double time_s() const { return static_cast<double>(frame_) / kFramesPerS; }
    int awake_count() const {
        int count = 0;
        for (const auto& body : scene_.bodies) {
            count += !body->isStaticOrKinematicObject() && body->isActive() ? 1 : 0;
        }
        return count;
    }
    /// Kinetic and potential energy of all bodies above y = 0 [J].
    double energy_j() const {
        double sum = 0;
        for (const auto& body : scene_.bodies) {
            if (body->isStaticOrKinematicObject()) continue;
            const double mass_kg = 1 / static_cast<double>(body->getInvMass());
            const btVector3 spin =
                body->getAngularVelocity() * body->getWorldTransform().getBasis();
            sum += 0.5 * mass_kg * static_cast<double>(body->getLinearVelocity().length2()) +
                   0.5 * static_cast<double>(spin.dot(body->getLocalInertia() * spin)) +
                   mass_kg * kGravity_m_s2 * height_m(*body);
        }
        return sum;
    }
    /// What lifts all bodies by a millimetre [J]: so far Bullet's solver corrects what overlaps.
    double millimetre_j() const { return kGravity_m_s2 * mass_kg() * 1e-3; }
    double mass_kg() const {
        double sum = 0;
        for (const auto& body : scene_.bodies) {
            if (!body->isStaticOrKinematicObject()) {
                sum += 1 / static_cast<double>(body->getInvMass());
            }
        }
        return sum;
    }
    /// Common centre of mass of all bodies.
    btVector3 center_m() const {
        btVector3 sum(0, 0, 0);
        for (const auto& body : scene_.bodies) {
            if (body->isStaticOrKinematicObject()) continue;
            sum += body->getWorldTransform().getOrigin() / body->getInvMass();
        }
        return sum / static_cast<btScalar>(mass_kg());
    }
    /// Columns of 8 voxels that the kernels have looked at so far.
    int64_t column_count() const {
        int64_t sum = 0;
        if (!soil_) return sum;
        for (const PassWork& pass : soil_->soil().work_counts().passes) sum += pass.column_count;
        return sum;
    }
    /// A frame's work is no more than so many elements, and looks at each column of the grid. A
    /// grid that is awake as a whole is looked at by each of some twenty kernels.
    void expect_work_below(const Course& course, size_t contacts, double looks) const {
        const GridFrame& frame = soil_->soil().frame();
        const double columns = 1.0 * frame.size[0] * frame.size[1] * ((frame.size[2] + 7) / 8);
        EXPECT_LT(course.contacts_most, contacts);
        EXPECT_LT(static_cast<double>(course.columns_most), looks * columns);
    }
    /// As expect_work_below(), and the bound is no more than twice what came.
    void expect_work(const Course& course, size_t contacts, double looks) const {
        EXPECT_GT(course.contacts_most, contacts / 2) << "else it says nothing";
        expect_work_below(course, contacts, looks);
    }
    /// Of all bodies and of the soil they carry [N].
    double weight_n() const {
        double sum_kg = mass_kg();
        for (const auto& body : scene_.bodies) {
            if (soil_) sum_kg += soil_->body_report(*body).load_kg;
        }
        return kGravity_m_s2 * sum_kg;
    }
    /// Upward momentum of all bodies [N s].
    double momentum_n_s() const {
        double sum = 0;
        for (const auto& body : scene_.bodies) {
            if (!body->isStaticOrKinematicObject()) {
                sum += static_cast<double>(body->getLinearVelocity().y() / body->getInvMass());
            }
        }
        return sum;
    }
    /// What the bodies' own linear damping takes [N]: Bullet's is a share of the speed left after a
    /// second.
    double damping_n() const {
        double sum = 0;
        for (const auto& body : scene_.bodies) {
            if (!body->isStaticOrKinematicObject()) {
                sum -= std::log1p(-static_cast<double>(body->getLinearDamping())) *
                       static_cast<double>(body->getLinearVelocity().y() / body->getInvMass());
            }
        }
        return sum;
    }
    /// Upward force of the soil on all bodies [N].
    double soil_force_n() const {
        double sum = 0;
        for (const auto& body : scene_.bodies) sum += soil_->body_report(*body).force_n.y;
        return sum;
    }
    double top_speed_m_s() const {
        double most = 0;
        for (const auto& body : scene_.bodies) {
            most = std::max(most, static_cast<double>(body->getLinearVelocity().length()));
        }
        return most;
    }
    static double height_m(const btRigidBody& body) {
        return static_cast<double>(body.getWorldTransform().getOrigin().y());
    }
    /// How far a joint's two ends are apart [m].
    static double gap_m(const btHingeConstraint& hinge) {
        const btVector3 a =
            hinge.getRigidBodyA().getWorldTransform() * hinge.getAFrame().getOrigin();
        const btVector3 b =
            hinge.getRigidBodyB().getWorldTransform() * hinge.getBFrame().getOrigin();
        return static_cast<double>((a - b).length());
    }
    const std::vector<std::unique_ptr<btRigidBody>>& bodies() const { return scene_.bodies; }
    const SoilAction& soil() const { return *soil_; }
    bool has_soil() const { return soil_ != nullptr; }

  protected:
    /// Of what drives a body and is no joint, at most, in the last frame [J].
    virtual double drive_work_j() const { return 0; }
    /// In springs that are no joints', and in wheels that are no bodies [J].
    virtual double stored_j() const { return 0; }

    template <typename Fill>
    void fill(const Fill& what) {
        const Status filled = soil_->fill(what);
        EXPECT_TRUE(filled) << filled.error();
        units_ = soil_->soil().totals().units;
    }
    btRigidBody& add(double mass_kg, btCollisionShape& shape, const btTransform& pose) {
        btRigidBody& body = scene_.add(static_cast<btScalar>(mass_kg), shape, pose.getOrigin());
        body.setWorldTransform(pose);
        body.setInterpolationWorldTransform(pose);
        return body;
    }
    template <typename Joint>
    Joint& join(std::unique_ptr<Joint> joint, bool without_collision = true) {
        Joint& out = *joint;
        feedback_.push_back(std::make_unique<btJointFeedback>());
        joint->setJointFeedback(feedback_.back().get());
        scene_.world->addConstraint(joint.get(), without_collision);
        joints_.push_back(std::move(joint));
        return out;
    }

    BulletScene scene_;
    std::vector<std::unique_ptr<btJointFeedback>> feedback_;  ///< of each joint
    std::vector<std::unique_ptr<btTypedConstraint>> joints_;
    std::unique_ptr<SoilAction> soil_;
    std::vector<int64_t> units_;
    int frame_ = 0;

  private:
    /// Of all joints with their springs and motors in the last frame [J]: force times the distance
    /// that it acted over. A vehicle's velocity would not do: its wheels push after it has moved.
    double joint_work_j() const {
        btScalar sum = 0;
        const auto add = [&sum](const btRigidBody& body, const btTransform& before,
                                const btVector3& force, const btVector3& torque) {
            btVector3 linear, angular;
            btTransformUtil::calculateVelocity(before, body.getWorldTransform(), 1, linear,
                                               angular);
            sum += force.dot(linear) + torque.dot(angular);
        };
        for (size_t i = 0; i < joints_.size(); ++i) {
            const btRigidBody &a = joints_[i]->getRigidBodyA(), &b = joints_[i]->getRigidBodyB();
            if (!a.isActive() && !b.isActive()) continue;  // what it says is of an earlier frame
            const btJointFeedback& f = *feedback_[i];
            add(a, before_[i].first, f.m_appliedForceBodyA, f.m_appliedTorqueBodyA);
            add(b, before_[i].second, f.m_appliedForceBodyB, f.m_appliedTorqueBodyB);
        }
        return static_cast<double>(sum);
    }
    /// What Bullet's steps keep where only gravity and what is paid for act. They set a velocity
    /// and go on with it, which leaves m g dt v / 2 too much on the way up.
    double kept_j() const {
        return energy_j() + stored_j() - kGravity_m_s2 * momentum_n_s() / (2 * kFramesPerS) -
               paid_j_;
    }
    /// Of each joint's bodies, before the frame.
    std::vector<std::pair<btTransform, btTransform>> before_;
    double paid_j_ = 0, least_j_ = std::numeric_limits<double>::infinity(), risen_j_ = 0;
};

}  // namespace bsoil::bullet
