#include "scene_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bsoil/bullet/world_snapshot.h"
#include "reading/scene_load.h"
#include "scene_origin.h"
#include "soil_settings.h"
#include "world/scene_shapes.h"
#include "world/soil_filling.h"

namespace bsoil::scene {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBlockVoxelCount = 512;
constexpr char kProgressSection[] = "host.run";
constexpr char kSoilSection[] = "host.soil";      ///< soil_settings
constexpr char kOriginSection[] = "host.origin";  ///< scene_origin
constexpr char kSceneSection[] = "host.scene";    ///< "<up axis> <path of the scene file>"

nlohmann::ordered_json per_material(const Soil& soil, const std::vector<int64_t>& units) {
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    for (size_t i = 0; i < units.size(); ++i) json[soil.materials()[i].name] = units[i];
    return json;
}

nlohmann::ordered_json as_json(Vec3 v) { return {v.x, v.y, v.z}; }
nlohmann::ordered_json as_json(Quat q) { return {q.x, q.y, q.z, q.w}; }

}  // namespace

double surface_height_m(const Soil& soil, Vec3 at_m) {
    const GridFrame& frame = soil.frame();
    const Vec3 grid = frame.to_grid(at_m);
    const int x = std::clamp(static_cast<int>(std::floor(grid.x)), 0, frame.size[0] - 1);
    const int y = std::clamp(static_cast<int>(std::floor(grid.y)), 0, frame.size[1] - 1);
    return soil.surface_height_m(x, y);
}

SceneRun::SceneRun(const Scene& scene, const RunDef& def)
    : scene_(scene),
      mesh_backend_(def.mesh_backend),
      step_s_(frame_length(scene).step_s),
      substep_count_(frame_length(scene).substep_count) {
    step_target_ = std::llround(scene.world.duration_s / step_s_);
    if (def.step_count > 0) step_target_ = std::min(step_target_, def.step_count);
}

Result<std::unique_ptr<SceneRun>> SceneRun::create(const Scene& scene, const RunDef& def) {
    std::unique_ptr<SceneRun> run(new SceneRun(scene, def));
    const Status started = run->start(def);
    if (!started) return Error{started.error()};
    return run;
}

Status SceneRun::start(const RunDef& def) {
    auto made = BulletScene::create(scene_);
    if (!made) return Error{made.error()};
    bullet_ = std::move(*made);
    readings_.resize(bullet_->bodies().size());
    peak_force_n_.resize(bullet_->bodies().size());
    wheel_places_.resize(bullet_->bodies().size());
    if (scene_.soil) {
        if (Status added = add_soil(def); !added) return added;
    }
    if (Status added = add_raycast_vehicles(); !added) return added;
    for (const SceneBody& body : bullet_->bodies()) start_poses_.push_back(body.pose());
    return Done{};
}

Status SceneRun::add_soil(const RunDef& def) {
    SoilDef soil = soil_def(scene_);
    soil.backend = def.backend;
    soil.thread_count = def.thread_count;
    bullet::SoilActionDef options;
    options.ground = false;  // bodies of ignore_soil pass through
    options.ignored = bullet_->apart_from_soil();
    auto action = bullet::SoilAction::create(bullet_->world(), soil, options);
    if (!action) return Error{scene_.message(scene_.soil->at, action.error())};
    action_ = std::move(*action);
    const Status surfaces = set_surfaces(scene_, *bullet_, *action_);
    if (!surfaces) return surfaces;
    auto filled = fill_soil(scene_, action_->soil());
    if (!filled) return Error{filled.error()};
    source_ids_ = std::move(*filled);
    totals_at_start_ = action_->soil().totals();
    scene_soil_ = action_->soil().def();
    scene_soil_.materials = action_->soil().materials();
    warn_of_bodies_outside();
    return Done{};
}

