/// A scene that runs in a thread of its own and hands pictures of itself to the window. Neither
/// waits for the other: the window draws the newest picture, the simulation makes the next one when
/// the last was taken.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "field_overlay.h"
#include "hand.h"
#include "run/scene_run.h"
#include "run/soil_volume.h"
#include "surface_patches.h"
#include "world_picture.h"

namespace bsoil::viewer {

/// What a brush does with the soil under it.
enum class Brush { dig, heap };

class Simulation {
  public:
    /// The scene must outlive it. Begins with a snapshot of it, where one is named, with the soil
    /// as it was changed there. The error says what could not be made or loaded. Paused at first.
    static Result<std::unique_ptr<Simulation>> create(const scene::Scene& scene,
                                                      const scene::RunDef& def,
                                                      const std::string& snapshot = {});
    ~Simulation();
    Simulation(const Simulation&) = delete;
    Simulation& operator=(const Simulation&) = delete;

    /// Takes the newest picture, if there is one since the last call. Never waits for a step.
    bool take(WorldPicture& picture);

    // From here on: orders, carried out between two steps in the order they were given.
    void set_paused(bool paused);
    /// So many steps, then a pause.
    void make_steps(int count);
    /// Simulated seconds per second of the wall clock, where the machine is fast enough.
    void set_pace(double pace);
    void reset();
    void save(const std::string& path);
    void load(const std::string& path);
    /// By number of the joint; none: the scene's own motions.
    void set_lever(int joint, std::optional<double> velocity);
    /// Of all raycast vehicles; none: their scene's own keys.
    void set_drive(std::optional<scene::DriveCommand> drive);
    void set_overlay(const OverlayDef& overlay);
    /// The level of detail of surfaces follows what is shown, when the camera has moved enough to
    /// matter. Surfaces with a field on them are at full detail.
    void follow(const render::View& shown);
    /// Bits of btIDebugDraw::DebugDrawModes; 0: no lines.
    void set_debug_mode(int mode);
    /// Friction and adhesion between the soil and all bodies; negative: as the scene has them.
    void set_tool_surface(const SurfaceFriction& surface);
    /// The soil's definition as the scene has it, its materials in `materials`. Only with a soil.
    const SoilDef& scene_soil() const { return scene_soil_; }
    /// The same as it is at first: of a snapshot.
    const SoilDef& first_soil() const { return first_soil_; }
    /// Where each body is at the scene's start, whatever was loaded.
    const std::vector<Pose>& start_poses() const { return start_poses_; }
    /// See Soil::change(). Stays through a reset and after a load. Of several that come faster than
    /// steps the last one counts.
    void change_soil(const SoilDef& def);
    void take_by_hand(Vec3 from_m, Vec3 to_m);
    /// The body in the hand goes to this line of sight, as far from the eye as it was taken.
    void drag_hand(Vec3 from_m, Vec3 direction);
    void let_go();
    void use_brush(Brush brush, double radius_m, Vec3 from_m, Vec3 to_m);
    /// Waits until all orders so far and the steps they asked for are done: for scripts. Does not
    /// wait for the end of a simulation that runs.
    void finish_orders();

  private:
    Simulation(const scene::Scene& scene, const scene::RunDef& def);
    using Order = std::function<void()>;
    void post(Order order);
    Status start();
    void work();
    void carry_out_orders();
    void step();
    bool has_stopped_for_good();
    void publish();
    void publish_volume(WorldPicture& picture);
    void fill_status(RunStatus& status) const;
    void note(const std::string& text);
    void apply_levers();
    void apply_tool_surface();
    void apply_soil(const SoilDef& def);
    Status load_state(const std::string& path);
    void list_units(StateStream& stream);
    std::optional<Vec3> soil_along(Vec3 from_m, Vec3 to_m) const;

    const scene::Scene& scene_;
    scene::RunDef def_;

    // Of the simulation's thread.
    std::unique_ptr<scene::SceneRun> run_;
    std::unique_ptr<SoilTiles> tiles_;
    std::unique_ptr<SurfacePatches> soil_patches_, terrain_patches_;
    std::unique_ptr<Hand> hand_;
    double hand_distance_m_ = 1;  ///< from the eye
    std::vector<std::optional<double>> levers_;
    std::optional<scene::DriveCommand> drive_;
    SurfaceDetail detail_;
    OverlayDef overlay_;
    bool overlay_changed_ = false, had_slice_ = false;
    bool was_at_rest_ = true;                    ///< all soil, in the last picture
    std::unique_ptr<scene::SoilVolume> volume_;  ///< while it is shown
    SurfaceFriction tool_surface_;
    SoilDef soil_def_;  ///< what the soil is to be
    int debug_mode_ = 0;
    double pace_ = 1;
    std::vector<int64_t> units_in_, units_out_;  ///< by brushes
    std::vector<std::string> notes_;
    uint64_t world_ = 0;
    double step_ms_ = 0, soil_ms_ = 0, mesh_ms_ = 0, steps_per_s_ = 0;
    double due_s_ = 0;  ///< of the wall clock: when the next step is to begin
    int steps_asked_ = 0;
    bool is_failure_known_ = false;

    SurfaceDetail asked_detail_;  ///< of the window's thread

    // These never change.
    SoilDef scene_soil_, first_soil_;
    std::vector<Pose> start_poses_;

    // Shared.
    mutable std::mutex mutex_;
    std::optional<SoilDef> asked_soil_;  ///< an order to change it is under way
    std::condition_variable wake_, idle_;
    std::deque<Order> orders_;
    bool is_paused_ = true, is_stopping_ = false, is_busy_ = false;
    bool changed_ = true;  ///< since the last picture
    WorldPicture ready_;
    bool is_ready_ = false;

    std::thread thread_;
};

}  // namespace bsoil::viewer
