#include "mechanics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "bullet_types.h"

namespace bsoil::random_worlds {

using bullet::from_bullet;

namespace {

void add_chain(const BuiltWorld::Chain& chain, std::vector<MovingPart>& parts) {
    const btMultiBody& m = *chain.multibody;
    const std::vector<LinkMotion> motions = link_motions(m);
    for (int link = m.hasFixedBase() ? 0 : -1; link < m.getNumLinks(); ++link) {
        const auto i = static_cast<size_t>(link + 1);
        MovingPart part;
        part.object = chain.colliders[i].get();
        part.mass_kg = static_cast<double>(link < 0 ? m.getBaseMass() : m.getLinkMass(link));
        part.inertia_kg_m2 = from_bullet(link < 0 ? m.getBaseInertia() : m.getLinkInertia(link));
        part.pose = from_bullet(chain.colliders[i]->getWorldTransform());
        part.is_asleep = !m.isAwake();
        part.is_of_chain = true;
        if (!part.is_asleep) {
            part.velocity_m_s = from_bullet(motions[i].velocity);
            part.spin_rad_s = from_bullet(motions[i].spin);
        }
        parts.push_back(part);
    }
}

/// Whether a body lies beyond the soil's sides or below its floor.
bool has_left(const BuiltWorld& world, const MovingPart& part) {
    if (part.is_of_chain) return false;
    btVector3 middle;
    btScalar radius = 0;
    part.object->getCollisionShape()->getBoundingSphere(middle, radius);
    const auto reach_m = static_cast<double>(radius + middle.length());
    const int soil = soil_below(world, part.pose.position, -reach_m);
    if (soil < 0) return true;
    const GridFrame& frame = world.soil(soil).soil().frame();
    return frame.to_grid(part.pose.position).z * frame.voxel_m < -reach_m;
}

/// Along the strut, the wheel and its axle, as SoilWheelReport has them. On a car that leans what
/// grips bears a part of its weight.
Vec3 force_on_wheel_n(const bullet::SoilWheelReport& wheel, const btWheelInfo& info) {
    const btVector3 strut = -info.m_raycastInfo.m_wheelDirectionWS;
    const btVector3 steered = info.m_raycastInfo.m_wheelAxleWS.rotate(strut, info.m_steering);
    const btVector3 axle = (steered - steered.dot(strut) * strut).normalized();
    return wheel.normal_force_n * from_bullet(strut) +
           wheel.traction_n * from_bullet(strut.cross(axle)) +
           wheel.side_force_n * from_bullet(axle);
}

/// Rigid ground that leans by more than this sine holds a wheel by its friction as well, and of
/// that Bullet tells nothing. Ours: what it may bear of a load stays below half of the tolerance.
constexpr double kLevelSine = 0.01;

/// Whether a wheel of this car stands on rigid ground that leans.
bool stands_on_rigid_slope(const BuiltWorld::Car& car, Vec3 up) {
    for (int i = 0; i < car.vehicle->getNumWheels(); ++i) {
        const auto& ray = car.vehicle->getWheelInfo(i).m_raycastInfo;
        if (!ray.m_isInContact || car.caster->wheel_report(i).is_on_soil) continue;
        if (length(cross(from_bullet(ray.m_contactNormalWS), up)) > kLevelSine) return true;
    }
    return false;
}

/// Whether a strut of this car is as short as it gets: what soil pushes against its end with, the
/// chassis does not feel.
bool has_strut_at_its_end(const BuiltWorld::Car& car) {
    for (int i = 0; i < car.vehicle->getNumWheels(); ++i) {
        const btWheelInfo& wheel = car.vehicle->getWheelInfo(i);
        const btScalar travel_m = 0.01f * wheel.m_maxSuspensionTravelCm;  // as Bullet has it
        const btScalar left_m =
            wheel.m_raycastInfo.m_suspensionLength - (wheel.getSuspensionRestLength() - travel_m);
        if (wheel.m_raycastInfo.m_isInContact && left_m < 0.01f * travel_m) return true;
    }
    return false;
}

}  // namespace

std::vector<LinkMotion> link_motions(const btMultiBody& m) {
    const auto count = static_cast<size_t>(m.getNumLinks()) + 1;
    std::vector<btVector3> angular(count), linear(count);
    m.compTreeLinkVelocities(angular.data(), linear.data());
    std::vector<LinkMotion> out;
    for (int link = -1; link < m.getNumLinks(); ++link) {
        const auto i = static_cast<size_t>(link + 1);
        out.push_back({m.localDirToWorld(link, linear[i]), m.localDirToWorld(link, angular[i])});
    }
    return out;
}

std::vector<MovingPart> moving_parts(const BuiltWorld& built) {
    std::vector<MovingPart> parts;
    const btCollisionObjectArray& objects =
        const_cast<BuiltWorld&>(built).world().getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
        const btRigidBody* rigid = btRigidBody::upcast(objects[i]);
        if (!rigid || rigid->isStaticOrKinematicObject()) continue;
        MovingPart part;
        part.object = rigid;
        part.mass_kg = 1 / static_cast<double>(rigid->getInvMass());
        part.inertia_kg_m2 = from_bullet(rigid->getLocalInertia());
        part.pose = from_bullet(rigid->getWorldTransform());
        part.is_asleep = !rigid->isActive();
        if (!part.is_asleep) {
            part.velocity_m_s = from_bullet(rigid->getLinearVelocity());
            part.spin_rad_s = from_bullet(rigid->getAngularVelocity());
        }
        parts.push_back(part);
    }
    for (const BuiltWorld::Chain& chain : built.chains()) add_chain(chain, parts);
    return parts;
}

