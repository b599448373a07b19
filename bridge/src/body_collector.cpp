#include "body_collector.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <cmath>

#include "bsoil/limits.h"
#include "bullet_types.h"
#include "soil_ground.h"
#include "world_anchor.h"

namespace bsoil::bullet {
namespace {

constexpr int kIdCount = limits::kBodyIdMost + 1;
/// A kinematic body that Bullet says is slower than this may have been moved by its pose alone.
constexpr double kNoSpeed = 1e-9;

Quat quat_of(Vec3 rotation_vector) {
    const double angle = length(rotation_vector);
    if (angle < 1e-12) return {};
    const Vec3 v = rotation_vector * (std::sin(angle / 2) / angle);
    return {v.x, v.y, v.z, std::cos(angle / 2)};
}

Vec3 rotation_vector_of(Quat q) {
    if (q.w < 0) q = {-q.x, -q.y, -q.z, -q.w};
    const Vec3 v{q.x, q.y, q.z};
    const double sine = length(v);
    return sine < 1e-12 ? 2.0 * v : v * (2 * std::atan2(sine, q.w) / sine);
}

/// The pose a time ago, at constant velocity about the centre of mass.
Pose moved_back(const BodyMotion& motion, double before_s) {
    const Quat back = quat_of(motion.angular_velocity_rad_s * -before_s);
    const Vec3 center = motion.center_of_mass_m - before_s * motion.linear_velocity_m_s;
    return {center + rotate(back, motion.pose.position - motion.center_of_mass_m),
            back * motion.pose.rotation};
}

bool simulates(const btDiscreteDynamicsWorld& world, const btMultiBody* multibody) {
    const auto* multibody_world = dynamic_cast<const btMultiBodyDynamicsWorld*>(&world);
    if (!multibody_world) return false;
    for (int i = 0; i < multibody_world->getNumMultibodies(); ++i) {
        if (multibody_world->getMultiBody(i) == multibody) return true;
    }
    return false;
}

/// Whether nothing but its host moves a link, or the base (-1).
bool is_given_link(const btMultiBody& multibody, int link) {
    return link < 0 ? multibody.isBaseStaticOrKinematic()
                    : multibody.isLinkAndAllAncestorsStaticOrKinematic(link);
}

/// Whether an object pushes soil and is pushed by it. A ghost tells what it overlaps, and has no
/// body unless its host says so: with one, a character's would push away all that it stands on.
bool takes_part(const btCollisionObject& object, const BodyOptions& options) {
    if (!object.hasContactResponse() || options.ignored) return false;
    return options.coverage_only || !btGhostObject::upcast(&object);
}

GridBall ball_around(const Aabb& box, double voxel_m) {
    return {0.5 * (box.min + box.max), 0.5 * length(box.max - box.min), voxel_m};
}

/// Shapes larger than the grid are cut to a ball around it. Of a body that moves it is a larger
/// one, whose centre in the body's frame goes in steps of this part of the grid's radius: to cut a
/// shape takes a tenth of a second. Ours: half. Larger: more of a shape is kept than the grid can
/// meet; smaller: it is cut anew more often.
constexpr double kCutStep = 0.5;

GridBall ball_for_motion(const GridBall& exact) {
    const double step_m = kCutStep * exact.radius_m;
    const auto stepped = [step_m](double x_m) {
        return step_m * std::round(x_m / step_m) + 0.0;  // no negative zero
    };
    const Vec3& center = exact.center_m;
    return {{stepped(center.x), stepped(center.y), stepped(center.z)},
            exact.radius_m + 0.5 * std::sqrt(3.0) * step_m,
            exact.voxel_m};
}

}  // namespace

int proxy_id_of(const btCollisionObject& object) {
    const btBroadphaseProxy* proxy = object.getBroadphaseHandle();
    return proxy ? proxy->getUid() : kNotInWorld;
}

size_t BodyCollector::ShapeKeyHash::operator()(const ShapeKey& key) const {
    return std::hash<const void*>{}(key.shape) ^ static_cast<size_t>(key.fingerprint);
}

BodyCollector::BodyCollector(const Aabb& grid, double voxel_m)
    : grid_(grid), voxel_m_(voxel_m), id_taken_(kIdCount, false) {}

void BodyCollector::set_options(const btCollisionObject& object, const BodyOptions& options) {
    if (options == BodyOptions{}) {
        options_.erase(&object);
    } else {
        options_[&object] = {options, proxy_id_of(object), scan_};
    }
}

BodyOptions BodyCollector::options(const btCollisionObject& object) const {
    const auto found = options_.find(&object);
    if (found == options_.end()) return {};
    const int known = found->second.proxy_id;
    return known == kNotInWorld || known == proxy_id_of(object) ? found->second.value
                                                                : BodyOptions{};
}

/// Those of an object of the world.
BodyOptions BodyCollector::options_in_scan(const btCollisionObject& object) {
    const auto found = options_.find(&object);
    if (found == options_.end()) return {};
    Options& options = found->second;
    if (options.proxy_id == kNotInWorld) options.proxy_id = proxy_id_of(object);
    if (options.proxy_id != proxy_id_of(object)) return {};  // a new object at an old address
    options.seen_in_scan = scan_;
    return options.value;
}

bool BodyCollector::is_coupled(const btCollisionObject& object) const {
    if (!takes_part(object, options(object))) return false;
    const auto found = tracked_.find(&object);
    if (found == tracked_.end()) return true;
    const Tracked& tracked = found->second;
    // Since the last look at the world it may have become a new object at an old address.
    if (tracked.proxy_id != proxy_id_of(object)) return true;
    return !tracked.is_refused();
}

int BodyCollector::body_id(const btCollisionObject& object) const {
    const auto found = tracked_.find(&object);
    return found == tracked_.end() ? -1 : found->second.id;
}

const btCollisionObject* BodyCollector::object_of(int id) const {
    for (const auto& [object, tracked] : tracked_) {
        if (id >= 0 && tracked.id == id) return object;
    }
    return nullptr;
}

int BodyCollector::next_id() {
    for (int tried = 0; tried < kIdCount; ++tried) {
        last_id_ = (last_id_ + 1) % kIdCount;
        if (!id_taken_[last_id_]) {
            id_taken_[last_id_] = true;
            return last_id_;
        }
    }
    return -1;
}

BodyCollector::Tracked& BodyCollector::track(const btCollisionObject& object) {
    Tracked& tracked = tracked_[&object];
    const int proxy_id = proxy_id_of(object);
    if (tracked.seen_in_scan == 0 || tracked.proxy_id != proxy_id) {
        if (tracked.seen_in_scan != 0 && tracked.id >= 0) id_taken_[tracked.id] = false;
        tracked = {};
        tracked.proxy_id = proxy_id;
        tracked.id = next_id();
    }
    tracked.seen_in_scan = scan_;
    return tracked;
}

bool BodyCollector::touches_grid(const btCollisionObject& object) const {
    btVector3 low, high;
    object.getCollisionShape()->getAabb(object.getWorldTransform(), low, high);
    const Vec3 min = from_bullet(low), max = from_bullet(high);
    return min.x <= grid_.max.x && max.x >= grid_.min.x && min.y <= grid_.max.y &&
           max.y >= grid_.min.y && min.z <= grid_.max.z && max.z >= grid_.min.z;
}

void BodyCollector::refuse(const btCollisionObject& object, const Tracked& tracked,
                           const std::string& reason) {
    refused_.push_back({&object, "body " + std::to_string(tracked.id) + " (user index " +
                                     std::to_string(object.getUserIndex()) + "): " + reason});
}

void BodyCollector::convert(const btCollisionObject& object, Tracked& tracked) {
    const btCollisionShape& shape = *object.getCollisionShape();
    const Pose pose = from_bullet(object.getWorldTransform());
    GridBall grid = ball_around(grid_, voxel_m_);
    if (is_rigid(pose)) grid.center_m = transform(inverse(pose), grid.center_m);
    if (!object.isStaticObject() || object.isKinematicObject()) grid = ball_for_motion(grid);
    const ShapeKey key{&shape, shape_fingerprint(shape, grid)};
    if (key == tracked.key && (tracked.shapes || !tracked.refusal.empty())) return;
    if (key != tracked.key) ++tracked.shape_revision;  // not where a snapshot has left it
    tracked.key = key;
    tracked.refusal.clear();
    tracked.has_no_shapes = false;
    std::weak_ptr<const Shapes>& cached = shape_cache_[key];
    tracked.shapes = cached.lock();
    if (tracked.shapes) return;
    Result<Shapes> converted = convert_shape(shape, grid);
    if (converted) {
        tracked.shapes = std::make_shared<const Shapes>(std::move(*converted));
        cached = tracked.shapes;
    } else {
        tracked.refusal = converted.error();
        tracked.has_no_shapes = true;
        shape_cache_.erase(key);
    }
}

void BodyCollector::read_link_velocity(const btMultiBody& multibody, int link, BodyMotion& motion) {
    if (velocity_owner_ != &multibody) {
        velocity_owner_ = &multibody;
        const size_t count = static_cast<size_t>(multibody.getNumLinks()) + 1;
        link_angular_.resize(count);
        link_linear_.resize(count);
        multibody.compTreeLinkVelocities(link_angular_.data(), link_linear_.data());
    }
    // The velocities are in each link's own axes, of its centre of mass.
    motion.linear_velocity_m_s =
        from_bullet(multibody.localDirToWorld(link, link_linear_[link + 1]));
    motion.angular_velocity_rad_s =
        from_bullet(multibody.localDirToWorld(link, link_angular_[link + 1]));
}

/// Of a body that its host moves, where Bullet knows no velocity.
void BodyCollector::add_velocity_of_pose(const Tracked& tracked, double elapsed_s,
                                         BodyMotion& motion) {
    const bool is_known = length(motion.linear_velocity_m_s) > kNoSpeed ||
                          length(motion.angular_velocity_rad_s) > kNoSpeed;
    if (is_known || !tracked.has_pose || !(elapsed_s > 0)) return;
    motion.linear_velocity_m_s =
        (motion.pose.position - tracked.last_pose.position) * (1 / elapsed_s);
    motion.angular_velocity_rad_s =
        rotation_vector_of(motion.pose.rotation * conjugate(tracked.last_pose.rotation)) *
        (1 / elapsed_s);
}

void BodyCollector::describe(const btDiscreteDynamicsWorld& world, btCollisionObject& object,
                             const BodyOptions& options, Tracked& tracked, double elapsed_s,
                             BodyState& state) {
    BodyMotion& motion = state.motion;
    motion.pose = from_bullet(object.getWorldTransform());
    motion.center_of_mass_m = motion.pose.position;  // Bullet's body frames sit in it
    state.object = &object;
    state.proxy_id = tracked.proxy_id;
    state.id = tracked.id;
    state.internal_type = object.getInternalType();
    state.surface = options.surface;
    const double gravity = length(from_bullet(world.getGravity()));

    const auto* link = btMultiBodyLinkCollider::upcast(&object);
    const btRigidBody* rigid = btRigidBody::upcast(&object);
    if (link && simulates(world, link->m_multiBody)) {
        const btMultiBody& multibody = *link->m_multiBody;
        const bool is_base = link->m_link < 0;
        state.role = BodyRole::link;
        if (is_given_link(multibody, link->m_link)) {
            state.role =
                is_base && !multibody.isBaseKinematic() ? BodyRole::fixed : BodyRole::driven;
        }
        const bool is_driven = state.role == BodyRole::driven;
        state.is_asleep = !is_driven && !multibody.isAwake();
        state.weight_n =
            gravity * static_cast<double>(is_base ? multibody.getBaseMass()
                                                  : multibody.getLinkMass(link->m_link));
        if (state.role != BodyRole::fixed && multibody.isAwake()) {
            read_link_velocity(multibody, link->m_link, motion);
        }
        if (is_driven) add_velocity_of_pose(tracked, elapsed_s, motion);
    } else if (rigid && !rigid->isStaticOrKinematicObject()) {
        state.role = BodyRole::rigid;
        state.is_asleep = !rigid->isActive();
        state.weight_n = gravity / static_cast<double>(rigid->getInvMass());
        if (!state.is_asleep) {  // Bullet clears the velocities a step later than it stops the body
            motion.linear_velocity_m_s = from_bullet(rigid->getLinearVelocity());
            motion.angular_velocity_rad_s = from_bullet(rigid->getAngularVelocity());
        }
    } else if (object.isStaticObject() && !object.isKinematicObject()) {  // hosts set both flags
        state.role = BodyRole::fixed;
    } else {
        state.role = BodyRole::driven;
        if (object.isActive()) {
            motion.linear_velocity_m_s = from_bullet(object.getInterpolationLinearVelocity());
            motion.angular_velocity_rad_s = from_bullet(object.getInterpolationAngularVelocity());
        }
        add_velocity_of_pose(tracked, elapsed_s, motion);
    }
    if (options.coverage_only && (state.role == BodyRole::rigid || state.role == BodyRole::link)) {
        state.role = BodyRole::driven;
    }
    tracked.has_pose = true;
    tracked.last_pose = motion.pose;
}

void BodyCollector::collect(const btDiscreteDynamicsWorld& world, double elapsed_s) {
    ++scan_;
    bodies_.clear();
    guests_.clear();
    refused_.clear();
    grids_.clear();
    velocity_owner_ = nullptr;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        btCollisionObject& object = *objects[i];
        if (const GridFrame* grid = WorldAnchor::grid_of(object)) grids_.push_back(grid);
        if (SoilGround::is_ground(object)) continue;
        const BodyOptions options = options_in_scan(object);
        if (!object.getCollisionShape() || !takes_part(object, options)) continue;
        const Pose pose = from_bullet(object.getWorldTransform());
        const bool is_placed = is_rigid(pose);
        const bool is_in_grid = is_placed && touches_grid(object);
        const auto known = tracked_.find(&object);
        // A body that has just left is shown to the soil once more; one with a NaN pose always, so
        // that it is reported.
        if (!is_in_grid && is_placed && (known == tracked_.end() || !known->second.was_in_grid)) {
            if (known != tracked_.end()) {
                known->second.seen_in_scan = scan_;
                known->second.last_pose = pose;  // it may come back
            }
            continue;
        }
        Tracked& tracked = track(object);
        tracked.was_in_grid = is_in_grid;
        if (tracked.id < 0) {
            refuse(object, tracked,
                   "more bodies than there are ids, 65535; let the soil ignore those that need "
                   "none");
            continue;
        }
        convert(object, tracked);
        if (!is_placed) {
            refuse(object, tracked,
                   "its pose is not finite, or turns by no unit quaternion; look for a division "
                   "by zero, or normalize it");
        }
        if (!tracked.shapes) {
            refuse(object, tracked, tracked.refusal);
            continue;
        }
        if (tracked.shapes->empty()) {  // its box touches the grid, it does not
            tracked.last_pose = pose;
            continue;
        }
        BodyState& state = bodies_.emplace_back();
        describe(world, object, options, tracked, elapsed_s, state);
        state.world_index = i;
    }
    std::erase_if(tracked_, [this](const auto& entry) {
        const bool gone = entry.second.seen_in_scan != scan_;
        if (gone && entry.second.id >= 0) id_taken_[entry.second.id] = false;
        return gone;
    });
    std::erase_if(options_, [this](const auto& entry) {
        return entry.second.proxy_id != kNotInWorld && entry.second.seen_in_scan != scan_;
    });
    std::erase_if(shape_cache_, [](const auto& entry) { return entry.second.expired(); });
}

