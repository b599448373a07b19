// The machines of a plan: joints, chains of links, cars.
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include <algorithm>
#include <cmath>

#include "built_world.h"
#include "bullet_types.h"

namespace bsoil::random_worlds {

using bullet::from_bullet;
using bullet::to_bullet;
using bullet::transform_to_bullet;

namespace {

/// A suspension that sags by s swings with w = sqrt(g / s). Bullet steps it explicitly, damping c
/// as well: stable while f (c dt + (w dt)^2 / 2) < 2, f being 1 in heave and 3.7 in roll, where the
/// wheels' arm is 1.9 radii of gyration of add_car's chassis. Beyond it a car throws itself about
/// with Bullet alone. With c = 1.4 w that is w dt < 0.34. Where a car's would be more it gets a
/// softer suspension with less damping: 3.7 (0.25 + 0.18) = 1.6.
constexpr double kTurnMost = 0.31, kSoftTurn = 0.6, kSoftDamping = 0.25;

}  // namespace

void BuiltWorld::add_joint(const JointPlan& joint) {
    btRigidBody *a = body(joint.a), *b = body(joint.b);
    if (!a || !b) return;
    const btVector3 middle =
        (a->getWorldTransform().getOrigin() + b->getWorldTransform().getOrigin()) / 2;
    btVector3 axis = to_bullet(joint.axis).normalized();
    btVector3 first, second;
    btPlaneSpace1(axis, first, second);
    // The joint's own axis is its frame's x (slider) or z (hinge).
    const bool is_slider = joint.kind == JointPlan::Kind::slider;
    btMatrix3x3 basis(axis.x(), first.x(), second.x(), axis.y(), first.y(), second.y(), axis.z(),
                      first.z(), second.z());
    if (!is_slider) {
        basis = btMatrix3x3(first.x(), second.x(), axis.x(), first.y(), second.y(), axis.y(),
                            first.z(), second.z(), axis.z());
    }
    const btTransform frame(basis, middle);
    const btTransform in_a = a->getWorldTransform().inverse() * frame;
    const btTransform in_b = b->getWorldTransform().inverse() * frame;
    std::unique_ptr<btTypedConstraint> made;
    const double reach = static_cast<double>(
        (a->getWorldTransform().getOrigin() - b->getWorldTransform().getOrigin()).length());
    const auto slack = scalar(0.2 * reach);
    switch (joint.kind) {
        case JointPlan::Kind::hinge: {
            auto hinge = std::make_unique<btHingeConstraint>(*a, *b, in_a, in_b, true);
            if (joint.motor_most > 0) {
                hinge->enableAngularMotor(true, scalar(joint.motor_speed),
                                          scalar(joint.motor_most * plan_.frame_s));
            }
            made = std::move(hinge);
            break;
        }
        case JointPlan::Kind::slider: {
            auto slider = std::make_unique<btSliderConstraint>(*a, *b, in_a, in_b, true);
            slider->setLowerLinLimit(-slack);
            slider->setUpperLinLimit(slack);
            slider->setLowerAngLimit(0);
            slider->setUpperAngLimit(0);
            if (joint.motor_most > 0) {
                slider->setPoweredLinMotor(true);
                slider->setTargetLinMotorVelocity(scalar(joint.motor_speed * reach));
                slider->setMaxLinMotorForce(scalar(joint.motor_most / reach));
            }
            made = std::move(slider);
            break;
        }
        case JointPlan::Kind::point:
            made = std::make_unique<btPoint2PointConstraint>(*a, *b, in_a.getOrigin(),
                                                             in_b.getOrigin());
            break;
        case JointPlan::Kind::six_dof: {
            auto six = std::make_unique<btGeneric6DofConstraint>(*a, *b, in_a, in_b, true);
            six->setLinearLowerLimit({-slack, 0, 0});
            six->setLinearUpperLimit({slack, 0, 0});
            six->setAngularLowerLimit({scalar(-0.3), 0, 0});
            six->setAngularUpperLimit({scalar(0.3), 0, 0});
            made = std::move(six);
            break;
        }
    }
    world_->addConstraint(made.get(), true);
    auto feedback = std::make_unique<btJointFeedback>();
    made->setJointFeedback(feedback.get());
    Joint& added = joints_.emplace_back();
    added.bullet = std::move(made);
    added.plan = joint;
    added.feedback = std::move(feedback);
}

void BuiltWorld::add_chain(const ChainPlan& plan) {
    Chain chain;
    const double h = plan.half_m;
    const auto half = scalar(h);
    const auto box = [&](btScalar x, btScalar y, btScalar z) {
        return &shapes_.make(box_plan(from_bullet(btVector3(x, y, z))));
    };
    btCollisionShape* base_shape = box(half, half, half);
    btCollisionShape* link_shape = box(half, half * scalar(0.6), half * scalar(0.6));
    const auto mass = scalar(plan.link_mass_kg);
    btVector3 base_inertia, link_inertia;
    base_shape->calculateLocalInertia(2 * mass, base_inertia);
    link_shape->calculateLocalInertia(mass, link_inertia);
    chain.multibody = std::make_unique<btMultiBody>(plan.link_count, 2 * mass, base_inertia,
                                                    plan.has_fixed_base, true);
    btMultiBody& m = *chain.multibody;
    const Pose pose = to_world(plan.soil, plan.pose);
    m.setBasePos(to_bullet(pose.position));
    // Bullet's multibody turns from the world's axes to its own.
    m.setWorldToBaseRot(transform_to_bullet(pose).getRotation().inverse());
    m.setLinearDamping(0);
    m.setAngularDamping(0);
    for (int i = 0; i < plan.link_count; ++i) {
        m.setupRevolute(i, mass, link_inertia, i - 1, btQuaternion::getIdentity(),
                        btVector3(0, 1, 0), btVector3(half * scalar(1.2), 0, 0),
                        btVector3(half * scalar(1.2), 0, 0), true);
    }
    m.finalizeMultiDof();
    world_->addMultiBody(&m);
    for (int i = -1; i < plan.link_count; ++i) {
        auto collider = std::make_unique<btMultiBodyLinkCollider>(&m, i);
        collider->setCollisionShape(i < 0 ? base_shape : link_shape);
        const bool is_fixed = i < 0 && plan.has_fixed_base;
        world_->addCollisionObject(
            collider.get(),
            is_fixed ? btBroadphaseProxy::StaticFilter : btBroadphaseProxy::DefaultFilter,
            is_fixed ? btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter
                     : btBroadphaseProxy::AllFilter);
        if (i < 0) {
            m.setBaseCollider(collider.get());
        } else {
            m.getLink(i).m_collider = collider.get();
        }
        chain.colliders.push_back(std::move(collider));
    }
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    m.forwardKinematics(rotations, origins);
    m.updateCollisionObjectWorldTransforms(rotations, origins);
    if (plan.motor_most > 0) {
        chain.motor = std::make_unique<btMultiBodyJointMotor>(
            &m, plan.link_count - 1, scalar(plan.motor_speed),
            scalar(plan.motor_most * plan_.frame_s / plan_.substep_count));
        world_->addMultiBodyConstraint(chain.motor.get());
        chain.motor->finalizeMultiDof();
    }
    chains_.push_back(std::move(chain));
}

void BuiltWorld::add_car(const CarPlan& plan) {
    Car car;
    const double r = plan.radius_m;
    const auto radius = scalar(r);
    // Bullet's vehicle looks along its chassis's axes: x forward, the soil's up up, z or y aside.
    const Pose frame = to_world(plan.soil, plan.pose);
    btCollisionShape& shape = shapes_.make(box_plan(Vec3{3, 1.25, 0.5} * r));
    btVector3 inertia;
    shape.calculateLocalInertia(scalar(plan.mass_kg), inertia);
    auto chassis = std::make_unique<btRigidBody>(scalar(plan.mass_kg), nullptr, &shape, inertia);
    chassis->setWorldTransform(transform_to_bullet(frame));
    chassis->setInterpolationWorldTransform(transform_to_bullet(frame));
    world_->addRigidBody(chassis.get());
    car.chassis = chassis.get();
    chassis_.push_back(std::move(chassis));
    car.caster = std::make_unique<bullet::SoilRaycaster>(*soils_[static_cast<size_t>(plan.soil)]);
    btRaycastVehicle::btVehicleTuning tuning;
    // A suspension that sags by a tenth of a wheel's radius under the chassis.
    const double substep_s = plan_.frame_s / plan_.substep_count;
    double sag_m = 0.1 * r, damping = 0.7 * std::sqrt(gravity_m_s2() / (4 * sag_m));
    if (std::sqrt(gravity_m_s2() / sag_m) * substep_s > kTurnMost) {
        sag_m = std::max(sag_m, gravity_m_s2() * std::pow(substep_s / kSoftTurn, 2));
        damping = kSoftDamping / (4 * substep_s);
    }
    tuning.m_suspensionStiffness = scalar(gravity_m_s2() / (4 * sag_m));
    tuning.m_suspensionCompression = scalar(damping);
    tuning.m_suspensionDamping = tuning.m_suspensionCompression;
    tuning.m_maxSuspensionForce = scalar(1e9);
    tuning.m_maxSuspensionTravelCm = scalar(60 * r);
    tuning.m_frictionSlip = scalar(1.2);
    car.vehicle = std::make_unique<btRaycastVehicle>(tuning, car.chassis, car.caster.get());
    car.vehicle->setCoordinateSystem(1, 2, 0);
    for (int i = 0; i < 4; ++i) {
        car.vehicle->addWheel(
            btVector3(scalar(i < 2 ? 2.2 : -2.2) * radius, scalar(i % 2 == 0 ? 1.5 : -1.5) * radius,
                      scalar(-0.4) * radius),
            btVector3(0, 0, -1), btVector3(0, -1, 0), radius * scalar(0.6), radius, tuning, i < 2);
    }
    world_->addVehicle(car.vehicle.get());
    const bullet::SoilWheelDef wheel{.width_m = plan.width_m,
                                     .mass_kg = std::max(0.1, plan.mass_kg * 0.02),
                                     .rim_speed_max_m_s = std::max(0.1, 20 * r)};
    if (const Status done = car.caster->attach(*car.vehicle, wheel); !done) {
        error_ = "car: " + done.error();
    }
    for (int i = 0; i < 4; ++i) {
        car.vehicle->applyEngineForce(scalar(plan.engine_n / 4), i);
        if (i < 2) car.vehicle->setSteeringValue(scalar(plan.steering_rad), i);
    }
    cars_.push_back(std::move(car));
}

}  // namespace bsoil::random_worlds