std::vector<MovingPart> parts_at_soil(const BuiltWorld& world) {
    std::vector<MovingPart> parts = moving_parts(world);
    std::set<const btCollisionObject*> left;
    for (const MovingPart& part : parts) {
        if (has_left(world, part)) left.insert(part.object);
    }
    for (bool goes_on = !left.empty(); goes_on;) {
        goes_on = false;
        for (const JointPlan& joint : world.plan().joints) {
            const btRigidBody *a = world.body(joint.a), *b = world.body(joint.b);
            if (joint.dropped || !a || !b || left.contains(a) == left.contains(b)) continue;
            const bool is_a = left.contains(a);
            if ((is_a ? b : a)->isStaticOrKinematicObject()) continue;
            left.erase(is_a ? a : b);
            goes_on = true;
        }
    }
    std::erase_if(parts, [&left](const MovingPart& part) { return left.contains(part.object); });
    return parts;
}

double height_m(const BuiltWorld& world, Vec3 world_m) { return dot(world.up(), world_m); }

double energy_j(const BuiltWorld& world, std::span<const MovingPart> parts) {
    const double floor_m = height_m(world, world.soil(0).soil().frame().to_world({0, 0, 0}));
    double sum = 0;
    for (const MovingPart& part : parts) {
        const Vec3 spin = rotate(conjugate(part.pose.rotation), part.spin_rad_s);
        const Vec3 i = part.inertia_kg_m2;
        sum +=
            0.5 * part.mass_kg * dot(part.velocity_m_s, part.velocity_m_s) +
            0.5 * (i.x * spin.x * spin.x + i.y * spin.y * spin.y + i.z * spin.z * spin.z) +
            part.mass_kg * world.gravity_m_s2() * (height_m(world, part.pose.position) - floor_m);
    }
    return sum;
}

double load_kg(const BuiltWorld& world, const btCollisionObject& object) {
    double sum = 0;
    for (const bullet::SoilAction* soil : world.soils()) {
        if (!soil->options(object).coverage_only) {  // what it reports does not act on it
            sum += soil->body_report(object).load_kg;
        }
    }
    return sum;
}

Vec3 soil_force_n(const BuiltWorld& world, const btCollisionObject& object) {
    Vec3 sum;
    for (const bullet::SoilAction* soil : world.soils()) {
        if (soil->options(object).coverage_only) continue;
        const bullet::BodyReport report = soil->body_report(object);
        sum += report.force_n + report.load_n + report.through_load_n;
    }
    for (const BuiltWorld::Car& car : world.cars()) {
        if (car.chassis != &object) continue;
        for (int i = 0; i < 4; ++i) {
            const auto wheel = car.caster->wheel_report(i);
            const btWheelInfo& info = car.vehicle->getWheelInfo(i);
            if (wheel.is_on_soil) {
                sum += force_on_wheel_n(wheel, info);
            } else if (info.m_raycastInfo.m_isInContact) {
                sum += static_cast<double>(info.m_wheelsSuspensionForce) *
                       bullet::from_bullet(info.m_raycastInfo.m_contactNormalWS);
            }
        }
    }
    return sum;
}