Status SceneRun::add_raycast_vehicles() {
    for (const RaycastVehicleItem& item : scene_.raycast_vehicles) {
        auto made = RaycastVehicle::create(item, *bullet_, action_.get());
        if (!made) return Error{scene_.message(item.at, made.error())};
        (*made)->place_wheels();
        for (size_t b = 0; b < wheel_places_.size(); ++b) {
            if (const auto wheel = (*made)->wheel_of(bullet_->bodies()[b].object)) {
                wheel_places_[b] = {made->get(), *wheel};
            }
        }
        raycast_vehicles_.push_back(std::move(*made));
    }
    return Done{};
}

bullet::BodyReport SceneRun::soil_report(size_t body) const {
    const WheelPlace& place = wheel_places_[body];
    return place.vehicle ? place.vehicle->wheel_report(place.wheel)
                         : action_->body_report(*bullet_->bodies()[body].object);
}

void SceneRun::substep() {
    for (const auto& vehicle : raycast_vehicles_) {
        vehicle->begin_substep(bullet_->time_s(), scene_.world.substep_s);
    }
    bullet_->substep();
    for (const auto& vehicle : raycast_vehicles_) vehicle->place_wheels();
}

void SceneRun::warn_of_bodies_outside() {
    const std::vector<const btCollisionObject*> apart = bullet_->apart_from_soil();
    const GridFrame& frame = soil().frame();
    for (const SceneBody& body : bullet_->bodies()) {
        const bool moves = body.item->mass_kg > 0 || body.item->kinematic;
        if (!moves || std::find(apart.begin(), apart.end(), body.object) != apart.end()) continue;
        const Vec3 at = frame.to_grid(from_bullet(body.object->getWorldTransform().getOrigin()));
        if (at.x >= 0 && at.x <= frame.size[0] && at.y >= 0 && at.y <= frame.size[1] && at.z >= 0) {
            continue;
        }
        warnings_.push_back(scene_.message(
            body.item->at,
            fmt::format("body `{}` starts outside the soil's box, where it meets no soil; move it, "
                        "or enlarge `size_m` of [soil]",
                        body.name)));
    }
}

std::string SceneRun::name_of(const btCollisionObject* object) const {
    for (const SceneBody& body : bullet_->bodies()) {
        if (object && body.object == object) return body.name;
    }
    return {};
}

std::vector<std::string> SceneRun::condition_texts(size_t first) const {
    std::vector<std::string> texts;
    if (!action_) return texts;
    const std::vector<bullet::ObjectCondition> all = action_->conditions();
    for (size_t i = first; i < all.size(); ++i) {
        const std::string name = name_of(all[i].object);
        texts.push_back(condition_text(all[i].condition, name.empty() ? "" : "body " + name));
    }
    return texts;
}

std::vector<std::string> SceneRun::shortfall_texts() const {
    constexpr double kShareLeast = 0.01;
    std::vector<std::string> texts;
    for (size_t i = 0; i < source_ids_.size(); ++i) {
        const auto state = soil().flow_state(source_ids_[i]);
        if (!state) continue;  // somebody has taken it away
        const double due_kg = state->mass_kg + state->missed_kg;
        if (!(state->missed_kg > kShareLeast * due_kg)) continue;
        texts.push_back(scene_.message(
            scene_.sources[i].at,
            fmt::format("source_short: a [[source]] has poured {:.4g} kg of {:.4g}, and held back "
                        "the rest for good, for want of room; enlarge it, raise its `speed_m_s`, "
                        "or move it away from soil",
                        state->mass_kg, due_kg)));
    }
    return texts;
}

std::string SceneRun::failure() const {
    if (!has_soil() || soil().device_failure().empty()) return {};
    return fmt::format("{} in step {}; --backend cpu needs no GPU", soil().device_failure(),
                       step_count_);
}

