#include "hand.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

namespace bsoil::viewer {
namespace {

constexpr double kStrength = 40;     ///< of the body's weight
constexpr double kStiffness = 0.15;  ///< of the distance to go, in each substep

btVector3 to_bullet(Vec3 v) {
    return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}
Vec3 from_bullet(const btVector3& v) {
    return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}

}  // namespace

std::optional<Sighting> look_along(btDiscreteDynamicsWorld& world, Vec3 from_m, Vec3 to_m) {
    btCollisionWorld::ClosestRayResultCallback nearest(to_bullet(from_m), to_bullet(to_m));
    world.rayTest(to_bullet(from_m), to_bullet(to_m), nearest);
    if (!nearest.hasHit()) return {};
    return Sighting{nearest.m_collisionObject, from_bullet(nearest.m_hitPointWorld)};
}

bool Hand::take(const Sighting& sighting) {
    let_go();
    const btVector3 at = to_bullet(sighting.point_m);
    auto* object = const_cast<btCollisionObject*>(sighting.object);
    const auto substep_s = static_cast<btScalar>(substep_s_);
    const btScalar gravity = world_.getGravity().length();
    if (btRigidBody* body = btRigidBody::upcast(object)) {
        if (body->isStaticOrKinematicObject()) return false;
        was_sleepless_ = body->getActivationState() == DISABLE_DEACTIVATION;
        body->forceActivationState(DISABLE_DEACTIVATION);
        joint_ = std::make_unique<btPoint2PointConstraint>(
            *body, body->getCenterOfMassTransform().inverse() * at);
        joint_->m_setting.m_tau = btScalar(kStiffness);
        joint_->m_setting.m_impulseClamp =
            btScalar(kStrength) * gravity * substep_s / body->getInvMass();
        world_.addConstraint(joint_.get(), false);
    } else if (btMultiBodyLinkCollider* link = btMultiBodyLinkCollider::upcast(object)) {
        auto* world = dynamic_cast<btMultiBodyDynamicsWorld*>(&world_);
        btMultiBody* multibody = link->m_multiBody;
        if (!world || (link->m_link < 0 && multibody->hasFixedBase())) return false;
        multibody->wakeUp();
        was_sleepless_ = !multibody->getCanSleep();
        multibody->setCanSleep(false);
        btScalar mass = multibody->getBaseMass();
        for (int l = 0; l < multibody->getNumLinks(); ++l) mass += multibody->getLinkMass(l);
        link_joint_ = std::make_unique<btMultiBodyPoint2Point>(
            multibody, link->m_link, nullptr, multibody->worldPosToLocal(link->m_link, at), at);
        link_joint_->setMaxAppliedImpulse(btScalar(kStrength) * mass * gravity * substep_s);
        world->addMultiBodyConstraint(link_joint_.get());
    } else {
        return false;
    }
    held_ = object;
    target_m_ = sighting.point_m;
    return true;
}

void Hand::move_to(Vec3 point_m) {
    target_m_ = point_m;
    if (joint_) joint_->setPivotB(to_bullet(point_m));
    if (link_joint_) link_joint_->setPivotInB(to_bullet(point_m));
}

void Hand::let_go() {
    if (joint_) {
        btRigidBody& body = joint_->getRigidBodyA();
        world_.removeConstraint(joint_.get());
        // The chassis of a raycast vehicle: asleep it would not hear its engine.
        body.forceActivationState(was_sleepless_ ? DISABLE_DEACTIVATION : ACTIVE_TAG);
        body.setDeactivationTime(0);
        joint_.reset();
    }
    if (link_joint_) {
        auto* world = static_cast<btMultiBodyDynamicsWorld*>(&world_);
        link_joint_->getMultiBodyA()->setCanSleep(!was_sleepless_);
        world->removeMultiBodyConstraint(link_joint_.get());
        link_joint_.reset();
    }
    held_ = nullptr;
}

}  // namespace bsoil::viewer
