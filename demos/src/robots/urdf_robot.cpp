#include "urdf_robot.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "robot_builder.h"
#include "scene/rotations.h"
#include "urdf_file.h"

namespace bsoil::scene {

namespace {

/// An inertia whose radius of gyration exceeds the reach of the body's solids by more than this
/// factor is a placeholder or in another unit.
constexpr double kGyrationFactor = 3;
/// Of the sphere that stands for a link without a solid [m].
constexpr double kDotRadius = 0.01;

}  // namespace

Status RobotBuilder::build() {
    auto model = read_urdf(path_);
    if (!model) return Error{model.error()};
    model_ = *model;
    const Status named = check_names();
    if (!named) return named;
    for (const auto& [name, joint] : model_->joints_) {
        const Status valid = check_joint(*joint);
        if (!valid) return valid;
    }
    Pose root = robot_.pose;
    if (scene_.world.up == "y") {
        root.rotation = root.rotation * axis_rotation({1, 0, 0}, -90 * kDegree);
    }
    return add_body(*model_->getRoot(), root, nullptr, "");
}

Error RobotBuilder::error_at(SourcePosition at, const std::string& text) const {
    return Error{scene_.message(at, text)};
}

Status RobotBuilder::check_names() const {
    std::set<std::string> seen;
    for (const RobotLinkItem& item : robot_.links) {
        if (!model_->getLink(item.link)) return unknown("link", item.link, item.where("link"));
        if (!seen.insert("l" + item.link).second) {
            return error_at(item.where("link"), "a second table for \"" + item.link + '"');
        }
        if ((item.center_of_mass_m || item.moments_kg_m2) && !item.mass_kg) {
            return error_at(item.at, "`center_of_mass_m` and `moments_kg_m2` need `mass_kg`");
        }
    }
    for (const RobotMotorItem& item : robot_.motors) {
        const auto joint = model_->getJoint(item.joint);
        if (!joint) return unknown("joint", item.joint, item.where("joint"));
        if (!seen.insert("m" + item.joint).second) {
            return error_at(item.where("joint"), "a second motor for \"" + item.joint + '"');
        }
        const bool slides = joint->type == urdf::Joint::PRISMATIC;
        if (!slides && !turns(*joint)) {
            return error_at(item.where("joint"),
                            '"' + item.joint + "\" neither turns nor slides: no motor drives it");
        }
        for (const auto& [key, of_sliders] : {std::pair{"torque_n_m", false},
                                              {"max_velocity_deg_s", false},
                                              {"force_n", true},
                                              {"max_velocity_m_s", true}}) {
            if (item.has(key) && of_sliders != slides) {
                return error_at(item.where(key),
                                fmt::format("\"{}\" {}: `{}` is not for it", item.joint,
                                            slides ? "slides" : "turns", key));
            }
        }
    }
    for (const RobotJointItem& item : robot_.joints) {
        const auto joint = model_->getJoint(item.joint);
        if (!joint) return unknown("joint", item.joint, item.where("joint"));
        if (!seen.insert("j" + item.joint).second) {
            return error_at(item.where("joint"), "a second table for \"" + item.joint + '"');
        }
        if (item.start_rad && !turns(*joint)) {
            return error_at(item.where("start_deg"), '"' + item.joint + "\" does not turn");
        }
        if (item.start_m && joint->type != urdf::Joint::PRISMATIC) {
            return error_at(item.where("start_m"), '"' + item.joint + "\" does not slide");
        }
    }
    return Done{};
}

Error RobotBuilder::unknown(const char* what, const std::string& name, SourcePosition at) const {
    std::string known;
    if (*what == 'l') {
        for (const auto& [n, link] : model_->links_) known += (known.empty() ? "" : ", ") + n;
    } else {
        for (const auto& [n, joint] : model_->joints_) known += (known.empty() ? "" : ", ") + n;
    }
    return error_at(at, fmt::format("the robot has no {} \"{}\"; it has {}", what, name, known));
}

Status RobotBuilder::add_body(const urdf::Link& link, const Pose& world, const urdf::Joint* joint,
                              const std::string& parent) {
    Merged merged;
    merged.body.at = robot_.at;
    merged.body.pose = world;
    merged.body.friction = robot_.friction;
    merged.body.shape.shape = "compound";
    const Status done = merge(link, Pose{}, merged);
    if (!done) return done;
    if (merged.body.name.empty()) {
        if (joint) {
            return error("link \"{}\" has neither mass nor solid; give it one of them", link.name);
        }
        if (merged.moving.empty()) {
            return error("no link has a mass or a solid; give one of them either");
        }
        return add_children(merged.moving, world, "world");
    }
    BodyItem& body = merged.body;
    if (!merged.has_visual) body.drawn.clear();
    if (!joint || joint->type == urdf::Joint::FLOATING) root_ = body.name;
    body.name = robot_.name + '/' + body.name;
    if (robot_.build == "multibody") body.multibody = robot_.name + '/' + root_;
    if (!robot_.self_collide) body.group = robot_.name;
    if (body.parts.empty()) {
        body.is_ghost = true;
        ShapeItem dot;
        dot.shape = "sphere";
        dot.radius_m = kDotRadius;
        body.parts.push_back(dot);
    }
    body.mass_kg = merged.mass.mass_kg();
    const bool stands = !joint && (robot_.fixed_base || (merged.has_mass && body.mass_kg == 0));
    if (stands) {
        body.mass_kg = 0;
    } else if (body.mass_kg <= 0) {
        return error("link \"{}\" moves and has no mass; give it one with [[robot.link]]",
                     link.name);
    } else {
        body.inertial = merged.mass.principal();
    }
    if (body.inertial) warn_of_gyration(body, link.name);
    if (joint && joint->type != urdf::Joint::FLOATING) {
        const Status added = add_joint(*joint, world, parent, body.name);
        if (!added) return added;
    }
    const std::string name = body.name;
    scene_.bodies.push_back(std::move(body));
    return add_children(merged.moving, world, name);
}

Status RobotBuilder::add_children(const std::vector<std::pair<const urdf::Joint*, Pose>>& moving,
                                  const Pose& world, const std::string& parent) {
    for (const auto& [joint, pose] : moving) {
        const auto child = model_->getLink(joint->child_link_name);
        const std::string root = root_;
        const Status added = add_body(*child, world * pose, joint, parent);
        if (!added) return added;
        root_ = root;
    }
    return Done{};
}

Status RobotBuilder::merge(const urdf::Link& link, const Pose& in_body, Merged& merged) {
    BodyItem& body = merged.body;
    const auto* item = find_item(robot_.links, &RobotLinkItem::link, link.name);
    std::vector<ShapeItem> solids;
    for (const auto& collision : link.collision_array) {
        const Status added = add_solids(*collision, link.name, item, solids);
        if (!added) return added;
    }
    const Status weighed = add_mass(link, in_body, item, solids, merged);
    if (!weighed) return weighed;
    if (item) {
        if (item->friction) body.friction = *item->friction;
        if (item->tool_friction) body.tool_friction = item->tool_friction;
        if (item->tool_adhesion_pa) body.tool_adhesion_pa = item->tool_adhesion_pa;
        body.ignore_soil = body.ignore_soil || item->ignore_soil;
    }
    if (body.name.empty() && (link.inertial || (item && item->mass_kg) || !solids.empty())) {
        body.name = link.name;
    }
    std::vector<DrawnItem> drawn = visuals_of(link);
    merged.has_visual |= !drawn.empty();
    if (drawn.empty()) {
        for (const ShapeItem& solid : solids) drawn.emplace_back().solid = solid;
    }
    for (DrawnItem& visual : drawn) {
        visual.solid.pose = in_body * visual.solid.pose;
        if (item && item->color) {
            visual.solid.color = item->color;
            visual.texture_file.clear();
            visual.has_own_textures = false;
        }
        body.drawn.push_back(std::move(visual));
    }
    for (ShapeItem& solid : solids) {
        solid.pose = in_body * solid.pose;
        if (item) solid.color = item->color;
        body.parts.push_back(std::move(solid));
    }
    for (const auto& joint : link.child_joints) {
        const Pose child = in_body * start_pose(*joint);
        const Status done = is_fixed(*joint)
                                ? merge(*model_->getLink(joint->child_link_name), child, merged)
                                : Status(Done{});
        if (!done) return done;
        if (!is_fixed(*joint)) merged.moving.emplace_back(joint.get(), child);
    }
    return Done{};
}

Status RobotBuilder::add_mass(const urdf::Link& link, const Pose& in_body,
                              const RobotLinkItem* item, const std::vector<ShapeItem>& solids,
                              Merged& merged) {
    if (item && item->mass_kg) {
        merged.has_mass = true;
        return replace_mass(*item, in_body, solids, merged);
    }
    if (!link.inertial) return Done{};
    const urdf::Inertial& given = *link.inertial;
    if (!std::isfinite(given.mass) || given.mass < 0 || given.mass > kLargestMass) {
        return error("link \"{}\": the mass {} kg must be 0 .. {:g} kg", link.name, given.mass,
                     kLargestMass);
    }
    const Pose frame = to_pose(given.origin);
    if (!is_finite(frame) || length(frame.position) > kLargestLength) {
        return error("link \"{}\": its centre of mass must be finite", link.name);
    }
    merged.has_mass = true;
    if (given.mass == 0) return Done{};
    Eigen::Matrix3d inertia;
    inertia << given.ixx, given.ixy, given.ixz, given.ixy, given.iyy, given.iyz, given.ixz,
        given.iyz, given.izz;
    if (const auto fault = inertia_fault(inertia)) {
        return error("link \"{}\": {}; replace it with [[robot.link]]", link.name, *fault);
    }
    merged.mass.add(given.mass, inertia, in_body * frame);
    return Done{};
}

Status RobotBuilder::replace_mass(const RobotLinkItem& item, const Pose& in_body,
                                  const std::vector<ShapeItem>& solids, Merged& merged) const {
    const double mass_kg = *item.mass_kg;
    double volume_m3 = 0;
    for (const ShapeItem& solid : solids) volume_m3 += solid_volume_m3(solid);
    MassSum of_solids;
    if (volume_m3 > 0) {
        for (const ShapeItem& solid : solids) {
            of_solids.add_solid(solid, Pose{}, mass_kg / volume_m3);
        }
    } else {
        of_solids.add(mass_kg, Eigen::Matrix3d::Zero(), Pose{});
    }
    Inertial inertial = of_solids.principal();
    if (item.moments_kg_m2) inertial = {{inertial.frame.position, {}}, *item.moments_kg_m2};
    if (item.center_of_mass_m) inertial.frame.position = *item.center_of_mass_m;
    const Vec3 m = inertial.moments_kg_m2;
    const Eigen::Matrix3d inertia = Eigen::Vector3d(m.x, m.y, m.z).asDiagonal();
    if (item.moments_kg_m2) {
        if (const auto fault = inertia_fault(inertia)) {
            return error_at(item.where("moments_kg_m2"), item.link + ": " + *fault);
        }
    }
    merged.mass.add(mass_kg, inertia, in_body * inertial.frame);
    return Done{};
}

void RobotBuilder::warn_of_gyration(const BodyItem& body, const std::string& link) {
    if (body.is_ghost) return;
    double reach_m = 0;
    for (const ShapeItem& solid : body.parts) {
        double own_m = length(solid.size_m) / 2;
        if (solid.shape == "cylinder") own_m = std::hypot(solid.radius_m, solid.height_m / 2);
        if (solid.shape == "sphere") own_m = solid.radius_m;
        if (solid.shape == "hull" || solid.shape == "mesh") own_m = 0;
        const Vec3 middle = solid.pose.position - body.inertial->frame.position;
        reach_m = std::max(reach_m, length(middle) + own_m);
        for (const Vec3 p : solid.mesh ? solid.mesh->vertices : solid.points_m) {
            reach_m =
                std::max(reach_m, length(transform(solid.pose, p) - body.inertial->frame.position));
        }
    }
    const Vec3 m = body.inertial->moments_kg_m2;
    const double gyration_m = std::sqrt(std::max({m.x, m.y, m.z}) / body.mass_kg);
    if (gyration_m > kGyrationFactor * reach_m) {
        warn(
            "link \"{}\": its inertia is that of {:.3g} kg at {:.3g} m, while its solids end "
            "{:.3g} m from the centre; [[robot.link]] replaces it",
            link, body.mass_kg, gyration_m, reach_m);
    }
}

Status add_robot(Scene& scene, const RobotItem& robot, const std::string& path) {
    return RobotBuilder(scene, robot, path).build();
}

}  // namespace bsoil::scene