void SceneRun::step() {
    const auto start = std::chrono::steady_clock::now();
    std::fill(readings_.begin(), readings_.end(), BodyReading{});
    for (int i = 0; i < substep_count_; ++i) {
        substep();
        if (!action_) continue;
        for (size_t b = 0; b < readings_.size(); ++b) {
            const bullet::BodyReport report = soil_report(b);
            BodyReading& reading = readings_[b];
            reading.force_n += report.force_n * (1.0 / substep_count_);
            reading.torque_n_m += report.torque_n_m * (1.0 / substep_count_);
            reading.sinkage_m = report.sinkage_m;
            reading.load_kg = report.load_kg;
            reading.peak_force_n = std::max(reading.peak_force_n, length(report.force_n));
            peak_force_n_[b] = std::max(peak_force_n_[b], report.peak_force_n);
        }
    }
    ++step_count_;
    if (action_) {
        const StepReport& report = action_->last_report();
        const StageTimes& t = report.stage_ms;
        StageTimes& sum = stage_sum_ms_;
        sum = {sum.voxelize + t.voxelize, sum.deform + t.deform,     sum.advect + t.advect,
               sum.slip + t.slip,         sum.contacts + t.contacts, sum.activity + t.activity};
        block_active_sum_ += report.block_active_count;
    }
    const double took_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    wall_s_ += took_s;
    step_ms_.push_back(1000 * took_s);
}

struct SceneRun::Progress {
    double step_s = 0;
    int64_t step_count = 0;
    BulletScene::Progress bullet;
    std::vector<BodyReading> readings;
    std::vector<double> peak_force_n;
    SoilTotals totals_at_start;
    double block_active_sum = 0;

    void serialize(StateStream& stream) {
        stream(step_s, step_count, bullet.substep_count, block_active_sum);
        stream.list(bullet.joint_positions, 8, [&](double& p) { stream(p); });
        stream.list(readings, 64, [&](BodyReading& r) {
            stream(r.force_n, r.torque_n_m, r.sinkage_m, r.peak_force_n);
        });
        stream.list(peak_force_n, 8, [&](double& peak) { stream(peak); });
        stream(totals_at_start.units);
        stream.list(totals_at_start.mass_kg, 8, [&](double& mass) { stream(mass); });
        // Came later: older files end here or behind the water.
        if (!stream.reads() || !stream.at_end()) stream(totals_at_start.water_units);
        if (stream.reads() && stream.at_end()) return;
        for (BodyReading& reading : readings) stream(reading.load_kg);
    }
};

SceneRun::Progress SceneRun::progress() const {
    return {step_s_,       step_count_,      bullet_->progress(), readings_,
            peak_force_n_, totals_at_start_, block_active_sum_};
}

std::vector<bullet::SoilAction*> SceneRun::soils() {
    return action_ ? std::vector<bullet::SoilAction*>{action_.get()}
                   : std::vector<bullet::SoilAction*>{};
}

Status SceneRun::save(const std::string& path, std::vector<SnapshotSection> more) {
    StateStream stream;
    progress().serialize(stream);
    more.push_back({kProgressSection, stream.bytes()});
    if (has_soil()) {
        SoilDef def = soil().def();
        def.materials = soil().materials();
        more.push_back({kSoilSection, soil_settings(def)});
    }
    more.push_back({kOriginSection, scene_origin(scene_, has_soil() ? &scene_soil_ : nullptr)});
    const std::string scene =
        scene_.world.up + " " + std::filesystem::absolute(scene_.path).lexically_normal().string();
    more.push_back({kSceneSection, {scene.begin(), scene.end()}});
    return bullet::save_world(bullet_->world(), soils(), path, more);
}

Result<SnapshotScene> scene_of_snapshot(const std::string& path) {
    const auto sections = read_snapshot_file(path);
    if (!sections) return Error{sections.error()};
    const std::vector<uint8_t>* bytes = find_section(*sections, kSceneSection);
    if (!bytes || bytes->size() < 3 || (*bytes)[1] != ' ') {
        return Error{fmt::format(
            "snapshot '{}' does not say which scene it is of; take one that bsoil run wrote",
            path)};
    }
    return SnapshotScene{{bytes->begin(), bytes->begin() + 1}, {bytes->begin() + 2, bytes->end()}};
}

