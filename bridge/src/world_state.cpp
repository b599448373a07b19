#include "world_state.h"

#include <BulletDynamics/ConstraintSolver/btConeTwistConstraint.h>
#include <BulletDynamics/ConstraintSolver/btGeneric6DofConstraint.h>
#include <BulletDynamics/ConstraintSolver/btGeneric6DofSpring2Constraint.h>
#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/ConstraintSolver/btSliderConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Vehicle/btRaycastVehicle.h>

#include <algorithm>
#include <cmath>

#include "bullet_stream.h"
#include "contact_cache.h"
#include "expose.h"
#include "world_objects.h"

namespace bsoil::bullet {
namespace {

BSOIL_EXPOSE(InertiaTensor, &btRigidBody::m_invInertiaTensorWorld);
BSOIL_EXPOSE(InverseMass, &btRigidBody::m_inverseMass);
BSOIL_EXPOSE(InverseInertia, &btRigidBody::m_invInertiaLocal);
BSOIL_EXPOSE(GravityForce, &btRigidBody::m_gravity);
BSOIL_EXPOSE(GravityAcceleration, &btRigidBody::m_gravity_acceleration);
BSOIL_EXPOSE(TotalForce, &btRigidBody::m_totalForce);
BSOIL_EXPOSE(TotalTorque, &btRigidBody::m_totalTorque);
BSOIL_EXPOSE(ConeTwistTarget, &btConeTwistConstraint::m_qTarget);
BSOIL_EXPOSE(SleepTimer, &btMultiBody::m_sleepTimer);
BSOIL_EXPOSE(MultibodyRows, &btMultiBodyConstraint::m_data);
BSOIL_EXPOSE(VehicleSpeed, &btRaycastVehicle::m_currentVehicleSpeedKmHour);

struct WorldMembers : btDiscreteDynamicsWorld {
    static btScalar& local_time_s(btDiscreteDynamicsWorld& world) {
        return world.*(&WorldMembers::m_localTime);
    }
    static btAlignedObjectArray<btActionInterface*>& actions(btDiscreteDynamicsWorld& world) {
        return world.*(&WorldMembers::m_actions);
    }
};

std::vector<btRaycastVehicle*> vehicles_of(btDiscreteDynamicsWorld& world) {
    std::vector<btRaycastVehicle*> vehicles;
    const auto& actions = WorldMembers::actions(world);
    for (int i = 0; i < actions.size(); ++i) {
        if (auto* vehicle = dynamic_cast<btRaycastVehicle*>(actions[i])) {
            vehicles.push_back(vehicle);
        }
    }
    return vehicles;
}

/// Lists the world; in reading, right into it.
class WorldState {
  public:
    WorldState(StateStream& stream, btDiscreteDynamicsWorld& world)
        : stream_(stream), world_(world) {}

    void serialize();
    /// What is of another world; empty: nothing was found to be.
    const std::string& mismatch() const { return mismatch_; }

  private:
    void same(const char* what, int64_t here);
    void serialize_object(btCollisionObject& object);
    void serialize_rigid_body(btRigidBody& body);
    void serialize_multibody(btMultiBody& multibody);
    void serialize_multibody_constraint(btMultiBodyConstraint& constraint);
    void serialize_constraint(btTypedConstraint& constraint);
    void serialize_vehicle(btRaycastVehicle& vehicle);