bool tells_its_weight(const BuiltWorld::Car& car, Vec3 up) {
    return !stands_on_rigid_slope(car, up) && !has_strut_at_its_end(car);
}

int soil_below(const BuiltWorld& world, Vec3 world_m, double margin_m) {
    const std::vector<bullet::SoilAction*> soils = world.soils();
    for (size_t i = 0; i < soils.size(); ++i) {
        const GridFrame& frame = soils[i]->soil().frame();
        const Vec3 at = frame.to_grid(world_m);
        const double margin = margin_m / frame.voxel_m;
        if (at.x >= margin && at.y >= margin && at.x <= frame.size[0] - margin &&
            at.y <= frame.size[1] - margin) {
            return static_cast<int>(i);
        }
    }
    return -1;
}

namespace {

struct Box {
    btVector3 low, high;
};

/// Bullet's box about an object, along the axes of a soil's grid [m].
Box box_in_grid(const bullet::SoilAction& soil, const btCollisionObject& object) {
    const Pose to_grid = inverse(soil.soil().frame().grid_to_world);
    Box box;
    object.getCollisionShape()->getAabb(
        bullet::transform_to_bullet(to_grid) * object.getWorldTransform(), box.low, box.high);
    return box;
}

}  // namespace

bool touches_others(btDispatcher& dispatcher, const btCollisionObject& object) {
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        if (manifold.getNumContacts() > 0 &&
            (manifold.getBody0() == &object || manifold.getBody1() == &object)) {
            return true;
        }
    }
    return false;
}

std::set<int> islands_kept_awake(btDispatcher& dispatcher) {
    std::set<int> tags;
    const auto keeps = [](const btCollisionObject& object) {
        return object.isKinematicObject() && object.isActive() && object.hasContactResponse();
    };
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        const btCollisionObject &a = *manifold.getBody0(), &b = *manifold.getBody1();
        if (keeps(a)) tags.insert(b.getIslandTag());
        if (keeps(b)) tags.insert(a.getIslandTag());
    }
    return tags;
}

bool is_unstoppable(const BodyPlan& body, const Soil& soil) {
    if (body.dropped) return false;
    if (body.kind == BodyPlan::Kind::driven) return true;
    const std::vector<double> of_materials_kg = soil.totals().mass_kg;
    const double soil_kg = std::accumulate(of_materials_kg.begin(), of_materials_kg.end(), 0.0);
    return body.kind == BodyPlan::Kind::moving && body.mass_kg > soil_kg;
}

bool reaches_into(const bullet::SoilAction& soil, const btCollisionObject& object) {
    const GridFrame& frame = soil.soil().frame();
    const Box box = box_in_grid(soil, object);
    for (int i = 0; i < 3; ++i) {
        const double end_m = frame.size[i] * frame.voxel_m;
        if (static_cast<double>(box.high[i]) < 0 || static_cast<double>(box.low[i]) > end_m) {
            return false;
        }
    }
    return true;
}

bool has_left_soil(const BuiltWorld& world, const MovingPart& part) {
    const int soil = soil_below(world, part.pose.position, 0);
    return soil < 0 || box_in_grid(world.soil(soil), *part.object).high.z() < 0;
}

WeighedTogether::WeighedTogether(const BuiltWorld& world) {
    for (const BuiltWorld::Chain& chain : world.chains()) {
        for (const auto& collider : chain.colliders) {
            keys_[collider.get()] =
                chain.multibody->hasFixedBase() ? nullptr : chain.colliders[0].get();
        }
    }
    for (const JointPlan& joint : world.plan().joints) {
        const btRigidBody *a = world.body(joint.a), *b = world.body(joint.b);
        if (!joint.dropped && a && b) join(a, b);
    }
}

const btCollisionObject* WeighedTogether::key_of(const btCollisionObject* object) const {
    const auto found = keys_.find(object);
    return found == keys_.end() ? object : found->second;
}

void WeighedTogether::join(const btCollisionObject* a, const btCollisionObject* b) {
    const btCollisionObject *of_a = key_of(a), *of_b = key_of(b);
    if (of_a == of_b) return;
    keys_[a] = of_a;
    keys_[b] = of_b;
    for (auto& [object, key] : keys_) {
        if (key == of_a || key == of_b) key = of_a && of_b ? of_a : nullptr;
    }
}

}  // namespace bsoil::random_worlds
