#include "run/raycast_vehicle.h"

#include <algorithm>

#include "robots/bullet_vectors.h"

namespace bsoil::scene {
namespace {

/// The chassis's axes as Bullet's vehicle counts them.
struct VehicleAxes {
    int right = 1, up = 2;
    btVector3 down{0, 0, -1}, axle{0, -1, 0};  ///< forward x up
};

VehicleAxes axes_of(const RaycastVehicleItem& item) {
    if (item.is_y_up) return {2, 1, btVector3(0, -1, 0), btVector3(0, 0, 1)};
    return {};
}

}  // namespace

RaycastVehicle::RaycastVehicle(const RaycastVehicleItem& item, BulletScene& scene)
    : item_(item), world_(scene.world()) {
    std::vector<double> t_s, throttle, steering, brake;
    for (const RaycastKey& key : item.drive_keys) {
        t_s.push_back(key.t_s);
        throttle.push_back(key.throttle);
        steering.push_back(key.steering);
        brake.push_back(key.brake);
    }
    if (t_s.empty()) return;
    throttle_.emplace(t_s, throttle, Curve::Interpolation::linear);
    steering_.emplace(t_s, steering, Curve::Interpolation::linear);
    brake_.emplace(t_s, brake, Curve::Interpolation::linear);
}

Result<std::unique_ptr<RaycastVehicle>> RaycastVehicle::create(const RaycastVehicleItem& item,
                                                               BulletScene& scene,
                                                               bullet::SoilAction* soil) {
    std::unique_ptr<RaycastVehicle> made(new RaycastVehicle(item, scene));
    const SceneBody& chassis = *scene.find_body(item.chassis);
    if (soil) {
        auto caster = std::make_unique<bullet::SoilRaycaster>(*soil);
        made->on_soil_ = caster.get();
        made->raycaster_ = std::move(caster);
    } else {
        made->raycaster_ = std::make_unique<btDefaultVehicleRaycaster>(&made->world_);
    }
    btRaycastVehicle::btVehicleTuning tuning;
    tuning.m_suspensionStiffness = scalar(item.stiffness_1_s2);
    tuning.m_suspensionCompression = scalar(item.damping_down_1_s);
    tuning.m_suspensionDamping = scalar(item.damping_up_1_s);
    tuning.m_maxSuspensionTravelCm = scalar(100 * item.travel_m);
    tuning.m_maxSuspensionForce = scalar(item.strut_force_n);
    tuning.m_frictionSlip = scalar(item.friction_slip);
    made->vehicle_ =
        std::make_unique<btRaycastVehicle>(tuning, chassis.body, made->raycaster_.get());
    const VehicleAxes axes = axes_of(item);
    made->vehicle_->setCoordinateSystem(axes.right, axes.up, 0);
    std::vector<bullet::SoilWheelDef> wheels;
    for (const RaycastWheelItem& wheel : item.wheels) {
        const btVector3 center = to_bullet(wheel.position_m - chassis.frame_to_center.position);
        btWheelInfo& info = made->vehicle_->addWheel(
            center - axes.down * scalar(item.rest_length_m), axes.down, axes.axle,
            scalar(item.rest_length_m), scalar(wheel.radius_m), tuning, wheel.is_steered);
        info.m_rollInfluence = scalar(item.roll_influence);
        made->wheels_.push_back(scene.find_body(item.name + '/' + wheel.name)->body);
        wheels.push_back({wheel.width_m,
                          wheel.mass_kg,
                          item.max_speed_m_s,
                          {item.tool_friction.value_or(-1), item.tool_adhesion_pa.value_or(-1)}});
    }
    chassis.body->setActivationState(DISABLE_DEACTIVATION);
    made->world_.addVehicle(made->vehicle_.get());
    if (soil) {
        auto& caster = static_cast<bullet::SoilRaycaster&>(*made->raycaster_);
        if (const Status attached = caster.attach(*made->vehicle_, wheels); !attached) {
            return Error{attached.error()};
        }
    }
    return made;
}

RaycastVehicle::~RaycastVehicle() { world_.removeVehicle(vehicle_.get()); }

DriveCommand RaycastVehicle::drive_at(double time_s) const {
    if (command_) return *command_;
    if (!throttle_) return {};
    return {throttle_->value(time_s), steering_->value(time_s), brake_->value(time_s)};
}

// Bullet's brake is an impulse a substep.
void RaycastVehicle::begin_substep(double time_s, double substep_s) {
    const DriveCommand drive = drive_at(time_s);
    const auto driven =
        std::ranges::count_if(item_.wheels, [](const RaycastWheelItem& w) { return w.is_driven; });
    const double engine_n =
        drive.throttle * item_.engine_force_n / static_cast<double>(std::max<ptrdiff_t>(1, driven));
    const double brake_n_s =
        drive.brake * item_.brake_force_n * substep_s / static_cast<double>(item_.wheels.size());
    for (size_t w = 0; w < item_.wheels.size(); ++w) {
        const RaycastWheelItem& wheel = item_.wheels[w];
        const int i = static_cast<int>(w);
        vehicle_->applyEngineForce(scalar(wheel.is_driven ? engine_n : 0), i);
        vehicle_->setBrake(scalar(brake_n_s), i);
        if (wheel.is_steered) {
            vehicle_->setSteeringValue(scalar(drive.steering * item_.steering_rad), i);
        }
    }
}

void RaycastVehicle::place_wheels() {
    for (size_t w = 0; w < wheels_.size(); ++w) {
        vehicle_->updateWheelTransform(static_cast<int>(w), false);
        const btTransform& pose = vehicle_->getWheelInfo(static_cast<int>(w)).m_worldTransform;
        wheels_[w]->setWorldTransform(pose);
        wheels_[w]->getMotionState()->setWorldTransform(pose);
    }
}

std::optional<int> RaycastVehicle::wheel_of(const btCollisionObject* body) const {
    const auto found = std::ranges::find(wheels_, body);
    if (found == wheels_.end()) return std::nullopt;
    return static_cast<int>(found - wheels_.begin());
}

// Axes as SoilWheelReport has them: the strut, forward and the axle as it is steered, square to it.
bullet::BodyReport RaycastVehicle::wheel_report(int wheel) const {
    bullet::BodyReport out;
    if (!on_soil_) return out;
    const bullet::SoilWheelReport report = on_soil_->wheel_report(wheel);
    out.sinkage_m = report.sinkage_m;
    if (!report.is_on_soil) return out;
    const btWheelInfo& info = vehicle_->getWheelInfo(wheel);
    const Vec3 strut = -from_bullet(info.m_raycastInfo.m_wheelDirectionWS);
    const Vec3 steered =
        from_bullet(info.m_raycastInfo.m_wheelAxleWS.rotate(to_bullet(strut), info.m_steering));
    const Vec3 across = steered - dot(steered, strut) * strut;
    const Vec3 axle = across * (1 / length(across));
    out.force_n = report.normal_force_n * strut + report.traction_n * cross(strut, axle) +
                  report.side_force_n * axle;
    out.torque_n_m = -report.torque_n_m * axle;
    out.peak_force_n = length(out.force_n);
    return out;
}

}  // namespace bsoil::scene