    StateStream& stream_;
    btDiscreteDynamicsWorld& world_;
    std::string mismatch_;
};

/// A number that is part of how the world was built.
void WorldState::same(const char* what, int64_t here) {
    int64_t saved = here;
    stream_(saved);
    if (!stream_.good() || saved == here) return;
    if (mismatch_.empty()) {
        mismatch_ = std::string("is of another world: ") + std::to_string(saved) + " " + what +
                    " in the snapshot, " + std::to_string(here) +
                    " here; build the world as it was";
    }
    stream_.refuse();
}

void WorldState::serialize_object(btCollisionObject& o) {
    list(stream_, o.getWorldTransform());
    list(stream_, o.getInterpolationWorldTransform());
    btVector3 linear = o.getInterpolationLinearVelocity();
    btVector3 angular = o.getInterpolationAngularVelocity();
    btScalar rest_s = o.getDeactivationTime(), hit_fraction = o.getHitFraction();
    int32_t activation = o.getActivationState();
    list(stream_, linear);
    list(stream_, angular);
    stream_(rest_s, hit_fraction, activation);
    if (activation < ACTIVE_TAG || activation > 6) return stream_.refuse();
    if (stream_.reads()) {
        o.setInterpolationLinearVelocity(linear);
        o.setInterpolationAngularVelocity(angular);
        o.setDeactivationTime(rest_s);
        o.setHitFraction(hit_fraction);
        o.forceActivationState(activation);
    }
    if (btRigidBody* body = btRigidBody::upcast(&o)) serialize_rigid_body(*body);
}

void WorldState::serialize_rigid_body(btRigidBody& body) {
    btVector3 linear = body.getLinearVelocity(), angular = body.getAngularVelocity();
    list(stream_, linear);
    list(stream_, angular);
    list(stream_, body.*member(InertiaTensor{}));
    list(stream_, body.*member(InverseInertia{}));
    list(stream_, body.*member(GravityForce{}));
    list(stream_, body.*member(GravityAcceleration{}));
    list(stream_, body.*member(TotalForce{}));
    list(stream_, body.*member(TotalTorque{}));
    btScalar inverse_mass = body.getInvMass();
    stream_(inverse_mass);
    if (std::abs(inverse_mass - body.getInvMass()) > btScalar(kSameMass) * body.getInvMass()) {
        return stream_.refuse();
    }
    body.*member(InverseMass{}) = inverse_mass;
    if (stream_.reads()) {
        body.setLinearVelocity(linear);
        body.setAngularVelocity(angular);
        body.setLinearFactor(body.getLinearFactor());  // keeps their product
    }
    bool has_motion_state = body.getMotionState() != nullptr;
    const bool had = has_motion_state;
    stream_(has_motion_state);
    if (!has_motion_state) return;
    btTransform pose = btTransform::getIdentity();
    if (had) body.getMotionState()->getWorldTransform(pose);
    list(stream_, pose);
    // Kinematic bodies follow theirs; with an offset in it, what is set is not quite what is read.
    if (had && (stream_.reads() || body.isKinematicObject())) {
        body.getMotionState()->setWorldTransform(pose);
    }
}

void WorldState::serialize_multibody(btMultiBody& m) {
    same("links of a multibody", m.getNumLinks());
    same("degrees of freedom of a multibody", m.getNumDofs());
    if (!stream_.good()) return;
    btVector3 position = m.getBasePos(), force = m.getBaseForce(), torque = m.getBaseTorque();
    btQuaternion rotation = m.getWorldToBaseRot();
    bool awake = m.isAwake();
    list(stream_, position);
    list(stream_, rotation);
    list(stream_, force);
    list(stream_, torque);
    stream_(awake);
    if (stream_.reads()) {
        m.clearForcesAndTorques();
        m.setBasePos(position);
        m.setWorldToBaseRot(rotation);
        m.addBaseForce(force);
        m.addBaseTorque(torque);
        awake ? m.wakeUp() : m.goToSleep();
    }
    stream_(m.*member(SleepTimer{}));
    btScalar velocities[6] = {};
    const btVector3 omega = m.getBaseOmega(), velocity = m.getBaseVel();
    for (int i = 0; i < 3; ++i) {
        velocities[i] = omega[i];
        velocities[3 + i] = velocity[i];
    }
    for (btScalar& v : velocities) stream_(v);
    if (stream_.reads()) {
        m.setBaseOmega(btVector3(velocities[0], velocities[1], velocities[2]));
        m.setBaseVel(btVector3(velocities[3], velocities[4], velocities[5]));
    }
    for (int i = 0; i < m.getNumLinks(); ++i) {
        btMultibodyLink& link = m.getLink(i);
        for (int k = 0; k < link.m_posVarCount; ++k) stream_(m.getJointPosMultiDof(i)[k]);
        for (int k = 0; k < link.m_dofCount; ++k) {
            stream_(m.getJointVelMultiDof(i)[k], link.m_jointTorque[k]);
        }
        list(stream_, link.m_appliedForce);
        list(stream_, link.m_appliedTorque);
        if (stream_.reads()) link.updateCacheMultiDof();
    }
    if (!stream_.reads()) return;
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    m.forwardKinematics(rotations, origins);
    m.updateCollisionObjectWorldTransforms(rotations, origins);
}

/// Bullet makes room for impulses in the first substep that solves for them; until then none is
/// applied.
void WorldState::serialize_multibody_constraint(btMultiBodyConstraint& constraint) {
    same("rows of a multibody constraint", constraint.getNumRows());
    const auto has_room = [&] {
        return (constraint.*member(MultibodyRows{})).size() >= constraint.getNumRows();
    };
    for (int row = 0; row < constraint.getNumRows() && stream_.good(); ++row) {
        btScalar impulse = has_room() ? constraint.getAppliedImpulse(row) : 0;
        stream_(impulse);
        if (!stream_.reads()) continue;
        if (!has_room()) constraint.finalizeMultiDof();
        if (has_room()) constraint.internalSetAppliedImpulse(row, impulse);
    }
}

/// What changes in a run: motors (a host may command them once), what broke, what was applied.
void WorldState::serialize_constraint(btTypedConstraint& constraint) {
    same("as the type of a constraint", constraint.getConstraintType());
    if (!stream_.good()) return;
    bool enabled = constraint.isEnabled();
    // Bullet reads it only where the constraint is to give feedback or may break.
    const bool reports = constraint.needsFeedback();
    btScalar impulse = reports ? constraint.getAppliedImpulse() : 0;
    stream_(enabled, impulse);
    if (stream_.reads()) {
        constraint.setEnabled(enabled);
        if (reports) constraint.internalSetAppliedImpulse(impulse);
    }
    if (auto* hinge = dynamic_cast<btHingeConstraint*>(&constraint)) {
        bool on = hinge->getEnableAngularMotor();
        btScalar target = hinge->getMotorTargetVelocity(), most = hinge->getMaxMotorImpulse();
        stream_(on, target, most);
        if (stream_.reads()) hinge->enableAngularMotor(on, target, most);
        if (auto* turns = dynamic_cast<btHingeAccumulatedAngleConstraint*>(hinge)) {
            btScalar angle = turns->getAccumulatedHingeAngle();
            stream_(angle);
            if (stream_.reads()) turns->setAccumulatedHingeAngle(angle);
        }
    } else if (auto* cone = dynamic_cast<btConeTwistConstraint*>(&constraint)) {
        bool on = cone->isMotorEnabled(), is_normalized = cone->isMaxMotorImpulseNormalized();
        btScalar most = cone->getMaxMotorImpulse();
        stream_(on, is_normalized, most);
        list(stream_, cone->*member(ConeTwistTarget{}));
        if (!stream_.reads()) return;
        cone->enableMotor(on);
        is_normalized ? cone->setMaxMotorImpulseNormalized(most) : cone->setMaxMotorImpulse(most);
    } else if (auto* slider = dynamic_cast<btSliderConstraint*>(&constraint)) {
        bool linear_on = slider->getPoweredLinMotor(), angular_on = slider->getPoweredAngMotor();
        btScalar values[] = {slider->getTargetLinMotorVelocity(), slider->getMaxLinMotorForce(),
                             slider->getTargetAngMotorVelocity(), slider->getMaxAngMotorForce()};
        stream_(linear_on, angular_on);
        for (btScalar& v : values) stream_(v);
        if (!stream_.reads()) return;
        slider->setPoweredLinMotor(linear_on);
        slider->setPoweredAngMotor(angular_on);
        slider->setTargetLinMotorVelocity(values[0]);
        slider->setMaxLinMotorForce(values[1]);
        slider->setTargetAngMotorVelocity(values[2]);
        slider->setMaxAngMotorForce(values[3]);
    } else if (auto* spring = dynamic_cast<btGeneric6DofSpring2Constraint*>(&constraint)) {
        btTranslationalLimitMotor2& linear = *spring->getTranslationalLimitMotor();
        for (int i = 0; i < 3; ++i) {
            stream_(linear.m_enableMotor[i], linear.m_servoMotor[i]);
            btRotationalLimitMotor2& angular = *spring->getRotationalLimitMotor(i);
            stream_(angular.m_enableMotor, angular.m_servoMotor, angular.m_targetVelocity,
                    angular.m_maxMotorForce, angular.m_servoTarget);
        }
        list(stream_, linear.m_targetVelocity);
        list(stream_, linear.m_maxMotorForce);
        list(stream_, linear.m_servoTarget);
    } else if (auto* six = dynamic_cast<btGeneric6DofConstraint*>(&constraint)) {
        btTranslationalLimitMotor& linear = *six->getTranslationalLimitMotor();
        for (int i = 0; i < 3; ++i) {
            stream_(linear.m_enableMotor[i]);
            btRotationalLimitMotor& angular = *six->getRotationalLimitMotor(i);
            stream_(angular.m_enableMotor, angular.m_targetVelocity, angular.m_maxMotorForce);
        }
        list(stream_, linear.m_targetVelocity);
        list(stream_, linear.m_maxMotorForce);
    }
}

/// All of the wheels but pointers, and what follows from the chassis's pose. What the last ray
/// found is for who reads it before the next one.
void WorldState::serialize_vehicle(btRaycastVehicle& vehicle) {
    same("wheels of a vehicle", vehicle.getNumWheels());
    stream_(vehicle.*member(VehicleSpeed{}));
    for (int i = 0; i < vehicle.getNumWheels() && stream_.good(); ++i) {
        btWheelInfo& wheel = vehicle.getWheelInfo(i);
        list(stream_, wheel.m_chassisConnectionPointCS);
        list(stream_, wheel.m_wheelDirectionCS);
        list(stream_, wheel.m_wheelAxleCS);
        stream_(wheel.m_wheelsRadius, wheel.m_suspensionRestLength1, wheel.m_maxSuspensionTravelCm,
                wheel.m_suspensionStiffness, wheel.m_wheelsDampingCompression,
                wheel.m_wheelsDampingRelaxation, wheel.m_maxSuspensionForce, wheel.m_rollInfluence,
                wheel.m_bIsFrontWheel);
        stream_(wheel.m_rotation, wheel.m_deltaRotation, wheel.m_steering, wheel.m_engineForce,
                wheel.m_brake, wheel.m_frictionSlip);
        btWheelInfo::RaycastInfo& ray = wheel.m_raycastInfo;
        bool is_in_contact = ray.m_isInContact;
        stream_(is_in_contact);
        if (stream_.reads()) {
            ray.m_suspensionLength = wheel.m_suspensionRestLength1;
            wheel.m_wheelsSuspensionForce = 0;
            wheel.m_skidInfo = 1;
        }
        // Without contact Bullet may not have set them yet.
        if (is_in_contact) {
            stream_(ray.m_suspensionLength, wheel.m_wheelsSuspensionForce, wheel.m_skidInfo);
            list(stream_, ray.m_contactPointWS);
            list(stream_, ray.m_contactNormalWS);
        }
        if (!stream_.reads()) continue;
        vehicle.updateWheelTransform(i, false);
        ray.m_isInContact = is_in_contact;
    }
}

void WorldState::serialize() {
    same("bytes of a btScalar", sizeof(btScalar));
    same("collision objects", world_.getNumCollisionObjects());
    same("constraints", world_.getNumConstraints());
    stream_(WorldMembers::local_time_s(world_));
    uint64_t seed = 0;
    auto* solver = dynamic_cast<btSequentialImpulseConstraintSolver*>(world_.getConstraintSolver());
    if (solver) seed = solver->getRandSeed();
    stream_(seed);
    if (solver && stream_.reads()) solver->setRandSeed(static_cast<unsigned long>(seed));

    auto* multibody_world = dynamic_cast<btMultiBodyDynamicsWorld*>(&world_);
    same("multibodies", multibody_world ? multibody_world->getNumMultibodies() : 0);
    same("multibody constraints",
         multibody_world ? multibody_world->getNumMultiBodyConstraints() : 0);
    if (multibody_world && stream_.good()) {
        for (int i = 0; i < multibody_world->getNumMultibodies() && stream_.good(); ++i) {
            serialize_multibody(*multibody_world->getMultiBody(i));
        }
        for (int i = 0; i < multibody_world->getNumMultiBodyConstraints() && stream_.good(); ++i) {
            serialize_multibody_constraint(*multibody_world->getMultiBodyConstraint(i));
        }
    }
    for (int i = 0; i < world_.getNumCollisionObjects() && stream_.good(); ++i) {
        serialize_object(*world_.getCollisionObjectArray()[i]);
    }
    for (int i = 0; i < world_.getNumConstraints() && stream_.good(); ++i) {
        serialize_constraint(*world_.getConstraint(i));
    }
    const std::vector<btRaycastVehicle*> vehicles = vehicles_of(world_);
    same("vehicles", static_cast<int64_t>(vehicles.size()));
    for (size_t i = 0; i < vehicles.size() && stream_.good(); ++i) serialize_vehicle(*vehicles[i]);
    if (stream_.good()) serialize_contacts(stream_, world_);
}

}  // namespace

Status check_world(btDiscreteDynamicsWorld& world, std::span<SoilAction* const> soils) {
    const auto& actions = WorldMembers::actions(world);
    size_t found = 0;
    for (int i = 0; i < actions.size(); ++i) {
        auto* soil = dynamic_cast<SoilAction*>(actions[i]);
        if (!soil) continue;
        if (std::count(soils.begin(), soils.end(), soil) != 1) {
            return Error{"the world has a soil that is not given, or given twice; give each once"};
        }
        ++found;
    }
    if (found != soils.size()) {
        return Error{"a soil that is given is not in the world; leave it out"};
    }
    for (int i = 0; i < world.getNumCollisionObjects(); ++i) {
        const int type = world.getCollisionObjectArray()[i]->getInternalType();
        if (type == btCollisionObject::CO_SOFT_BODY || type == btCollisionObject::CO_HF_FLUID) {
            return Error{"object " + std::to_string(i) +
                         " is a soft body or a fluid, whose state is not saved; take it out first"};
        }
    }
    return check_contacts(world);
}

Result<std::vector<uint8_t>> world_state(btDiscreteDynamicsWorld& world) {
    StateStream stream;
    WorldState(stream, world).serialize();
    if (!stream.good()) {
        return Error{"a pose, velocity or force in the world is not finite; take that body out"};
    }
    return stream.bytes();
}

Status set_world_state(btDiscreteDynamicsWorld& world, std::span<const uint8_t> state) {
    StateStream before;
    before.accept_non_finite();  // a world that has blown up may be put back, too
    WorldState(before, world).serialize();
    StateStream stream(state);
    WorldState target(stream, world);
    target.serialize();
    if (stream.at_end()) return Done{};
    StateStream back(before.bytes());
    back.accept_non_finite();
    WorldState(back, world).serialize();
    return Error{target.mismatch().empty() ? std::string("is damaged") + kTakeAnotherCopy
                                           : target.mismatch()};
}

}  // namespace bsoil::bullet
