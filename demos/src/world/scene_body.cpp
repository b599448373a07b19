#include "scene_body.h"

#include "scene_shapes.h"

namespace bsoil::scene {
namespace {

/// Velocities of all links, each in its own axes; the base comes first.
struct LinkVelocities {
    explicit LinkVelocities(const btMultiBody& multibody) {
        angular.resize(multibody.getNumLinks() + 1);
        linear.resize(multibody.getNumLinks() + 1);
        multibody.compTreeLinkVelocities(&angular[0], &linear[0]);
    }
    btAlignedObjectArray<btVector3> angular, linear;
};

}  // namespace

Pose SceneBody::pose() const {
    return from_bullet(object->getWorldTransform()) * inverse(frame_to_center);
}

Vec3 SceneBody::linear_velocity_m_s() const {
    if (body) return from_bullet(body->getLinearVelocity());
    return from_bullet(
        multibody->localDirToWorld(link, LinkVelocities(*multibody).linear[link + 1]));
}

Vec3 SceneBody::angular_velocity_rad_s() const {
    if (body) return from_bullet(body->getAngularVelocity());
    return from_bullet(
        multibody->localDirToWorld(link, LinkVelocities(*multibody).angular[link + 1]));
}

bool SceneBody::is_awake() const { return body ? body->isActive() : multibody->isAwake(); }

double SceneBody::mechanical_energy_j(const btVector3& gravity_m_s2) const {
    if (item->mass_kg <= 0 || item->kinematic) return 0;
    const Vec3 v = linear_velocity_m_s();
    const Vec3 omega = from_bullet(to_bullet(angular_velocity_rad_s()) *
                                   object->getWorldTransform().getBasis());  // the body's axes
    const Vec3 moments = from_bullet(body       ? body->getLocalInertia()
                                     : link < 0 ? multibody->getBaseInertia()
                                                : multibody->getLinkInertia(link));
    const Vec3 spin{moments.x * omega.x, moments.y * omega.y, moments.z * omega.z};
    const double mass_kg = body       ? 1 / static_cast<double>(body->getInvMass())
                           : link < 0 ? static_cast<double>(multibody->getBaseMass())
                                      : static_cast<double>(multibody->getLinkMass(link));
    const Vec3 at_m = from_bullet(object->getWorldTransform().getOrigin());
    return mass_kg * (dot(v, v) / 2 - dot(from_bullet(gravity_m_s2), at_m)) + dot(omega, spin) / 2;
}

}  // namespace bsoil::scene
