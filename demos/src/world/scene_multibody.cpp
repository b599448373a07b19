#include "scene_multibody.h"

#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>

#include <algorithm>
#include <cmath>

namespace bsoil::scene {
namespace {

/// Bullet's frame of a body (centre of mass, principal axes) in the world at the start.
btTransform center_of(const MultibodyLink& link) {
    return to_bullet(link.item->pose) * link.shape.center;
}

}  // namespace

void GroupFilter::add(const btCollisionObject& object, const std::string& group) {
    if (!group.empty()) group_of_[&object] = group;
}

bool GroupFilter::needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const {
    if (!(a->m_collisionFilterGroup & b->m_collisionFilterMask) ||
        !(b->m_collisionFilterGroup & a->m_collisionFilterMask)) {
        return false;
    }
    const auto of_a = group_of_.find(a->m_clientObject), of_b = group_of_.find(b->m_clientObject);
    return of_a == group_of_.end() || of_b == group_of_.end() || of_a->second != of_b->second;
}

SceneMultibody::SceneMultibody(btMultiBodyDynamicsWorld& world, GroupFilter& filter,
                               const MultibodyItem& item, double substep_s)
    : world_(world), has_base_(!item.links.front().joint), motors_(item.links.size(), nullptr) {
    const MultibodyLink& first = item.links.front();
    const bool stands = !has_base_ || first.item->mass_kg <= 0;
    const int link_count = static_cast<int>(item.links.size()) - (has_base_ ? 1 : 0);
    multibody_ = std::make_unique<btMultiBody>(link_count, stands ? 0 : scalar(first.item->mass_kg),
                                               stands ? btVector3(0, 0, 0) : first.shape.inertia,
                                               stands, true);
    multibody_->setLinearDamping(0);
    multibody_->setAngularDamping(0);
    multibody_->setHasSelfCollision(first.item->group.empty());
    if (has_base_) multibody_->setBaseWorldTransform(center_of(first));
    for (size_t i = has_base_ ? 1 : 0; i < item.links.size(); ++i) set_up_link(item, i);
    multibody_->finalizeMultiDof();
    world_.addMultiBody(multibody_.get());
    for (size_t i = 0; i < item.links.size(); ++i) {
        add_collider(filter, item.links[i], i);
        if (item.links[i].joint) add_limit_and_motor(*item.links[i].joint, i, substep_s);
    }
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    multibody_->forwardKinematics(rotations, origins);
    multibody_->updateCollisionObjectWorldTransforms(rotations, origins);
}

SceneMultibody::~SceneMultibody() {
    for (const auto& constraint : constraints_) world_.removeMultiBodyConstraint(constraint.get());
    for (const auto& collider : colliders_) world_.removeCollisionObject(collider.get());
    world_.removeMultiBody(multibody_.get());
}

void SceneMultibody::set_up_link(const MultibodyItem& item, size_t i) {
    const MultibodyLink& link = item.links[i];
    const JointItem& joint = *link.joint;
    const int index = link_index(i);
    const int parent = link.parent < 0 ? -1 : link_index(static_cast<size_t>(link.parent));
    const btTransform center = center_of(link);
    const btTransform parent_center = link.parent < 0
                                          ? btTransform::getIdentity()
                                          : center_of(item.links[static_cast<size_t>(link.parent)]);
    const btTransform in_parent = parent_center.inverse() * center;
    const btQuaternion to_this = in_parent.getRotation().inverse();
    const btVector3 axis = to_bullet(joint.axis).normalized() * center.getBasis();
    const btVector3 pivot = to_bullet(joint.point_m);
    const btVector3 parent_to_pivot = parent_center.inverse() * pivot;
    const btVector3 pivot_to_this = -(center.inverse() * pivot);
    const btScalar mass = scalar(link.item->mass_kg);
    if (joint.kind == "hinge") {
        multibody_->setupRevolute(index, mass, link.shape.inertia, parent, to_this, axis,
                                  parent_to_pivot, pivot_to_this, true);
    } else if (joint.kind == "slider") {
        multibody_->setupPrismatic(index, mass, link.shape.inertia, parent, to_this, axis,
                                   parent_to_pivot, pivot_to_this, true);
    } else {
        multibody_->setupPlanar(index, mass, link.shape.inertia, parent, to_this, axis,
                                in_parent.getOrigin(), true);
    }
}

void SceneMultibody::add_collider(GroupFilter& filter, const MultibodyLink& link, size_t i) {
    const int index = link_index(i);
    auto collider = std::make_unique<btMultiBodyLinkCollider>(multibody_.get(), index);
    collider->setCollisionShape(link.shape.shape);
    collider->setWorldTransform(center_of(link));
    collider->setFriction(scalar(link.item->friction));
    collider->setRestitution(scalar(link.item->restitution));
    if (link.item->is_ghost) {
        collider->setCollisionFlags(collider->getCollisionFlags() |
                                    btCollisionObject::CF_NO_CONTACT_RESPONSE);
    }
    const bool stands = index < 0 && multibody_->hasFixedBase();
    if (stands) {
        collider->setCollisionFlags(collider->getCollisionFlags() |
                                    btCollisionObject::CF_STATIC_OBJECT);
    }
    filter.add(*collider, link.item->group);
    world_.addCollisionObject(
        collider.get(), stands ? btBroadphaseProxy::StaticFilter : btBroadphaseProxy::DefaultFilter,
        stands ? btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter
               : btBroadphaseProxy::AllFilter);
    if (index < 0) {
        multibody_->setBaseCollider(collider.get());
    } else {
        multibody_->getLink(index).m_collider = collider.get();
    }
    colliders_.push_back(std::move(collider));
}

void SceneMultibody::resist(double substep_s) {
    for (const Resistance& r : resistances_) {
        const double speed = std::abs(static_cast<double>(multibody_->getJointVel(r.link)));
        r.brake->setMaxAppliedImpulse(scalar((r.friction + r.damping * speed) * substep_s));
    }
}

void SceneMultibody::add_limit_and_motor(const JointItem& joint, size_t i, double substep_s) {
    const int index = link_index(i);
    const auto add = [this](std::unique_ptr<btMultiBodyConstraint> constraint) {
        constraint->finalizeMultiDof();
        world_.addMultiBodyConstraint(constraint.get());
        constraints_.push_back(std::move(constraint));
    };
    const auto& lower = joint.kind == "slider" ? joint.lower_m : joint.lower_rad;
    const auto& upper = joint.kind == "slider" ? joint.upper_m : joint.upper_rad;
    if (lower && upper) {
        add(std::make_unique<btMultiBodyJointLimitConstraint>(
            multibody_.get(), index, scalar(*lower - joint.start), scalar(*upper - joint.start)));
    }
    if (joint.resisting_friction > 0 || joint.resisting_damping > 0) {
        auto brake = std::make_unique<btMultiBodyJointMotor>(multibody_.get(), index, btScalar(0),
                                                             btScalar(0));
        resistances_.push_back(
            {brake.get(), index, joint.resisting_friction, joint.resisting_damping});
        add(std::move(brake));
    }
    const double effort = std::max(joint.motor_torque_n_m, joint.motor_force_n);
    if (effort <= 0) return;
    auto motor = std::make_unique<btMultiBodyJointMotor>(multibody_.get(), index, btScalar(0),
                                                         scalar(effort * substep_s));
    motors_[i] = motor.get();
    add(std::move(motor));
}

}  // namespace bsoil::scene
