#include "vehicle_wheels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bullet_types.h"
#include "coupling_def.h"

namespace bsoil::bullet {
namespace {

double slip_of(double rim_m_s, double speed_m_s) {
    const double larger =
        std::max({std::abs(rim_m_s), std::abs(speed_m_s), kCoupling.slip_speed_m_s});
    const double direction = std::abs(rim_m_s) >= std::abs(speed_m_s) ? rim_m_s : speed_m_s;
    return std::clamp(std::copysign(1.0, direction) * (rim_m_s - speed_m_s) / larger, -1.0, 1.0);
}

/// The largest force along `up` that the patches can give.
double bearing_of(std::span<const ContactPatch> patches, Vec3 up) {
    double bearing_n = 0;
    for (const ContactPatch& p : patches) {
        bearing_n += p.normal_limit_n * std::max(0.0, -dot(p.normal, up));
    }
    return bearing_n;
}

/// An engine force or a brake [N, N s] that does nothing, as the vehicle has it for a substep.
/// Ours: the smallest number, which any substep below half a second takes to 0, and which no host
/// sets. So 0 is what the host has set meanwhile. Larger: it would drive.
constexpr btScalar kNothing = std::numeric_limits<btScalar>::denorm_min();

/// The nearest rigid body on the ray other than the soil's surface, as btDefaultVehicleRaycaster
/// answers.
struct RigidRay final : btCollisionWorld::ClosestRayResultCallback {
    using ClosestRayResultCallback::ClosestRayResultCallback;
    const btCollisionObject* ground = nullptr;
    bool needsCollision(btBroadphaseProxy* proxy) const override {
        return proxy->m_clientObject != ground && ClosestRayResultCallback::needsCollision(proxy);
    }
};

}  // namespace

/// The wheel whose ray this is; -1: none of ours.
int VehicleWheels::find(const btVector3& from, const btVector3& to) const {
    for (size_t i = 0; i < wheels_.size(); ++i) {
        const int index = static_cast<int>(i);
        if (wheels_[i].is_pending || index >= vehicle_->getNumWheels()) continue;
        const auto& ray = vehicle_->getWheelInfo(index).m_raycastInfo;
        if (ray.m_hardPointWS == from && ray.m_contactPointWS == to) return index;
    }
    return -1;
}

WheelState VehicleWheels::state_of(const Wheel& wheel, const btWheelInfo& info,
                                   double substep_s) const {
    const btRigidBody& chassis = *vehicle_->getRigidBody();
    const auto number = [](btScalar v) { return static_cast<double>(v); };
    WheelState state;
    state.up = wheel.up;
    state.forward = wheel.forward;
    state.axle = wheel.axle;
    state.radius_m = number(info.m_wheelsRadius);
    state.mass_kg = wheel.def.mass_kg;
    state.spin_rad_s = wheel.spin_rad_s;
    state.rise_m_s = wheel.rise_m_s;

    const Vec3 hard_point = from_bullet(info.m_raycastInfo.m_hardPointWS);
    const btVector3 center = chassis.getCenterOfMassPosition();
    const Vec3 velocity = from_bullet(chassis.getVelocityInLocalPoint(
        to_bullet(hard_point - wheel.length_m * wheel.up) - center));
    const double chassis_rise_m_s = dot(velocity, wheel.up);
    const double rest_m = number(info.getSuspensionRestLength());
    state.length_most_m = rest_m;
    state.length_least_m = std::min(rest_m, rest_m - 0.01 * number(info.m_maxSuspensionTravelCm));
    state.length_m = wheel.length_m + substep_s * chassis_rise_m_s;
    const double chassis_kg = 1 / number(chassis.getInvMass());
    // btRaycastVehicle::updateSuspension, with a contact normal along the strut.
    const double damping = number(chassis_rise_m_s < 0 ? info.m_wheelsDampingCompression
                                                       : info.m_wheelsDampingRelaxation);
    state.strut_stiffness_n_m = chassis_kg * number(info.m_suspensionStiffness);
    state.strut_n = state.strut_stiffness_n_m * (rest_m - state.length_m) -
                    chassis_kg * damping * chassis_rise_m_s;
    state.strut_limit_n = number(info.m_maxSuspensionForce);

    const btVector3 point = to_bullet(
        hard_point -
        (std::clamp(state.length_m, state.length_least_m, rest_m) + state.radius_m) * wheel.up);
    const auto share_kg = [&](Vec3 direction) {
        return 1 / (number(chassis.computeImpulseDenominator(point, to_bullet(direction))) *
                    vehicle_->getNumWheels());
    };
    state.forward_mass_kg = share_kg(wheel.forward);
    state.side_mass_kg = share_kg(wheel.axle);
    // Rows take out the speed that the chassis will have in the next substep, if gravity and the
    // wheels go on as they did; what they start with themselves they put in again.
    const Vec3 own_n_s = substep_s * share_of_last_n(wheel);
    state.chassis_velocity_m_s =
        velocity +
        substep_s * (from_bullet(chassis.getGravity()) + across_struts_n_ * (1 / chassis_kg)) -
        dot(own_n_s, wheel.forward) / state.forward_mass_kg * wheel.forward -
        dot(own_n_s, wheel.axle) / state.side_mass_kg * wheel.axle;
    state.engine_force_n = number(info.m_engineForce);
    state.engine_spin_rad_s = wheel.def.rim_speed_max_m_s / state.radius_m;
    state.brake_n_s = number(info.m_brake);
    return state;
}

void VehicleWheels::solve(Wheel& wheel, const btWheelInfo& info, double substep_s) {
    const WheelState state = state_of(wheel, info, substep_s);
    const auto vehicles = soil_.lock();
    vehicles->coupling().follow_wheel(wheel.id,
                                      wheel.motion.center_of_mass_m - wheel.contact_center_m);
    WheelContact contact;
    contact.patches = vehicles->coupling().wheel_patches(wheel.id);
    contact.center_m = wheel.contact_center_m;
    const double bearing_n = bearing_of(contact.patches, wheel.up);
    if (bearing_n > 0) {
        contact.stiffness_n_m =
            bearing_n / (kCoupling.wheel_stiffening_voxels * vehicles->voxel_m());
    }
    contact.last_force_n = wheel.forces.normal_n * wheel.up + share_of_last_n(wheel);
    wheel.forces = solve_wheel(state, contact, substep_s, wheel.patch_normal_n);
    vehicles->coupling().set_wheel_forces(wheel.id, wheel.patch_normal_n);
    wheel.spin_rad_s = wheel.forces.spin_rad_s;
    double length_m = state.length_m - substep_s * wheel.forces.rise_m_s;
    // A strut pushes its wheel into soil no faster than the wheel of a rigid machine falls: what
    // the soil bears is known only after its next step, and a light wheel would be deep in it by
    // then.
    const double gravity_m_s2 = vehicles->coupling().soil().gravity_m_s2;
    const double fall_m = substep_s * (gravity_m_s2 * substep_s - std::min(0.0, state.rise_m_s));
    double most_m = state.length_m + fall_m;
    if (contact.patches.empty() && length_m > most_m) {
        most_m = std::max(most_m, touching_length_m(wheel, info));
    }
    // What does not speed up the wheel does not hold up the chassis. A wheel in the air does not
    // either: its mass is in the chassis, so that it has no momentum to give.
    if (!(wheel.forces.normal_n > 0)) {
        wheel.strut_most_n = 0;
    } else if (length_m > most_m) {
        wheel.strut_most_n = wheel.forces.normal_n + state.mass_kg * gravity_m_s2;
    } else if (wheel.forces.is_at_end) {
        wheel.strut_most_n = wheel.forces.strut_n;
    } else {
        wheel.strut_most_n = WheelMemory::kNoLimitN;
    }
    length_m = std::min(length_m, most_m);
    // What the soil has not seen yet it bears as rigid ground: it may see the wheel late.
    if (contact.patches.empty() && vehicles->coupling().is_late()) {
        if (const double on_soil_m = touching_length_m(wheel, info); length_m > on_soil_m) {
            length_m = on_soil_m;
            wheel.strut_most_n = WheelMemory::kNoLimitN;
        }
    }
    wheel.length_m = std::clamp(length_m, state.length_least_m, state.length_most_m);
    wheel.rise_m_s = (state.length_m - wheel.length_m) / substep_s;
    wheel.is_on_soil =
        wheel.forces.normal_n > 0 || wheel.length_m < state.length_most_m - kCoupling.strut_end_m;
}

/// Whether the vehicle's host has put it elsewhere since the last substep: what the soil did to the
/// wheel there does not go with it.
bool VehicleWheels::is_put_elsewhere(const Wheel& wheel, const btVector3& from,
                                     double substep_s) const {
    if (!wheel.is_placed) return false;
    const btRigidBody& chassis = *vehicle_->getRigidBody();
    const Vec3 center = from_bullet(from) - wheel.length_m * wheel.up;
    const Vec3 velocity = from_bullet(
        chassis.getVelocityInLocalPoint(to_bullet(center) - chassis.getCenterOfMassPosition()));
    const double speed_m_s = std::max(length(velocity), length(wheel.motion.linear_velocity_m_s)) +
                             std::abs(wheel.rise_m_s);
    const double slack_m = kCoupling.put_elsewhere_voxels * soil_.lock()->voxel_m();
    return length(center - wheel.motion.center_of_mass_m) > slack_m + substep_s * speed_m_s;
}

/// A wheel that is new stands on the soil, if it reaches it: with its strut at full length it might
/// start deep in it.
void VehicleWheels::put_down(Wheel& wheel, const btWheelInfo& info) const {
    const auto rest_m = static_cast<double>(info.getSuspensionRestLength());
    const double travel_m = 0.01 * static_cast<double>(info.m_maxSuspensionTravelCm);
    wheel.is_placed = true;
    wheel.length_m =
        std::clamp(touching_length_m(wheel, info), std::min(rest_m, rest_m - travel_m), rest_m);
}

/// Length of the strut at which the wheel would touch the soil's surface.
double VehicleWheels::touching_length_m(const Wheel& wheel, const btWheelInfo& info) const {
    const Vec3 hard_point = from_bullet(info.m_raycastInfo.m_hardPointWS);
    const double reach_m =
        static_cast<double>(info.getSuspensionRestLength() + info.m_wheelsRadius);
    const Vec3 lowest = hard_point - reach_m * wheel.up;
    const auto surface = soil_.lock()->surface_at(lowest);
    if (!surface) return HUGE_VAL;
    const double deep_m = dot(surface->position_m - lowest, surface->normal) /
                          std::max(0.1, dot(wheel.up, surface->normal));
    return reach_m - deep_m - static_cast<double>(info.m_wheelsRadius);
}

/// Until the soil has seen it a wheel stays at its height.
void VehicleWheels::hold(Wheel& wheel, const btWheelInfo& info, double substep_s) const {
    const WheelState state = state_of(wheel, info, substep_s);
    wheel.length_m = std::clamp(state.length_m, state.length_least_m, state.length_most_m);
    wheel.forces = {};
    wheel.is_on_soil = false;
}

/// A chassis that sleeps stands as it stood and its wheels with it, until the soil below is dug
/// away. With the speeds that it fell asleep with, they would turn, and keep the soil awake.
void VehicleWheels::rest(Wheel& wheel) const {
    wheel.rise_m_s = wheel.spin_rad_s = 0;
    const auto patches = soil_.lock()->coupling().wheel_patches(wheel.id);
    if (bearing_of(patches, wheel.up) < kCoupling.wheel_wake_share * wheel.forces.normal_n) {
        vehicle_->getRigidBody()->activate();
    }
}

/// Where the wheel is now, for the soil.
void VehicleWheels::place(Wheel& wheel, const btVector3& from, double length_m, double substep_s) {
    const btRigidBody& chassis = *vehicle_->getRigidBody();
    const Vec3 center = from_bullet(from) - length_m * wheel.up;
    Vec3 velocity = from_bullet(
        chassis.getVelocityInLocalPoint(to_bullet(center) - chassis.getCenterOfMassPosition()));
    velocity += (wheel.rise_m_s - dot(velocity, wheel.up)) * wheel.up;
    Vec3 turning = from_bullet(chassis.getAngularVelocity());
    turning += (-wheel.spin_rad_s - dot(turning, wheel.axle)) * wheel.axle;
    if (!chassis.isActive()) velocity = turning = {};  // Bullet clears its own a step later
    // Without its spin, which a cylinder does not show: patches stay where they are.
    wheel.motion.pose = {center, rotation_of(wheel.forward, wheel.up, wheel.axle)};
    wheel.motion.center_of_mass_m = center;
    wheel.motion.linear_velocity_m_s = velocity;
    wheel.motion.angular_velocity_rad_s = turning;
    wheel.substep_s = substep_s;
    wheel.was_cast = true;
}

void VehicleWheels::stand_on_rigid(Wheel& wheel, const btWheelInfo& info, double length_m,
                                   double substep_s) {
    const btRigidBody& chassis = *vehicle_->getRigidBody();
    const Vec3 velocity = from_bullet(chassis.getVelocityInLocalPoint(
        info.m_raycastInfo.m_hardPointWS - chassis.getCenterOfMassPosition()));
    const auto rest_m = static_cast<double>(info.getSuspensionRestLength());
    const double travel_m = 0.01 * static_cast<double>(info.m_maxSuspensionTravelCm);
    length_m = std::clamp(length_m, rest_m - travel_m, rest_m);
    wheel.rise_m_s = dot(velocity, wheel.up) - (length_m - wheel.length_m) / substep_s;
    wheel.length_m = length_m;
    wheel.spin_rad_s = dot(velocity, wheel.forward) / static_cast<double>(info.m_wheelsRadius);
    wheel.is_on_soil = false;
    wheel.forces = {};
    wheel.patch_normal_n.clear();
    soil_.lock()->coupling().set_wheel_forces(wheel.id, {});
}

void* VehicleWheels::cast(const btVector3& from, const btVector3& to,
                          btVehicleRaycaster::btVehicleRaycasterResult& result) {
    if (was_asked_) {
        was_asked_ = true;
        return nullptr;
    }
    const auto vehicles = soil_.lock();
    RigidRay ray(from, to);
    if (vehicles) ray.ground = vehicles->ground();
    if (!world_) return nullptr;
    world_->rayTest(from, to, ray);
    const btRigidBody* rigid = ray.hasHit() ? btRigidBody::upcast(ray.m_collisionObject) : nullptr;
    if (rigid && !rigid->hasContactResponse()) rigid = nullptr;
    const auto answer_rigid = [&]() -> void* {
        if (!rigid) return nullptr;
        result.m_hitPointInWorld = ray.m_hitPointWorld;
        result.m_hitNormalInWorld = ray.m_hitNormalWorld.normalized();
        result.m_distFraction = ray.m_closestHitFraction;
        return const_cast<btRigidBody*>(rigid);
    };

    const auto substep_s = static_cast<double>(world_->getSolverInfo().m_timeStep);
    const bool may_answer = vehicles && vehicles->is_in_substep() && vehicle_ && !has_left();
    const int index = may_answer ? find(from, to) : -1;
    if (index < 0 || !(substep_s > 0) || vehicle_->getRigidBody()->isStaticOrKinematicObject()) {
        return answer_rigid();
    }
    Wheel& wheel = wheels_[index];
    btWheelInfo& info = vehicle_->getWheelInfo(index);

    // Forward as btRaycastVehicle::updateFriction has it.
    wheel.up = -from_bullet(info.m_raycastInfo.m_wheelDirectionWS);
    const Vec3 axle =
        from_bullet(info.m_raycastInfo.m_wheelAxleWS.rotate(to_bullet(wheel.up), info.m_steering));
    const Vec3 across = axle - dot(axle, wheel.up) * wheel.up;
    if (!is_finite(wheel.up) || !is_finite(across) || !(length(across) > 1e-3)) {
        return answer_rigid();
    }
    wheel.axle = across * (1 / length(across));
    wheel.forward = cross(wheel.up, wheel.axle);

    const auto radius_m = static_cast<double>(info.m_wheelsRadius);
    const auto ray_m = static_cast<double>((to - from).length());
    if (is_put_elsewhere(wheel, from, substep_s)) wheel.is_placed = wheel.has_met_soil = false;
    if (!wheel.is_placed) put_down(wheel, info);
    const bool is_awake = vehicle_->getRigidBody()->isActive();
    const double length_before_m = wheel.length_m;
    if (!wheel.has_met_soil) {
        hold(wheel, info, substep_s);
    } else if (is_awake) {
        solve(wheel, info, substep_s);
    } else {
        rest(wheel);
    }
    const double rigid_m =
        rigid ? static_cast<double>(ray.m_closestHitFraction) * ray_m - radius_m : HUGE_VAL;
    if (rigid_m <= wheel.length_m) {
        wheel.length_m = length_before_m;
        stand_on_rigid(wheel, info, rigid_m, substep_s);
    }
    place(wheel, from, wheel.length_m, substep_s);
    wheel.is_pending = true;
    wheel.rotation_before = info.m_rotation;
    if (rigid_m <= wheel.length_m) return answer_rigid();
    if (!wheel.is_on_soil) return nullptr;

    lend(wheel, info);
    const double hit_m = wheel.length_m + radius_m;
    wheel.contact_point_m = from_bullet(from) - hit_m * wheel.up;
    result.m_hitPointInWorld = to_bullet(wheel.contact_point_m);
    result.m_hitNormalInWorld = to_bullet(wheel.up);
    result.m_distFraction = static_cast<btScalar>(hit_m / ray_m);
    return &ground_;
}

/// The vehicle's own friction and engine rest for this substep; its suspension gives the chassis no
/// more than the soil gives the wheel.
void VehicleWheels::lend(Wheel& wheel, btWheelInfo& info) {
    Lent& lent = wheel.lent;
    lent.engine_force = info.m_engineForce;
    lent.brake = info.m_brake;
    lent.friction_slip = info.m_frictionSlip;
    lent.force_most = info.m_maxSuspensionForce;
    info.m_engineForce = info.m_brake = kNothing;
    info.m_frictionSlip = 0;
    if (wheel.strut_most_n < static_cast<double>(info.m_maxSuspensionForce)) {
        info.m_maxSuspensionForce = static_cast<btScalar>(std::max(0.0, wheel.strut_most_n));
    }
    lent.force_most_given = info.m_maxSuspensionForce;
}

/// What the host has set meanwhile stays.
void VehicleWheels::give_back(const Wheel& wheel, btWheelInfo& info) {
    const Lent& lent = wheel.lent;
    const auto back = [](btScalar& field, btScalar given, btScalar own) {
        if (field == given) field = own;
    };
    back(info.m_engineForce, kNothing, lent.engine_force);
    back(info.m_brake, kNothing, lent.brake);
    back(info.m_frictionSlip, 0, lent.friction_slip);
    back(info.m_maxSuspensionForce, lent.force_most_given, lent.force_most);
}

/// By load, not what the wheel itself gave: wheels that work against each other do not move the
/// chassis, and would do so for ever.
Vec3 VehicleWheels::share_of_last_n(const Wheel& wheel) const {
    if (!(normal_n_ > 0)) return {};
    const Vec3 share_n = wheel.forces.normal_n / normal_n_ * across_struts_n_;
    return share_n - dot(share_n, wheel.up) * wheel.up;
}

void VehicleWheels::push_chassis(const Wheel& wheel, const btWheelInfo& info) {
    btRigidBody& chassis = *vehicle_->getRigidBody();
    if (!chassis.isActive()) return;
    const Vec3 arm = wheel.contact_point_m - from_bullet(chassis.getCenterOfMassPosition());
    across_struts_n_ += wheel.forces.forward_n * wheel.forward + wheel.forces.side_n * wheel.axle;
    normal_n_ += wheel.forces.normal_n;
    const Vec3 forward_n_s = wheel.substep_s * wheel.forces.forward_n * wheel.forward;
    const Vec3 side_n_s = wheel.substep_s * wheel.forces.side_n * wheel.axle;
    chassis.applyImpulse(to_bullet(forward_n_s), to_bullet(arm));
    // btWheelInfo::m_rollInfluence, as btRaycastVehicle has it.
    const Vec3 chassis_up =
        from_bullet(chassis.getCenterOfMassTransform().getBasis().getColumn(vehicle_->getUpAxis()));
    const double raised = 1 - static_cast<double>(info.m_rollInfluence);
    chassis.applyImpulse(to_bullet(side_n_s),
                         to_bullet(arm - raised * dot(chassis_up, arm) * chassis_up));
}

void VehicleWheels::close_substep() {
    const bool is_pending = std::any_of(wheels_.begin(), wheels_.end(),
                                        [](const Wheel& wheel) { return wheel.is_pending; });
    if (!is_pending) return;
    if (has_left()) {
        for (Wheel& wheel : wheels_) wheel.is_pending = false;
        return;
    }
    const auto vehicles = soil_.lock();
    across_struts_n_ = {};
    normal_n_ = 0;
    for (size_t i = 0; i < wheels_.size(); ++i) {
        Wheel& wheel = wheels_[i];
        if (!wheel.is_pending) continue;
        wheel.is_pending = false;
        btWheelInfo& info = vehicle_->getWheelInfo(static_cast<int>(i));
        const auto radius_m = static_cast<double>(info.m_wheelsRadius);
        if (wheel.is_on_soil) {
            give_back(wheel, info);
            info.m_wheelsSuspensionForce =
                std::min(info.m_wheelsSuspensionForce,
                         static_cast<btScalar>(std::max(0.0, wheel.strut_most_n)));
            push_chassis(wheel, info);
        }
        const double rim_m_s = wheel.spin_rad_s * radius_m;
        const double speed_m_s = dot(wheel.motion.linear_velocity_m_s, wheel.forward);
        wheel.report = {.is_on_soil = wheel.is_on_soil && wheel.forces.normal_n > 0,
                        .normal_force_n = wheel.forces.normal_n,
                        .traction_n = wheel.forces.forward_n,
                        .side_force_n = wheel.forces.side_n,
                        .torque_n_m = wheel.forces.torque_n_m,
                        .sinkage_m = vehicles ? vehicles->coupling().report(wheel.id).sinkage_m : 0,
                        .spin_rad_s = wheel.spin_rad_s,
                        .slip = slip_of(rim_m_s, speed_m_s)};
        if (!info.m_raycastInfo.m_isInContact || wheel.is_on_soil) {
            info.m_deltaRotation = static_cast<btScalar>(wheel.spin_rad_s * wheel.substep_s);
            info.m_rotation = wheel.rotation_before + info.m_deltaRotation;
        }
        if (wheel.report.is_on_soil) {
            info.m_skidInfo = static_cast<btScalar>(1 - std::abs(wheel.report.slip));
        }
    }
}

void VehicleWheels::show(BodyCollector& collector) {
    const Aabb& grid = collector.grid();
    for (Wheel& wheel : wheels_) {
        wheel.was_shown = false;
        if (!wheel.was_cast) continue;
        wheel.was_cast = false;
        const ConvexShape& shape = wheel.shapes->front();
        const double reach_m = std::hypot(shape.radius_m, shape.half_height_m);
        const Vec3 at = wheel.motion.pose.position;
        const bool is_in_grid = is_rigid(wheel.motion.pose) && at.x + reach_m >= grid.min.x &&
                                at.y + reach_m >= grid.min.y && at.z + reach_m >= grid.min.z &&
                                at.x - reach_m <= grid.max.x && at.y - reach_m <= grid.max.y &&
                                at.z - reach_m <= grid.max.z;
        // One that has just left is shown once more, as any body is.
        wheel.was_shown = is_in_grid || wheel.was_in_grid;
        wheel.was_in_grid = is_in_grid;
        if (!wheel.was_shown) continue;
        GuestBody guest;
        guest.state.id = wheel.id;
        guest.state.role = BodyRole::wheel;
        guest.state.motion = wheel.motion;
        // Placed while its chassis was still awake, perhaps: its speed would wake what lies on the
        // soil that it carries, be it the chassis itself.
        if (!vehicle_->getRigidBody()->isActive()) {
            guest.state.motion.linear_velocity_m_s = guest.state.motion.angular_velocity_rad_s = {};
        }
        guest.state.surface = wheel.def.surface;
        guest.shapes = wheel.shapes;
        collector.add_guest(std::move(guest));
    }
}

void VehicleWheels::take_contacts(bool fresh) {
    for (Wheel& wheel : wheels_) {
        if (!wheel.is_placed) continue;
        wheel.has_met_soil = true;
        if (!wheel.was_shown) continue;
        wheel.contact_center_m = fresh ? wheel.motion.center_of_mass_m : wheel.stepped_center_m;
    }
}

}  // namespace bsoil::bullet
