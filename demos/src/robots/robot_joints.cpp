#include <algorithm>
#include <cmath>
#include <set>

#include "robot_builder.h"
#include "scene/rotations.h"

namespace bsoil::scene {

Status RobotBuilder::check_joint(const urdf::Joint& joint) {
    const Pose origin = to_pose(joint.parent_to_joint_origin_transform);
    if (!is_finite(origin) || length(origin.position) > kLargestLength) {
        return error("joint \"{}\": its origin is ({}, {}, {}), must be finite", joint.name,
                     origin.position.x, origin.position.y, origin.position.z);
    }
    if (joint.type == urdf::Joint::FIXED || joint.type == urdf::Joint::FLOATING) return Done{};
    if (joint.type == urdf::Joint::UNKNOWN) {
        return error("joint \"{}\": its type must be one that URDF knows", joint.name);
    }
    const Vec3 axis = to_vec3(joint.axis);
    if (!is_finite(axis) || length(axis) < 1e-6) {
        return error("joint \"{}\": the axis must have a length", joint.name);
    }
    if (joint.limits &&
        (!std::isfinite(joint.limits->lower) || !std::isfinite(joint.limits->upper) ||
         !std::isfinite(joint.limits->effort) || joint.limits->effort < 0 ||
         !std::isfinite(joint.limits->velocity) || joint.limits->velocity < 0)) {
        return error("joint \"{}\": its limits must be finite, effort and velocity not negative",
                     joint.name);
    }
    if (is_limited(joint) && joint.limits->lower > joint.limits->upper) {
        return error("joint \"{}\": the lower limit {} must not lie above the upper one, {}",
                     joint.name, joint.limits->lower, joint.limits->upper);
    }
    if (joint.dynamics) {
        const double damping = joint.dynamics->damping, friction = joint.dynamics->friction;
        if (!(damping >= 0 && friction >= 0 && std::isfinite(damping + friction))) {
            return error("joint \"{}\": damping {} and friction {} must be 0 or more", joint.name,
                         damping, friction);
        }
        if (joint.type == urdf::Joint::PLANAR && damping + friction > 0) {
            warn("joint \"{}\" is planar: its damping and friction are left out", joint.name);
        }
    }
    return check_mimic(joint);
}

Status RobotBuilder::check_mimic(const urdf::Joint& joint) const {
    if (!joint.mimic) return Done{};
    if (joint.type == urdf::Joint::PLANAR) {
        return error("joint \"{}\" is planar and mimics another one; leave <mimic> out",
                     joint.name);
    }
    std::set<std::string> way{joint.name};
    for (const urdf::Joint* j = &joint; j->mimic;) {
        const auto source = model_->getJoint(j->mimic->joint_name);
        if (!source) {
            return error("joint \"{}\" mimics \"{}\", which is not there; check the name", j->name,
                         j->mimic->joint_name);
        }
        if (!turns(*source) && source->type != urdf::Joint::PRISMATIC) {
            return error(
                "joint \"{}\" mimics \"{}\", which neither turns nor slides; leave <mimic> out",
                j->name, source->name);
        }
        if (!way.insert(source->name).second) {
            return error("joint \"{}\" mimics itself; leave <mimic> out", joint.name);
        }
        j = source.get();
    }
    return Done{};
}

double RobotBuilder::start_of(const urdf::Joint& joint) const {
    if (const auto* item = find_item(robot_.joints, &RobotJointItem::joint, joint.name)) {
        if (item->start_rad) return *item->start_rad;
        if (item->start_m) return *item->start_m;
    }
    if (joint.mimic) {
        return joint.mimic->multiplier * start_of(*model_->getJoint(joint.mimic->joint_name)) +
               joint.mimic->offset;
    }
    return is_limited(joint) ? std::clamp(0.0, joint.limits->lower, joint.limits->upper) : 0;
}

bool RobotBuilder::is_fixed(const urdf::Joint& joint) const {
    const auto* item = find_item(robot_.joints, &RobotJointItem::joint, joint.name);
    return joint.type == urdf::Joint::FIXED || (item && item->locked);
}

Pose RobotBuilder::start_pose(const urdf::Joint& joint) const {
    const Pose origin = to_pose(joint.parent_to_joint_origin_transform);
    const Vec3 axis = to_vec3(joint.axis);
    const double start = start_of(joint);
    if (turns(joint)) return origin * Pose{{}, axis_rotation(axis, start)};
    if (joint.type == urdf::Joint::PRISMATIC) {
        return origin * Pose{axis * (start / length(axis)), {}};
    }
    return origin;
}

Status RobotBuilder::add_joint(const urdf::Joint& joint, const Pose& child_world,
                               const std::string& parent, const std::string& child) {
    JointItem item;
    item.at = robot_.at;
    item.name = robot_.name + '/' + joint.name;
    item.parent = parent;
    item.child = child;
    item.point_m = child_world.position;
    item.axis = rotate(child_world.rotation, to_vec3(joint.axis));
    item.kind = turns(joint) ? "hinge" : joint.type == urdf::Joint::PRISMATIC ? "slider" : "planar";
    item.start = start_of(joint);
    item.is_of_multibody = robot_.build == "multibody";
    if (is_limited(joint)) {
        const double lower = joint.limits->lower, upper = joint.limits->upper;
        constexpr double kRounding = 1e-6;
        if (item.start < lower - kRounding || item.start > upper + kRounding) {
            return error_at(robot_.at,
                            fmt::format("joint \"{}\" starts at {:.4g}, outside of its limits "
                                        "{:.4g} .. {:.4g} (rad or m)",
                                        joint.name, item.start, lower, upper));
        }
        (turns(joint) ? item.lower_rad : item.lower_m) = lower;
        (turns(joint) ? item.upper_rad : item.upper_m) = upper;
    }
    if (joint.dynamics) {
        item.resisting_friction = joint.dynamics->friction;
        item.resisting_damping = joint.dynamics->damping;
    }
    if (joint.mimic) {
        item.mimic = JointMimic{robot_.name + '/' + joint.mimic->joint_name,
                                joint.mimic->multiplier, joint.mimic->offset};
    }
    const auto* motor = find_item(robot_.motors, &RobotMotorItem::joint, joint.name);
    if (motor || joint.mimic) {
        const Status driven = add_motor(joint, motor, item);
        if (!driven) return driven;
    }
    scene_.joints.push_back(std::move(item));
    return Done{};
}

Status RobotBuilder::add_motor(const urdf::Joint& joint, const RobotMotorItem* motor,
                               JointItem& item) const {
    const bool slides = item.kind == "slider";
    double effort = joint.limits ? joint.limits->effort : 0;
    if (joint.limits && joint.limits->velocity > 0) item.max_velocity = joint.limits->velocity;
    if (motor) {
        const auto& given = slides ? motor->force_n : motor->torque_n_m;
        const auto& velocity = slides ? motor->max_velocity_m_s : motor->max_velocity_rad_s;
        if (given) effort = *given;
        if (velocity) item.max_velocity = *velocity;
    }
    if (effort <= 0) {
        const std::string text =
            fmt::format("the motor of joint \"{}\" has no {}, and the URDF no effort for it",
                        joint.name, slides ? "`force_n`" : "`torque_n_m`");
        return motor ? error_at(motor->at, text)
                     : error(
                           "joint \"{}\" mimics another one and has neither an effort limit "
                           "nor a [[robot.motor]]; give it one",
                           joint.name);
    }
    (slides ? item.motor_force_n : item.motor_torque_n_m) = effort;
    return Done{};
}

}  // namespace bsoil::scene
