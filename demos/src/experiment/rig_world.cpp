#include "rig_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "reading/scene_load.h"
#include "world/soil_filling.h"

namespace bsoil::experiment {
namespace {

/// A slider beyond this share of its way hangs on its stop.
constexpr double kAtStop = 0.99;

/// Bullet numbers its bodies with a global counter: one world at a time is built.
std::mutex world_mutex;

/// Bullet adds a margin around hulls and cones, by which a tool would be larger than it is.
void remove_margin(btCollisionShape& shape) {
    if (shape.isCompound()) {
        auto& compound = static_cast<btCompoundShape&>(shape);
        for (int i = 0; i < compound.getNumChildShapes(); ++i) {
            remove_margin(*compound.getChildShape(i));
        }
    }
    const int type = shape.getShapeType();
    if (type == CONVEX_HULL_SHAPE_PROXYTYPE || type == CONE_SHAPE_PROXYTYPE) shape.setMargin(0);
}

}  // namespace

RigWorld::RigWorld(scene::Scene scene)
    : scene_(std::move(scene)),
      step_s_(scene::frame_length(scene_).step_s),
      substep_count_(scene::frame_length(scene_).substep_count) {}

RigWorld::~RigWorld() {
    const std::lock_guard lock(world_mutex);
    action_.reset();
    bullet_.reset();
}

Result<std::unique_ptr<RigWorld>> RigWorld::create(const RigSetup& setup, scene::Scene scene,
                                                   const std::vector<std::string>& unseen) {
    std::unique_ptr<RigWorld> made(new RigWorld(std::move(scene)));
    Status started = [&] {
        const std::lock_guard lock(world_mutex);
        return made->start(setup, unseen);
    }();
    if (!started) return Error{started.error()};
    return made;
}

Status RigWorld::start(const RigSetup& setup, const std::vector<std::string>& unseen) {
    auto bullet = scene::BulletScene::create(scene_);
    if (!bullet) return Error{bullet.error()};
    bullet_ = std::move(*bullet);
    for (const scene::SceneBody& body : bullet_->bodies()) {
        remove_margin(*body.body->getCollisionShape());
        body.body->setActivationState(DISABLE_DEACTIVATION);  // a press at rest still measures
    }
    for (const scene::SceneJoint& joint : bullet_->joints()) {
        cells_.push_back({joint.name, {}, {}});
        joint.constraint->setJointFeedback(&cells_.back().feedback);
    }
    if (!scene_.soil) return Done{};

    SoilDef def = scene::soil_def(scene_);
    def.backend = Backend::cpu;
    def.thread_count = 1;  // a sweep keeps the cores busy with its points
    bullet::SoilActionDef options;
    options.ground = false;  // the carriage passes through
    for (const std::string& name : unseen) {
        options.ignored.push_back(bullet_->find_body(name)->body);
    }
    auto action = bullet::SoilAction::create(bullet_->world(), def, options);
    if (!action) return Error{scene_.message(scene_.soil->at, action.error())};
    action_ = std::move(*action);
    const Status surfaces = scene::set_surfaces(scene_, *bullet_, *action_);
    if (!surfaces) return surfaces;
    const Vec3 center = bed_center_m(setup);
    const double reach = length(def.size_m);  // beyond the grid's corners, however it is turned
    const BoxFill bed{{{center.x - reach, center.y - reach, center.z - setup.bed.depth_m},
                       {center.x + reach, center.y + reach, center.z}},
                      action_->soil().materials().front().name};
    const Status filled = action_->fill(bed);
    if (!filled) return Error{scene_.message(setup.bed.at, filled.error())};
    return Done{};
}

void RigWorld::step() {
    for (LoadCell& cell : cells_) cell.sum = {};
    const double share = 1.0 / substep_count_;
    for (int i = 0; i < substep_count_; ++i) {
        for (const AppliedForce& force : forces_) force.body->applyCentralForce(force.force_n);
        bullet_->substep();
        for (LoadCell& cell : cells_) {
            cell.sum.force_n += scene::from_bullet(cell.feedback.m_appliedForceBodyB) * share;
            cell.sum.torque_n_m += scene::from_bullet(cell.feedback.m_appliedTorqueBodyB) * share;
        }
    }
    ++step_count_;
}

btRigidBody& RigWorld::body(const std::string& name) const {
    return *bullet_->find_body(name)->body;
}

Vec3 RigWorld::position(const std::string& body) const {
    return bullet_->find_body(body)->pose().position;
}

const scene::SceneJoint& RigWorld::joint(const std::string& name) const {
    return *std::find_if(bullet_->joints().begin(), bullet_->joints().end(),
                         [&](const scene::SceneJoint& j) { return j.name == name; });
}

JointReading RigWorld::reading(const std::string& joint) const {
    return std::find_if(cells_.begin(), cells_.end(),
                        [&](const LoadCell& c) { return c.joint == joint; })
        ->sum;
}

void RigWorld::set_force(const std::string& name, Vec3 force_n) {
    btRigidBody* target = &body(name);
    std::erase_if(forces_, [&](const AppliedForce& f) { return f.body == target; });
    forces_.push_back({target, scene::to_bullet(force_n)});
}

Status RigWorld::note_conditions(RigOutput& out) const {
    if (!action_) return Done{};  // a tool without soil hangs on its stop, as it has to
    const std::string failure = action_->soil().device_failure();
    if (!failure.empty()) return Error{failure};
    if (!action_->refused().empty()) return Error{action_->refused().front().reason};
    out.status = status_texts(action_->soil().status_bits());
    for (const scene::SceneJoint& joint : bullet_->joints()) {
        if (joint.item->lower_m && joint.position < *joint.item->lower_m * kAtStop) {
            out.faults.push_back(joint.name + "_at_stop: it sank as deep as the rig goes");
        }
    }
    return Done{};
}

double surface_z_m(const RigSetup& setup) {
    return setup.scene.soil ? bed_center_m(setup).z : setup.scene.world.ground_height_m;
}

Vec3 bed_center_m(const RigSetup& setup) {
    if (!setup.scene.soil) return {};
    const Vec3 floor = setup.scene.soil->def.floor_center_m;
    return {floor.x, floor.y, floor.z + setup.bed.depth_m};
}

scene::BodyItem carriage(const std::string& name, Vec3 position_m) {
    scene::BodyItem body;
    body.name = name;
    body.shape.shape = "sphere";
    body.shape.radius_m = 0.001;
    body.kinematic = true;
    body.pose.position = position_m;
    body.group = "rig";
    return body;
}

scene::MotionItem way_of(const std::string& carriage, const std::vector<WayPoint>& way) {
    scene::MotionItem motion;
    motion.body = carriage;
    motion.interpolation = "linear";
    for (const WayPoint& point : way) {
        scene::MotionKey& key = motion.motion_keys.emplace_back();
        key.t_s = point.t_s;
        key.position_m = point.position_m;
    }
    return motion;
}

void Statistics::add(double value) {  // Welford's update
    ++count_;
    const double before = value - mean_;
    mean_ += before / static_cast<double>(count_);
    square_sum_ += before * (value - mean_);
}

double Statistics::mean() const {
    return count_ ? mean_ : std::numeric_limits<double>::quiet_NaN();
}

double Statistics::deviation() const {
    return count_ > 1 ? std::sqrt(square_sum_ / static_cast<double>(count_ - 1)) : 0;
}

StationRecorder::StationRecorder(std::vector<double> stations) : stations_(std::move(stations)) {
    std::sort(stations_.begin(), stations_.end());
}

void StationRecorder::observe(const std::vector<double>& row) {
    while (rows_.size() < stations_.size() && row[0] >= stations_[rows_.size()]) {
        const double station = stations_[rows_.size()];
        std::vector<double> at = row;
        const bool between = !last_.empty() && last_[0] < row[0];
        const double share = between ? (station - last_[0]) / (row[0] - last_[0]) : 1;
        for (size_t i = 0; between && i < at.size(); ++i) {
            at[i] = last_[i] + std::clamp(share, 0.0, 1.0) * (row[i] - last_[i]);
        }
        at[0] = station;
        rows_.push_back(std::move(at));
    }
    last_ = row;
}

}  // namespace bsoil::experiment
