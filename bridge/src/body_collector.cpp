#include "body_collector.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <cmath>

#include "bullet_types.h"

namespace bsoil::bullet {
namespace {

/// SoilBody::id is 0..65534.
constexpr int kIdCount = 65535;
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
    for (int i = 0; i < multibody_world->getNumMultibodies(); ++i)
        if (multibody_world->getMultiBody(i) == multibody) return true;
    return false;
}

GridBall ball_around(const Aabb& box) {
    return {0.5 * (box.min + box.max), 0.5 * length(box.max - box.min)};
}

}  // namespace

size_t BodyCollector::ShapeKeyHash::operator()(const ShapeKey& key) const {
    return std::hash<const void*>{}(key.shape) ^ static_cast<size_t>(key.fingerprint);
}

BodyCollector::BodyCollector(const Aabb& grid) : grid_(grid), id_taken_(kIdCount, false) {}

void BodyCollector::ignore(const btCollisionObject& object) { ignored_.insert(&object); }

bool BodyCollector::is_coupled(const btCollisionObject& object) const {
    if (!object.hasContactResponse() || ignored_.contains(&object)) return false;
    const auto found = tracked_.find(&object);
    if (found == tracked_.end()) return true;
    const Tracked& tracked = found->second;
    return tracked.id >= 0 && tracked.refusal.empty();
}

int BodyCollector::body_id(const btCollisionObject& object) const {
    const auto found = tracked_.find(&object);
    return found == tracked_.end() ? -1 : found->second.id;
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
    const int proxy_id = object.getBroadphaseHandle() ? object.getBroadphaseHandle()->getUid() : -1;
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
    GridBall grid = ball_around(grid_);
    if (is_finite(pose)) grid.center_m = transform(inverse(pose), grid.center_m);
    const ShapeKey key{&shape, shape_fingerprint(shape, grid)};
    if (key == tracked.key && (tracked.shapes || !tracked.refusal.empty())) return;
    tracked.key = key;
    ++tracked.shape_revision;
    tracked.refusal.clear();
    std::weak_ptr<const Shapes>& cached = shape_cache_[key];
    tracked.shapes = cached.lock();
    if (tracked.shapes) return;
    Result<Shapes> converted = convert_shape(shape, grid);
    if (converted) {
        tracked.shapes = std::make_shared<const Shapes>(std::move(*converted));
        cached = tracked.shapes;
    } else {
        tracked.refusal = converted.error();
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

void BodyCollector::describe(const btDiscreteDynamicsWorld& world, btCollisionObject& object,
                             Tracked& tracked, double elapsed_s, BodyState& state) {
    BodyMotion& motion = state.motion;
    motion.pose = from_bullet(object.getWorldTransform());
    motion.center_of_mass_m = motion.pose.position;  // Bullet's body frames sit in it
    state.object = &object;
    state.proxy_id = tracked.proxy_id;
    state.id = tracked.id;
    const auto surface = surfaces_.find(&object);
    state.surface = surface == surfaces_.end() ? SurfaceFriction{} : surface->second;
    const double gravity = length(from_bullet(world.getGravity()));

    const auto* link = btMultiBodyLinkCollider::upcast(&object);
    const btRigidBody* rigid = btRigidBody::upcast(&object);
    if (link && simulates(world, link->m_multiBody)) {
        const btMultiBody& multibody = *link->m_multiBody;
        const bool is_base = link->m_link < 0;
        state.role = is_base && multibody.hasFixedBase() ? BodyRole::fixed : BodyRole::link;
        state.is_asleep = !multibody.isAwake();
        state.weight_n =
            gravity * static_cast<double>(is_base ? multibody.getBaseMass()
                                                  : multibody.getLinkMass(link->m_link));
        if (state.role == BodyRole::link && !state.is_asleep)
            read_link_velocity(multibody, link->m_link, motion);
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
        const bool is_known = length(motion.linear_velocity_m_s) > kNoSpeed ||
                              length(motion.angular_velocity_rad_s) > kNoSpeed;
        if (!is_known && tracked.has_pose && elapsed_s > 0) {
            motion.linear_velocity_m_s =
                (motion.pose.position - tracked.last_pose.position) * (1 / elapsed_s);
            motion.angular_velocity_rad_s =
                rotation_vector_of(motion.pose.rotation * conjugate(tracked.last_pose.rotation)) *
                (1 / elapsed_s);
        }
    }
    tracked.has_pose = true;
    tracked.last_pose = motion.pose;
}

void BodyCollector::collect(const btDiscreteDynamicsWorld& world, double elapsed_s,
                            const btCollisionObject* ground) {
    ++scan_;
    bodies_.clear();
    guests_.clear();
    refused_.clear();
    velocity_owner_ = nullptr;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        btCollisionObject& object = *objects[i];
        if (!object.getCollisionShape() || !object.hasContactResponse()) continue;
        if (&object == ground || ignored_.contains(&object)) continue;
        const bool is_placed = is_finite(from_bullet(object.getWorldTransform()));
        const bool is_in_grid = is_placed && touches_grid(object);
        const auto known = tracked_.find(&object);
        // A body that has just left is shown to the soil once more; one with a NaN pose always, so
        // that it is reported.
        if (!is_in_grid && is_placed && (known == tracked_.end() || !known->second.was_in_grid)) {
            if (known != tracked_.end()) known->second.seen_in_scan = scan_;
            continue;
        }
        Tracked& tracked = track(object);
        tracked.was_in_grid = is_in_grid;
        if (tracked.id < 0) {
            refuse(object, tracked, "more bodies than there are ids");
            continue;
        }
        convert(object, tracked);
        if (!is_placed) refuse(object, tracked, "its pose is not finite");
        if (!tracked.shapes) {
            refuse(object, tracked, tracked.refusal);
            continue;
        }
        describe(world, object, tracked, elapsed_s, bodies_.emplace_back());
    }
    std::erase_if(tracked_, [this](const auto& entry) {
        const bool gone = entry.second.seen_in_scan != scan_;
        if (gone) surfaces_.erase(entry.first);
        if (gone && entry.second.id >= 0) id_taken_[entry.second.id] = false;
        return gone;
    });
    std::erase_if(shape_cache_, [](const auto& entry) { return entry.second.expired(); });
}

void BodyCollector::add_guest(GuestBody guest) {
    bodies_.push_back(guest.state);
    guests_.push_back(std::move(guest));
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
        body.surface = state.surface;
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
