/// What all rigs stand on: a Bullet world, a level bed of soil in it, and joints that are read as
/// load cells.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "bsoil/bullet/soil_action.h"
#include "experiment.h"
#include "rig.h"
#include "world/bullet_scene.h"

namespace bsoil::experiment {

/// What a joint did to its child, mean over the Bullet substeps of one step of the soil. World
/// axes.
struct JointReading {
    Vec3 force_n;
    Vec3 torque_n_m;  ///< about the child's centre of mass
};

/// A rig's world. Up is z, travel is along x, the bed's surface is level.
class RigWorld {
  public:
    /// `scene` is the setup's with the rig's bodies and joints. Bodies in `unseen` (carriages) take
    /// no part in the soil.
    static Result<std::unique_ptr<RigWorld>> create(const RigSetup& setup, scene::Scene scene,
                                                    const std::vector<std::string>& unseen);
    ~RigWorld();

    /// One step of the soil and the Bullet substeps that belong to it.
    void step();
    double step_s() const { return step_s_; }
    /// Time since the start.
    double time_s() const { return static_cast<double>(step_count_) * step_s_; }

    btRigidBody& body(const std::string& name) const;
    /// World position of a body's frame.
    Vec3 position(const std::string& body) const;
    const scene::SceneJoint& joint(const std::string& name) const;
    JointReading reading(const std::string& joint) const;
    /// A constant force at a body's centre of mass from now on.
    void set_force(const std::string& body, Vec3 force_n);

    /// Notes sticky conditions of the soil, and sliders that have come to their lower stop: what
    /// they carry no longer stands on soil. An error where the soil refuses a body of the rig, or
    /// is lost.
    Status note_conditions(RigOutput& out) const;

  private:
    struct LoadCell {
        std::string joint;
        btJointFeedback feedback;
        JointReading sum;
    };
    struct AppliedForce {
        btRigidBody* body;
        btVector3 force_n;
    };

    explicit RigWorld(scene::Scene scene);
    Status start(const RigSetup& setup, const std::vector<std::string>& unseen);

    scene::Scene scene_;
    std::unique_ptr<scene::BulletScene> bullet_;
    std::unique_ptr<bullet::SoilAction> action_;  // goes before the world it lives in
    double step_s_;
    int substep_count_;
    long long step_count_ = 0;
    std::deque<LoadCell> cells_;  // Bullet keeps their addresses
    std::vector<AppliedForce> forces_;
};

/// Height of the free surface over a place, before a tool has touched it: of the bed, or of the
/// plane at 0 where there is no soil.
double surface_z_m(const RigSetup& setup);
/// Centre of the bed.
Vec3 bed_center_m(const RigSetup& setup);

/// A body that moves along a given way whatever resists: it takes no part in the soil and touches
/// nothing. A carriage that stands still is the rig's frame.
scene::BodyItem carriage(const std::string& name, Vec3 position_m);
/// Its way: linear from key to key.
struct WayPoint {
    double t_s;
    Vec3 position_m;
};
scene::MotionItem way_of(const std::string& carriage, const std::vector<WayPoint>& way);

/// Mean and standard deviation of what is added.
class Statistics {
  public:
    void add(double value);
    double mean() const;
    double deviation() const;

  private:
    long long count_ = 0;
    double mean_ = 0, square_sum_ = 0;
};

/// Rows at given values of the first quantity, in between by linear interpolation of the steps;
/// each is recorded once, on the first way past it.
class StationRecorder {
  public:
    /// Stations rise.
    explicit StationRecorder(std::vector<double> stations);
    /// `row[0]` is the quantity that stations are values of.
    void observe(const std::vector<double>& row);
    const std::vector<std::vector<double>>& rows() const { return rows_; }

  private:
    std::vector<double> stations_;
    std::vector<double> last_;
    std::vector<std::vector<double>> rows_;
};

Result<RigOutput> run_plate(const RigSetup& setup, const PlateItem& plate,
                            const RigProgress& progress);
Result<RigOutput> run_blade(const RigSetup& setup, const BladeItem& blade,
                            const RigProgress& progress);
Result<RigOutput> run_traction(const RigSetup& setup, const TractionItem& wheel,
                               const RigProgress& progress);
Result<RigOutput> run_shear(const RigSetup& setup, const ShearItem& shear,
                            const RigProgress& progress);
Result<RigOutput> run_column(const RigSetup& setup, const ColumnItem& column,
                             const RigProgress& progress);

}  // namespace bsoil::experiment