Status SceneRun::load(const std::string& path) {
    const auto sections = read_snapshot_file(path);
    if (!sections) return Error{sections.error()};
    const auto refuse = [&](const std::string& why) {
        return Error{fmt::format("snapshot '{}': {}", path, why)};
    };
    const std::vector<uint8_t>* bytes = find_section(*sections, kProgressSection);
    if (!bytes) {
        return refuse("was not written by a run of a scene; take one of its step_*.snapshot");
    }
    Progress saved;
    const Progress here = progress();
    StateStream stream(*bytes);
    saved.serialize(stream);
    if (!stream.at_end() || saved.step_count < 0 || saved.bullet.substep_count < 0) {
        return refuse(std::string("is damaged") + kTakeAnotherCopy);
    }
    if (saved.step_s != here.step_s ||
        saved.bullet.substep_count != saved.step_count * substep_count_ ||
        saved.bullet.joint_positions.size() != here.bullet.joint_positions.size() ||
        saved.peak_force_n.size() != here.peak_force_n.size() ||
        saved.readings.size() != here.readings.size() ||
        saved.totals_at_start.units.size() != here.totals_at_start.units.size()) {
        return refuse(
            "is of another scene: its steps, bodies, joints or materials are others; run this "
            "scene "
            "anew");
    }
    if (const auto* origin = find_section(*sections, kOriginSection)) {
        const Status same = check_origin(*origin, scene_, has_soil() ? &scene_soil_ : nullptr);
        if (!same) return refuse(same.error());
    }
    SoilDef changed = scene_soil_;
    const std::vector<uint8_t>* settings = find_section(*sections, kSoilSection);
    if (settings && !set_soil_settings(*settings, changed)) {
        return refuse(std::string("is damaged") + kTakeAnotherCopy);
    }
    const SoilDef before = has_soil() ? soil().def() : SoilDef{};
    if (has_soil()) {
        if (const Status taken = soil().change(changed); !taken) return refuse(taken.error());
    }
    const Status loaded = bullet::load_world(bullet_->world(), soils(), path);
    if (!loaded) {
        if (has_soil()) static_cast<void>(soil().change(before));
        return loaded;
    }
    step_count_ = loaded_step_count_ = saved.step_count;
    bullet_->set_progress(saved.bullet);
    readings_ = saved.readings;
    peak_force_n_ = saved.peak_force_n;
    totals_at_start_ = saved.totals_at_start;
    block_active_sum_ = saved.block_active_sum;
    return Done{};
}

double SceneRun::probe_mass_kg(const ProbeItem& probe) const {
    ConvexShape region;
    region.half_extents_m = probe.region.size_m * 0.5;
    Pose pose = probe.region.pose;
    if (!probe.body.empty()) pose = bullet_->find_body(probe.body)->pose() * pose;
    const auto material = scene_.soil->material_index(probe.material);
    return material ? soil().masses_inside_kg(region, pose)[*material]
                    : soil().mass_inside_kg(region, pose);
}

