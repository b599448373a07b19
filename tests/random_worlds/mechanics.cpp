#include "mechanics.h"

#include <algorithm>
#include <cmath>

#include "bullet_types.h"

namespace bsoil::random_worlds {

using bullet::from_bullet;

namespace {

void add_chain(const BuiltWorld::Chain& chain, std::vector<MovingPart>& parts) {
    const btMultiBody& m = *chain.multibody;
    const auto count = static_cast<size_t>(m.getNumLinks()) + 1;
    std::vector<btVector3> angular(count), linear(count);
    m.compTreeLinkVelocities(angular.data(), linear.data());
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
            part.velocity_m_s = from_bullet(m.localDirToWorld(link, linear[i]));
            part.spin_rad_s = from_bullet(m.localDirToWorld(link, angular[i]));
        }
        parts.push_back(part);
    }
}

}  // namespace

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
        sum += report.force_n + report.load_n;
    }
    for (const BuiltWorld::Car& car : world.cars()) {
        if (car.chassis != &object) continue;
        for (int i = 0; i < 4; ++i) {
            const auto wheel = car.caster->wheel_report(i);
            const btWheelInfo& info = car.vehicle->getWheelInfo(i);
            if (wheel.is_on_soil) {
                sum += wheel.normal_force_n * world.up();
            } else if (info.m_raycastInfo.m_isInContact) {
                sum += static_cast<double>(info.m_wheelsSuspensionForce) *
                       bullet::from_bullet(info.m_raycastInfo.m_contactNormalWS);
            }
        }
    }
    return sum;
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

}  // namespace bsoil::random_worlds
