/// Running a scene: the Bullet world with the soil in it, step by step, and what is measured on the
/// way.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bsoil/bullet/soil_action.h"
#include "bsoil/snapshot_file.h"
#include "run/raycast_vehicle.h"
#include "scene/scene.h"
#include "world/bullet_scene.h"

namespace bsoil::scene {

/// How a scene is run; the scene itself says the rest.
struct RunDef {
    Backend backend = Backend::automatic;
    int thread_count = 0;      ///< of the CPU backend; 0 = all cores
    long long step_count = 0;  ///< steps of the soil; 0 = as long as the scene says
    /// Where the soil's surface is meshed for pictures; none: where the soil is computed.
    std::optional<Backend> mesh_backend = std::nullopt;
};

/// Readings of a body over one step of the soil.
struct BodyReading {
    Vec3 force_n, torque_n_m;  ///< of the soil, mean over the step's Bullet substeps
    double sinkage_m = 0;
    double peak_force_n = 0;  ///< of any Bullet substep of the step
    double load_kg = 0;       ///< soil it carries
};

/// The height above the grid's floor [m] at a place of the world; only the place along the floor
/// counts.
double surface_height_m(const Soil& soil, Vec3 at_m);

/// One run of a scene, ready to step.
class SceneRun {
  public:
    /// The scene must outlive the run. Fills the soil; the error says what could not be made.
    static Result<std::unique_ptr<SceneRun>> create(const Scene& scene, const RunDef& def);

    /// One step of the soil and the Bullet substeps that belong to it.
    void step();
    /// What has broken the soil's device, empty while all is well; see Soil::device_failure().
    std::string failure() const;
    bool finished() const { return step_count_ >= step_target_; }
    /// Whether the run was as long as the scene asks, and not cut short by RunDef::step_count.
    bool finished_scene() const { return time_s() >= scene_.world.duration_s - step_s_ / 2; }
    long long step_count() const { return step_count_; }
    long long step_target() const { return step_target_; }
    double step_s() const { return step_s_; }
    double time_s() const { return static_cast<double>(step_count_) * step_s_; }

    const Scene& scene() const { return scene_; }
    std::optional<Backend> mesh_backend() const { return mesh_backend_; }
    BulletScene& bullet() { return *bullet_; }
    const BulletScene& bullet() const { return *bullet_; }
    const std::vector<std::unique_ptr<RaycastVehicle>>& raycast_vehicles() const {
        return raycast_vehicles_;
    }
    bool has_soil() const { return action_ != nullptr; }
    Soil& soil() { return action_->soil(); }
    const Soil& soil() const { return action_->soil(); }
    const bullet::SoilAction& action() const { return *action_; }
    bullet::SoilAction& action() { return *action_; }
    /// The soil's definition as the scene has it, its materials in `materials`. Only with a soil.
    const SoilDef& scene_soil() const { return scene_soil_; }
    const SoilTotals& totals_at_start() const { return totals_at_start_; }

    /// Where each body was before the first step, in the order of bullet().bodies(): the same in a
    /// run that goes on from a snapshot.
    const std::vector<Pose>& start_poses() const { return start_poses_; }
    /// Of the last step, in the order of bullet().bodies().
    const std::vector<BodyReading>& readings() const { return readings_; }
    /// A probe of kind mass_inside [kg].
    double probe_mass_kg(const ProbeItem& probe) const;

    /// Snapshot of the whole run: world, soil and how it was changed, what was measured so far, and
    /// `more` sections (names begin with "host"). The error names the file and what is wrong.
    Status save(const std::string& path, std::vector<SnapshotSection> more = {});
    /// Goes on from a snapshot of a run of the same scene, with the soil as it was changed in that
    /// run. The error names what differs and changes nothing.
    Status load(const std::string& path);

    /// What the soil has run into, a sentence each with body, place and time; from number `first`
    /// on.
    std::vector<std::string> condition_texts(size_t first = 0) const;
    /// Sources that hold back more than a hundredth of what was due so far, a sentence each.
    std::vector<std::string> shortfall_texts() const;
    /// What is odd about the scene as it starts: bodies that the soil will not meet, a slow device.
    const std::vector<std::string>& warnings() const { return warnings_; }

    /// The content of summary.json so far; see docs of `bsoil run`.
    nlohmann::ordered_json summary() const;

  private:
    SceneRun(const Scene& scene, const RunDef& def);
    Status start(const RunDef& def);
    Status add_soil(const RunDef& def);
    Status add_raycast_vehicles();
    void substep();
    /// Of bullet().bodies(), the wheels of vehicles too.
    bullet::BodyReport soil_report(size_t body) const;
    void warn_of_bodies_outside();
    /// The scene's name of an object; empty: none of its bodies.
    std::string name_of(const btCollisionObject* object) const;
    std::vector<bullet::SoilAction*> soils();
    /// What save() and load() pass besides world and soil.
    struct Progress;
    Progress progress() const;

    const Scene& scene_;
    std::unique_ptr<BulletScene> bullet_;
    std::unique_ptr<bullet::SoilAction> action_;  // goes before the world it lives in
    std::vector<std::unique_ptr<RaycastVehicle>> raycast_vehicles_;
    /// Wheels of vehicles, by body: the soil meets those of their raycaster.
    struct WheelPlace {
        const RaycastVehicle* vehicle = nullptr;
        int wheel = -1;
    };
    std::vector<WheelPlace> wheel_places_;
    std::optional<Backend> mesh_backend_;
    double step_s_;
    int substep_count_;
    long long step_count_ = 0, step_target_ = 0;
    std::vector<std::string> warnings_;
    std::vector<Pose> start_poses_;
    std::vector<BodyReading> readings_;
    std::vector<double> peak_force_n_;
    SoilDef scene_soil_;
    std::vector<int> source_ids_;  ///< by source of the scene
    SoilTotals totals_at_start_;
    StageTimes stage_sum_ms_;
    double block_active_sum_ = 0;
    double wall_s_ = 0;
    std::vector<double> step_ms_;  ///< of the wall's clock, each step that this process has made
    long long loaded_step_count_ = 0;  ///< steps that another process has made
};

/// The scene that a run's snapshot is of.
struct SnapshotScene {
    std::string up;    ///< "y" or "z": the axis that pointed up
    std::string path;  ///< of its file, absolute, when the snapshot was written
};
/// Error: the file is no snapshot, is damaged, or was not written by a run of a scene.
Result<SnapshotScene> scene_of_snapshot(const std::string& path);

}  // namespace bsoil::scene