const BodyState* BodyCollector::meet(const btDiscreteDynamicsWorld& world, btRigidBody& body) {
    const BodyOptions options = this->options(body);
    if (!body.getCollisionShape() || !body.hasContactResponse() || options.ignored ||
        options.coverage_only || !is_rigid(from_bullet(body.getWorldTransform())) ||
        !touches_grid(body)) {
        return nullptr;
    }
    Tracked& tracked = track(body);
    if (tracked.id < 0) return nullptr;
    convert(body, tracked);
    if (!tracked.shapes || tracked.shapes->empty()) return nullptr;
    met_ = {};
    describe(world, body, options, tracked, 0, met_);
    met_.world_index = body.getWorldArrayIndex();
    return &met_;
}

void BodyCollector::let_go() {
    bodies_.clear();
    guests_.clear();
    refused_.clear();
    grids_.clear();
    for (auto& [object, tracked] : tracked_) {
        tracked.has_pose = false;
        if (!tracked.is_refused()) id_taken_[tracked.id] = false;
    }
    std::erase_if(tracked_, [](const auto& entry) { return !entry.second.is_refused(); });
}

void BodyCollector::add_guest(GuestBody guest) {
    bodies_.push_back(guest.state);
    guests_.push_back(std::move(guest));
}

std::span<const ConvexShape> BodyCollector::shapes_of(const BodyState& body) const {
    return *tracked_.at(body.object).shapes;
}