nlohmann::ordered_json SceneRun::summary() const {
    const double steps = std::max(1.0, static_cast<double>(step_count_));
    // Times are of the steps that this process has made.
    const auto steps_here = static_cast<double>(step_count_ - loaded_step_count_);
    const double timed = std::max(1.0, steps_here);
    Json json;
    json["scene"] = scene_.title;
    json["up"] = scene_.world.up;
    json["backend"] = has_soil() ? soil().backend_name() : "none";
    json["device"] = has_soil() ? soil().device_name() : "none";
    json["threads"] = has_soil() ? soil().thread_count() : 1;
    json["steps"] = step_count_;
    json["simulated_s"] = time_s();
    json["wall_s"] = wall_s_;
    json["steps_per_s"] = wall_s_ > 0 ? steps_here / wall_s_ : 0.0;
    std::vector<double> step_ms = step_ms_;
    std::ranges::sort(step_ms);
    for (const auto& [name, share] :
         {std::pair{"step_ms_median", 0.5}, std::pair{"step_ms_95", 0.95},
          std::pair{"step_ms_most", 1.0}}) {
        const auto last = static_cast<double>(step_ms.size()) - 1;
        json[name] = step_ms.empty() ? 0 : step_ms[static_cast<size_t>(share * last)];
    }
    if (has_soil()) {
        const SoilTotals end = soil().totals();
        json["voxels_total"] = soil().voxels_total();
        json["voxels_active_mean"] = block_active_sum_ / steps * kBlockVoxelCount;
        json["soil_units_start"] = per_material(soil(), totals_at_start_.units);
        json["soil_units_end"] = per_material(soil(), end.units);
        json["soil_units_in"] = per_material(soil(), end.units_in);
        json["soil_units_out"] = per_material(soil(), end.units_out);
        if (end.water_units + end.water_units_in + totals_at_start_.water_units > 0) {
            json["water_units_start"] = totals_at_start_.water_units;
            json["water_units_end"] = end.water_units;
            json["water_units_in"] = end.water_units_in;
            json["water_units_out"] = end.water_units_out;
        }
        Json sources = Json::array();
        for (const int id : source_ids_) {
            const auto state = soil().flow_state(id);
            if (state) sources.push_back({{"kg", state->mass_kg}, {"missed_kg", state->missed_kg}});
        }
        if (!sources.empty()) json["sources"] = sources;
        double mass_kg = 0;
        for (const double material_kg : end.mass_kg) mass_kg += material_kg;
        json["soil_mass_kg"] = mass_kg;
        json["checksum"] = fmt::format("{:016x}", soil().checksum());
        json["status"] = status_texts(soil().status_bits());
        Json conditions = Json::array();
        for (const bullet::ObjectCondition& met : action_->conditions()) {
            const Condition& c = met.condition;
            const std::string name = name_of(met.object);
            conditions.push_back(
                Json{{"name", bsoil::name_of(c.bit)},
                     {"body", name.empty() ? Json(nullptr) : Json(name)},
                     {"position_m", c.position_m ? as_json(*c.position_m) : Json(nullptr)},
                     {"first_step", c.first_step},
                     {"first_time_s", c.first_time_s},
                     {"last_step", c.last_step},
                     {"steps", c.step_count}});
        }
        json["conditions"] = conditions;
        json["stages_ms"] = Json{{"voxelize", stage_sum_ms_.voxelize / timed},
                                 {"deform", stage_sum_ms_.deform / timed},
                                 {"advect", stage_sum_ms_.advect / timed},
                                 {"slip", stage_sum_ms_.slip / timed},
                                 {"contacts", stage_sum_ms_.contacts / timed},
                                 {"activity", stage_sum_ms_.activity / timed}};
        if (soil().def().step_budget_ms > 0) {
            const StepRate rate = soil().step_rate();
            json["step_rate"] = Json{{"budget_ms", soil().def().step_budget_ms},
                                     {"due", rate.due_count},
                                     {"begun", rate.begun_count},
                                     {"share", rate.share()},
                                     {"held", rate.held_count},
                                     {"calls_a_step_most", rate.call_count_most},
                                     {"call_most_ms", rate.call_most_ms}};
        }
        Json refused = Json::array();
        for (const bullet::RefusedBody& body : action_->refused()) refused.push_back(body.reason);
        json["refused"] = refused;
        const MemoryUse memory = soil().memory_use();
        json["memory"] = Json{{"awake_bytes", memory.awake_bytes},
                              {"asleep_bytes", memory.asleep_bytes},
                              {"bytes_per_awake_voxel", memory.bytes_per_awake_voxel},
                              {"bytes_per_asleep_column", memory.bytes_per_asleep_column}};
    }
    Json bodies = Json::object();
    for (size_t b = 0; b < bullet_->bodies().size(); ++b) {
        const SceneBody& body = bullet_->bodies()[b];
        const Pose pose = body.pose();
        bodies[body.name] = Json{{"position_m", as_json(pose.position)},
                                 {"rotation", as_json(pose.rotation)},
                                 {"asleep", !body.is_awake()},
                                 {"soil_force_peak_n", peak_force_n_[b]}};
    }
    json["bodies"] = bodies;
    return json;
}

}  // namespace bsoil::scene
