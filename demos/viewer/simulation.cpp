#include "simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "clock.h"
#include "debug_lines.h"

namespace bsoil::viewer {
namespace {

constexpr double kFollowShare = 0.05;  ///< of its distance a camera moves before surfaces follow
constexpr size_t kNotesMost = 40;
constexpr char kUnitsSection[] = "host.brush";  ///< in snapshots: what brushes put in, took out
constexpr double kSpeedSmoothing = 0.1;         ///< share of the newest step in the mean speed
constexpr double kBehindMostS = 0.25;           ///< time that a slow machine does not make up for

ConvexShape sphere(double radius_m) {
    ConvexShape shape;
    shape.kind = ConvexShape::Kind::sphere;
    shape.radius_m = radius_m;
    return shape;
}

}  // namespace

Simulation::Simulation(const scene::Scene& scene, const scene::RunDef& def)
    : scene_(scene), def_(def) {
    def_.step_count = 0;
}

Result<std::unique_ptr<Simulation>> Simulation::create(const scene::Scene& scene,
                                                       const scene::RunDef& def,
                                                       const std::string& snapshot) {
    std::unique_ptr<Simulation> simulation(new Simulation(scene, def));
    if (const Status started = simulation->start(); !started) return Error{started.error()};
    simulation->scene_soil_ = simulation->soil_def_;
    simulation->start_poses_ = simulation->run_->start_poses();
    if (!snapshot.empty()) {
        scene::SceneRun& run = *simulation->run_;
        if (const Status loaded = simulation->load_state(snapshot); !loaded) {
            return Error{loaded.error()};
        }
        if (run.has_soil()) {
            simulation->soil_def_ = run.soil().def();
            simulation->soil_def_.materials = run.soil().materials();
        }
        simulation->note("loaded " + snapshot);
    }
    simulation->first_soil_ = simulation->soil_def_;
    Simulation* own = simulation.get();
    simulation->thread_ = std::thread([own] { own->work(); });
    return simulation;
}

Simulation::~Simulation() {
    {
        const std::lock_guard lock(mutex_);
        is_stopping_ = true;
    }
    wake_.notify_one();
    if (thread_.joinable()) thread_.join();
    hand_.reset();
}

/// Builds the world; the one there was is kept where this fails.
Status Simulation::start() {
    auto made = scene::SceneRun::create(scene_, def_);
    if (!made) return Error{made.error()};
    hand_.reset();
    soil_patches_.reset();
    terrain_patches_.reset();
    tiles_.reset();
    volume_.reset();
    run_ = std::move(*made);
    ++world_;
    if (run_->has_soil()) {
        if (world_ == 1) soil_def_ = run_->scene_soil();
        apply_soil(soil_def_);
        tiles_ = std::make_unique<SoilTiles>(run_->soil());
        soil_patches_ =
            std::make_unique<SurfacePatches>(*tiles_, SurfaceKind::soil, def_.mesh_backend);
        if (!scene_.terrains.empty()) {
            terrain_patches_ =
                std::make_unique<SurfacePatches>(*tiles_, SurfaceKind::terrain, def_.mesh_backend);
        }
        units_in_.assign(run_->soil().materials().size(), 0);
        units_out_ = units_in_;
    }
    hand_ = std::make_unique<Hand>(run_->bullet().world(), scene_.world.substep_s);
    had_slice_ = is_failure_known_ = false;
    notes_ = run_->warnings();
    apply_levers();
    apply_tool_surface();
    return Done{};
}

void Simulation::post(Order order) {
    {
        const std::lock_guard lock(mutex_);
        orders_.push_back(std::move(order));
    }
    wake_.notify_one();
}

void Simulation::work() {
    for (;;) {
        {
            std::unique_lock lock(mutex_);
            const auto has_to_act = [this] {
                return is_stopping_ || !orders_.empty() || steps_asked_ > 0 ||
                       (changed_ && !is_ready_) || !is_paused_;
            };
            if (!has_to_act()) {
                is_busy_ = false;
                idle_.notify_all();
            }
            wake_.wait(lock, has_to_act);
            is_busy_ = true;
            if (is_stopping_) return;
            // Ahead of the clock: sleep until the step is due, or something is asked for.
            const double early_s = due_s_ - now_s();
            if (!is_paused_ && steps_asked_ == 0 && early_s > 0 && orders_.empty()) {
                wake_.wait_for(lock, std::chrono::duration<double>(early_s),
                               [this] { return is_stopping_ || !orders_.empty(); });
            }
            if (is_stopping_) return;
        }
        carry_out_orders();
        idle_.notify_all();
        const bool runs = [this] {
            const std::lock_guard lock(mutex_);
            return steps_asked_ > 0 || (!is_paused_ && now_s() >= due_s_);
        }();
        if (runs) step();
        bool is_wanted;
        {
            const std::lock_guard lock(mutex_);
            is_wanted = changed_ && !is_ready_;
        }
        if (is_wanted) publish();
    }
}

void Simulation::carry_out_orders() {
    for (;;) {
        Order order;
        {
            const std::lock_guard lock(mutex_);
            if (orders_.empty()) return;
            order = std::move(orders_.front());
            orders_.pop_front();
            changed_ = true;
        }
        order();
    }
}

/// A soil whose device has failed gives nothing but what is false: the simulation pauses, and says
/// why once. A reset makes another soil.
bool Simulation::has_stopped_for_good() {
    const std::string failure = run_->failure();
    if (failure.empty()) return false;
    if (!std::exchange(is_failure_known_, true)) note(failure);
    const std::lock_guard lock(mutex_);
    is_paused_ = changed_ = true;
    steps_asked_ = 0;
    return true;
}

void Simulation::step() {
    if (has_stopped_for_good()) return;
    const double start_s = now_s();
    run_->step();
    if (has_stopped_for_good()) return;
    const double end_s = now_s();
    step_ms_ = 1e3 * (end_s - start_s);
    if (run_->has_soil()) {
        const StageTimes& t = run_->action().last_report().stage_ms;
        soil_ms_ = t.voxelize + t.deform + t.advect + t.slip + t.contacts + t.activity;
    }
    if (due_s_ > 0 && due_s_ < end_s - kBehindMostS) due_s_ = end_s - kBehindMostS;
    due_s_ += run_->step_s() / pace_;
    const double speed = 1 / std::max(1e-6, end_s - start_s);
    steps_per_s_ += kSpeedSmoothing * (speed - steps_per_s_);
    const std::lock_guard lock(mutex_);
    if (steps_asked_ > 0 && --steps_asked_ == 0) is_paused_ = true;
    changed_ = true;
}

void Simulation::publish() {
    const double start_s = now_s();
    WorldPicture picture;
    picture.world = world_;
    for (const scene::SceneBody& body : run_->bullet().bodies()) {
        picture.bodies.push_back(body.pose());
    }
    if (run_->has_soil()) {
        const FieldOverlay overlay(run_->soil(), overlay_);
        if (overlay_changed_) soil_patches_->touch_all();
        if (overlay_changed_) volume_.reset();
        const bool colored = overlay_.field != Field::none && overlay_.on_surface;
        const bool is_at_rest = run_->action().last_report().block_active_count == 0;
        if (is_at_rest && !was_at_rest_ && overlay_.field != Field::none) {
            soil_patches_->touch_all();  // what has stopped did so without a change
            volume_.reset();
        }
        was_at_rest_ = is_at_rest;
        if (overlay_.volume) publish_volume(picture);
        // Of the soil itself as a volume grains are left: what is too thin for it.
        if (!overlay_.volume || overlay_.field == Field::none) {
            soil_patches_->collect(picture.patches, colored ? SurfaceDetail{} : detail_,
                                   colored ? [&overlay](Mesh& mesh) { overlay.color(mesh); }
                                           : std::function<void(Mesh&)>(),
                                   run_->step_count());
            soil_patches_->collect_grains(picture);
        }
        if (terrain_patches_) terrain_patches_->collect(picture.patches, detail_, {}, 0);
        const bool has_slice = overlay_.field != Field::none && overlay_.slice;
        if (has_slice || had_slice_) {
            picture.patches.push_back(
                {SurfaceKind::slice, 0, has_slice ? overlay.slice() : Mesh{}});
        }
        had_slice_ = has_slice;
        if (has_slice) picture.slice = overlay.slice_plane();
        overlay_changed_ = false;
        if (overlay_.field != Field::none) picture.status.bar = overlay.bar();
    }
    if (debug_mode_ != 0) {
        DebugLines drawer(picture.lines);
        drawer.setDebugMode(debug_mode_);
        btDiscreteDynamicsWorld& world = run_->bullet().world();
        world.setDebugDrawer(&drawer);
        world.debugDrawWorld();
        world.setDebugDrawer(nullptr);
    }
    mesh_ms_ = 1e3 * (now_s() - start_s);
    fill_status(picture.status);

    const std::lock_guard lock(mutex_);
    picture.status.is_paused = is_paused_;
    ready_ = std::move(picture);
    is_ready_ = true;
    changed_ = false;
}

void Simulation::publish_volume(WorldPicture& picture) {
    if (!volume_) {
        const scene::SoilVolumeDef def{overlay_.field, overlay_.low, overlay_.high, 0};
        volume_ = std::make_unique<scene::SoilVolume>(run_->soil(), def);
    }
    if (volume_->update()) {
        picture.voxels = std::make_shared<render::VolumeData>(volume_->data());
    }
    picture.volume = volume_->placed();
}

bool Simulation::take(WorldPicture& picture) {
    {
        const std::lock_guard lock(mutex_);
        if (!is_ready_) return false;
        std::swap(picture, ready_);
        is_ready_ = false;
    }
    wake_.notify_one();
    return true;
}

void Simulation::note(const std::string& text) {
    notes_.push_back(text);
    if (notes_.size() > kNotesMost) notes_.erase(notes_.begin());
}

void Simulation::set_paused(bool paused) {
    post([this, paused] {
        const std::lock_guard lock(mutex_);
        is_paused_ = paused;
        steps_asked_ = 0;
        due_s_ = now_s();
    });
}

void Simulation::make_steps(int count) {
    post([this, count] {
        const std::lock_guard lock(mutex_);
        steps_asked_ = count;
    });
}

void Simulation::set_pace(double pace) {
    post([this, pace] {
        pace_ = std::clamp(pace, 0.01, 100.0);
        due_s_ = now_s();
    });
}

void Simulation::reset() {
    post([this] {
        if (const Status started = start(); !started) note(started.error());
    });
}

void Simulation::save(const std::string& path) {
    post([this, path] {
        hand_->let_go();
        StateStream units;
        list_units(units);
        const Status saved = run_->save(path, {{kUnitsSection, units.bytes()}});
        note(saved ? "saved " + path : saved.error());
    });
}

void Simulation::load(const std::string& path) {
    post([this, path] {
        hand_->let_go();
        const Status loaded = load_state(path);
        if (loaded && run_->has_soil()) apply_soil(soil_def_);  // what the sliders say stays
        note(loaded ? "loaded " + path : loaded.error());
    });
}

void Simulation::list_units(StateStream& stream) { stream(units_in_, units_out_); }

/// A state comes with the soil that was saved, and with what brushes had done to it.
Status Simulation::load_state(const std::string& path) {
    const Status loaded = run_->load(path);
    if (!loaded || !run_->has_soil()) return loaded;
    const size_t count = run_->soil().materials().size();
    const auto sections = read_snapshot_file(path);
    if (const auto* saved = sections ? find_section(*sections, kUnitsSection) : nullptr) {
        StateStream stream(*saved);
        list_units(stream);
        if (stream.at_end() && units_in_.size() == count && units_out_.size() == count) {
            return loaded;
        }
    }
    units_in_.assign(count, 0);  // of a run without brushes
    units_out_ = units_in_;
    return loaded;
}

void Simulation::change_soil(const SoilDef& def) {
    {
        const std::lock_guard lock(mutex_);
        const bool is_under_way = asked_soil_.has_value();
        asked_soil_ = def;
        if (is_under_way) return;
    }
    post([this] {
        {
            const std::lock_guard lock(mutex_);
            soil_def_ = *std::exchange(asked_soil_, std::nullopt);
        }
        if (run_->has_soil()) apply_soil(soil_def_);
    });
}

void Simulation::apply_soil(const SoilDef& def) {
    if (const Status changed = run_->soil().change(def); !changed) note(changed.error());
}

void Simulation::set_lever(int joint, std::optional<double> velocity) {
    post([this, joint, velocity] {
        if (joint < 0) return;
        levers_.resize(std::max(levers_.size(), static_cast<size_t>(joint) + 1));
        levers_[static_cast<size_t>(joint)] = velocity;
        run_->bullet().set_lever(static_cast<size_t>(joint), velocity);
    });
}

void Simulation::set_drive(std::optional<scene::DriveCommand> drive) {
    post([this, drive] {
        drive_ = drive;
        for (const auto& vehicle : run_->raycast_vehicles()) vehicle->set_drive(drive);
    });
}

void Simulation::apply_levers() {
    for (size_t j = 0; j < levers_.size(); ++j) run_->bullet().set_lever(j, levers_[j]);
    for (const auto& vehicle : run_->raycast_vehicles()) vehicle->set_drive(drive_);
}

void Simulation::set_overlay(const OverlayDef& overlay) {
    post([this, overlay] {
        overlay_changed_ = true;
        overlay_ = overlay;
    });
}

void Simulation::follow(const render::View& shown) {
    const SurfaceDetail detail = render::surface_detail(shown);
    const double sight_m = length(shown.camera.target - shown.camera.eye);
    const bool has_moved = length(detail.eye_m - asked_detail_.eye_m) > kFollowShare * sight_m ||
                           detail.cell_angle_rad != asked_detail_.cell_angle_rad;
    if (!has_moved) return;
    asked_detail_ = detail;
    post([this, detail] { detail_ = detail; });
}

void Simulation::set_debug_mode(int mode) {
    post([this, mode] { debug_mode_ = mode; });
}

void Simulation::set_tool_surface(const SurfaceFriction& surface) {
    post([this, surface] {
        tool_surface_ = surface;
        apply_tool_surface();
    });
}

void Simulation::apply_tool_surface() {
    if (!run_->has_soil()) return;
    for (const scene::SceneBody& body : run_->bullet().bodies()) {
        bullet::BodyOptions options = run_->action().options(*body.object);
        if (options.ignored) continue;
        options.surface.friction = tool_surface_.friction >= 0
                                       ? tool_surface_.friction
                                       : body.item->tool_friction.value_or(-1);
        options.surface.adhesion_pa = tool_surface_.adhesion_pa >= 0
                                          ? tool_surface_.adhesion_pa
                                          : body.item->tool_adhesion_pa.value_or(-1);
        if (const Status set = run_->action().set_options(*body.object, options); !set) {
            note(set.error());
        }
    }
}

void Simulation::take_by_hand(Vec3 from_m, Vec3 to_m) {
    post([this, from_m, to_m] {
        const auto seen = look_along(run_->bullet().world(), from_m, to_m);
        if (!seen) return;
        const std::optional<Vec3> soil = soil_along(from_m, to_m);
        if (soil && length(*soil - from_m) < length(seen->point_m - from_m)) return;
        hand_distance_m_ = length(seen->point_m - from_m);
        if (!hand_->take(*seen)) note("this body is fixed: the hand cannot take it");
    });
}

void Simulation::drag_hand(Vec3 from_m, Vec3 direction) {
    post([this, from_m, direction] { hand_->move_to(from_m + direction * hand_distance_m_); });
}

void Simulation::let_go() {
    post([this] { hand_->let_go(); });
}

/// Where a line of sight first meets the soil's surface from above.
std::optional<Vec3> Simulation::soil_along(Vec3 from_m, Vec3 to_m) const {
    if (!run_->has_soil()) return {};
    const double step_m = 0.5 * run_->soil().frame().voxel_m;
    const Vec3 way = to_m - from_m;
    const double length_m = length(way);
    const Vec3 up = scene_.world.up == "y" ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    for (double s = 0; s < length_m; s += step_m) {
        const Vec3 at = from_m + way * (s / length_m);
        const auto surface = run_->action().surface_at(at);
        if (surface && dot(at - surface->position_m, up) <= 0) return at;
    }
    return {};
}

void Simulation::use_brush(Brush brush, double radius_m, Vec3 from_m, Vec3 to_m) {
    post([this, brush, radius_m, from_m, to_m] {
        const std::optional<Vec3> at = soil_along(from_m, to_m);
        if (!at) return;
        Soil& soil = run_->soil();
        if (brush == Brush::dig) {
            const auto taken = soil.take_out(sphere(radius_m), {*at, {}});
            if (!taken) return note(taken.error());
            for (size_t m = 0; m < units_out_.size(); ++m) units_out_[m] += (*taken)[m];
            return;
        }
        const SoilTotals before = soil.totals();
        CylinderFill heap;
        heap.base_center_m = *at;
        heap.radius_m = radius_m;
        heap.height_m = radius_m;
        if (!soil.fill(heap)) return;  // no room under the brush
        const SoilTotals after = soil.totals();
        for (size_t m = 0; m < units_in_.size(); ++m) {
            units_in_[m] += after.units[m] - before.units[m];
        }
    });
}

void Simulation::finish_orders() {
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] {
        return orders_.empty() && steps_asked_ == 0 && (!is_busy_ || !is_paused_);
    });
}

}  // namespace bsoil::viewer