std::span<SoilBody> BodyCollector::soil_bodies(double before_s) {
    soil_bodies_.clear();
    const size_t object_count = bodies_.size() - guests_.size();
    for (size_t i = 0; i < bodies_.size(); ++i) {
        const BodyState& state = bodies_[i];
        SoilBody& body = soil_bodies_.emplace_back();
        body.id = state.id;
        body.pose = before_s > 0 ? moved_back(state.motion, before_s) : state.motion.pose;
        body.linear_velocity_m_s = state.motion.linear_velocity_m_s;
        body.angular_velocity_rad_s = state.motion.angular_velocity_rad_s;
        body.center_of_mass_m =
            state.motion.center_of_mass_m - before_s * state.motion.linear_velocity_m_s;
        body.is_static = state.role == BodyRole::fixed;
        body.is_driven = state.role == BodyRole::driven;
        body.surface = state.surface;
        body.may_leave = std::any_of(grids_.begin(), grids_.end(), [&](const GridFrame* grid) {
            return grid->is_above(body.center_of_mass_m);
        });
        if (i < object_count) {
            const Tracked& tracked = tracked_.at(state.object);
            body.shapes = tracked.shapes.get();
            body.shape_revision = tracked.shape_revision;
        } else {
            body.shapes = guests_[i - object_count].shapes.get();
            body.shape_revision = guests_[i - object_count].shape_revision;
        }
    }
    return soil_bodies_;
}

}  // namespace bsoil::bullet
