#include "levers.h"

#include <algorithm>
#include <cmath>

#include "world/motion.h"

namespace bsoil::viewer {
namespace {

constexpr double kTurnSpeed = 0.6, kSlideSpeed = 0.3, kWheelSpeed = 4.0;  ///< rad/s, m/s, rad/s
constexpr double kMotionSampleS = 0.05, kMotionSpanS = 120;

/// The fastest that a motion drives its joint, either way [rad/s or m/s]; 0: none does.
double fastest(const scene::MotionItem& item) {
    const scene::Motion motion(item);
    double most = 0, before = motion.value(0);
    const double end_s =
        std::min(kMotionSpanS, item.motion_keys.empty() ? 0.0 : item.motion_keys.back().t_s + 1.0);
    for (double t = kMotionSampleS; t < end_s; t += kMotionSampleS) {
        const double value = motion.value(t);
        const bool is_speed = motion.quantity() == scene::Motion::Quantity::velocity;
        most =
            std::max(most, is_speed ? std::abs(value) : std::abs(value - before) / kMotionSampleS);
        before = value;
    }
    return most;
}

/// What turns without end about a level axis.
bool is_wheel(const scene::JointItem& joint, Vec3 up) {
    if (joint.kind != "hinge" && joint.kind != "suspension") return false;
    if (joint.lower_rad || joint.upper_rad) return false;
    return std::abs(dot(joint.axis, up)) < 0.3 * length(joint.axis);
}

}  // namespace

std::vector<Lever> find_levers(const scene::Scene& scene) {
    std::vector<Lever> levers;
    const Vec3 up = scene.world.up == "y" ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    Vec3 middle;
    std::vector<size_t> wheels;
    for (size_t j = 0; j < scene.joints.size(); ++j) {
        const scene::JointItem& joint = scene.joints[j];
        if (joint.motor_torque_n_m <= 0 && joint.motor_force_n <= 0) continue;
        Lever lever;
        lever.name = joint.name;
        lever.joint = static_cast<int>(j);
        lever.slides = joint.kind == "slider";
        double speed = 0;
        for (const scene::MotionItem& motion : scene.motions) {
            if (motion.joint == joint.name) speed = std::max(speed, fastest(motion));
        }
        const bool rolls = is_wheel(joint, up);
        if (speed <= 0) speed = lever.slides ? kSlideSpeed : rolls ? kWheelSpeed : kTurnSpeed;
        if (joint.max_velocity) speed = std::min(speed, *joint.max_velocity);
        lever.speed = speed;
        if (rolls) {
            wheels.push_back(levers.size());
            middle += joint.point_m;
        }
        levers.push_back(lever);
    }
    if (wheels.size() < 2) return levers;
    middle = middle * (1.0 / static_cast<double>(wheels.size()));
    // A wheel that turns about `axis` rolls along axis x up. The first one says where forward is.
    const auto axis_of = [&](size_t w) {
        return scene.joints[static_cast<size_t>(levers[w].joint)].axis;
    };
    const Vec3 forward = cross(axis_of(wheels[0]), up);
    const Vec3 left = cross(up, forward);
    for (const size_t w : wheels) {
        const Vec3 rolls = cross(axis_of(w), up);
        if (std::abs(dot(rolls, forward)) < 0.7 * length(rolls) * length(forward)) continue;
        levers[w].forward = dot(rolls, forward) > 0 ? 1 : -1;
        const double aside =
            dot(scene.joints[static_cast<size_t>(levers[w].joint)].point_m - middle, left);
        levers[w].side = aside > 0.02 ? 1 : aside < -0.02 ? -1 : 0;
    }
    return levers;
}

double wheel_speed(const Lever& wheel, double throttle, double steering) {
    const double share = std::clamp(throttle - wheel.side * steering, -1.0, 1.0);
    return wheel.forward * wheel.speed * share;
}

}  // namespace bsoil::viewer
