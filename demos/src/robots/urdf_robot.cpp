#include "urdf_robot.h"

#include <fmt/format.h>
#include <urdf_model/model.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>

#include "convex_parts.h"
#include "mesh_file.h"
#include "robot_mass.h"
#include "scene/rotations.h"
#include "scene/scene_error.h"
#include "urdf_file.h"

namespace bsoil::scene {
namespace {

constexpr double kLargestMass = 1e6;    // [kg]
constexpr double kLargestLength = 1e4;  // [m]
/// An inertia whose radius of gyration exceeds the reach of the body's solids by more than this
/// factor is a placeholder or in another unit.
constexpr double kGyrationFactor = 3;
/// Of the sphere that stands for a link without a solid [m].
constexpr double kDotRadius = 0.01;

Vec3 to_vec3(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }
Pose to_pose(const urdf::Pose& p) {
    return {to_vec3(p.position), {p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w}};
}

template <typename T>
const T* find_item(const std::vector<T>& items, std::string T::*name, const std::string& wanted) {
    const auto found =
        std::find_if(items.begin(), items.end(), [&](const T& i) { return i.*name == wanted; });
    return found == items.end() ? nullptr : &*found;
}

/// A URDF's colours are those of the screen.
Vec3 linear_color(const urdf::Color& c) {
    constexpr double kScreenGamma = 2.2;
    const auto linear = [](float v) { return std::pow(std::clamp<double>(v, 0, 1), kScreenGamma); };
    return {linear(c.r), linear(c.g), linear(c.b)};
}

bool turns(const urdf::Joint& joint) {
    return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
}

/// Adds one robot to a scene.
class RobotBuilder {
  public:
    RobotBuilder(Scene& scene, const RobotItem& robot, const std::string& path)
        : scene_(scene), robot_(robot), path_(path) {}

    Status build() {
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
        if (scene_.world.up == "y")
            root.rotation = root.rotation * axis_rotation({1, 0, 0}, -90 * kDegree);
        return add_body(*model_->getRoot(), root, nullptr, "");
    }

  private:
    /// What one body is merged from.
    struct Merged {
        BodyItem body;
        MassSum mass;
        bool has_mass = false;  // any link with a mass of its own, be it 0
        bool has_visual = false;
        std::vector<std::pair<const urdf::Joint*, Pose>> moving;  // joints that hang on it
    };

    template <typename... Args>
    Error error(fmt::format_string<Args...> text, Args&&... args) const {
        return Error{path_ + ": " + fmt::format(text, std::forward<Args>(args)...)};
    }
    Error error_at(SourcePosition at, const std::string& text) const {
        return Error{scene_.message(at, text)};
    }
    template <typename... Args>
    void warn(fmt::format_string<Args...> text, Args&&... args) {
        scene_.warnings.push_back(scene_.message(
            robot_.at, path_ + ": " + fmt::format(text, std::forward<Args>(args)...)));
    }

    /// Whether all that the scene says of links and joints is about some.
    Status check_names() const {
        std::set<std::string> seen;
        for (const RobotLinkItem& item : robot_.links) {
            if (!model_->getLink(item.link)) return unknown("link", item.link, item.where("link"));
            if (!seen.insert("l" + item.link).second)
                return error_at(item.where("link"), "a second table for \"" + item.link + '"');
            if ((item.center_of_mass_m || item.moments_kg_m2) && !item.mass_kg)
                return error_at(item.at, "`center_of_mass_m` and `moments_kg_m2` need `mass_kg`");
        }
        for (const RobotMotorItem& item : robot_.motors) {
            const auto joint = model_->getJoint(item.joint);
            if (!joint) return unknown("joint", item.joint, item.where("joint"));
            if (!seen.insert("m" + item.joint).second)
                return error_at(item.where("joint"), "a second motor for \"" + item.joint + '"');
            const bool slides = joint->type == urdf::Joint::PRISMATIC;
            if (!slides && !turns(*joint))
                return error_at(
                    item.where("joint"),
                    '"' + item.joint + "\" neither turns nor slides: no motor drives it");
            for (const auto& [key, of_sliders] : {std::pair{"torque_n_m", false},
                                                  {"max_velocity_deg_s", false},
                                                  {"force_n", true},
                                                  {"max_velocity_m_s", true}})
                if (item.has(key) && of_sliders != slides)
                    return error_at(item.where(key),
                                    fmt::format("\"{}\" {}: `{}` is not for it", item.joint,
                                                slides ? "slides" : "turns", key));
        }
        for (const RobotJointItem& item : robot_.joints) {
            const auto joint = model_->getJoint(item.joint);
            if (!joint) return unknown("joint", item.joint, item.where("joint"));
            if (!seen.insert("j" + item.joint).second)
                return error_at(item.where("joint"), "a second table for \"" + item.joint + '"');
            if (item.start_rad && !turns(*joint))
                return error_at(item.where("start_deg"), '"' + item.joint + "\" does not turn");
            if (item.start_m && joint->type != urdf::Joint::PRISMATIC)
                return error_at(item.where("start_m"), '"' + item.joint + "\" does not slide");
        }
        return Done{};
    }

    Error unknown(const char* what, const std::string& name, SourcePosition at) const {
        std::string known;
        if (*what == 'l')
            for (const auto& [n, link] : model_->links_) known += (known.empty() ? "" : ", ") + n;
        else
            for (const auto& [n, joint] : model_->joints_) known += (known.empty() ? "" : ", ") + n;
        return error_at(at,
                        fmt::format("the robot has no {} \"{}\"; it has {}", what, name, known));
    }

    Status check_joint(const urdf::Joint& joint) {
        const Pose origin = to_pose(joint.parent_to_joint_origin_transform);
        if (!is_finite(origin) || length(origin.position) > kLargestLength)
            return error("joint \"{}\" has no place: its origin is ({}, {}, {})", joint.name,
                         origin.position.x, origin.position.y, origin.position.z);
        if (joint.type == urdf::Joint::FIXED || joint.type == urdf::Joint::FLOATING) return Done{};
        if (joint.type == urdf::Joint::UNKNOWN)
            return error("joint \"{}\" has no known type", joint.name);
        const Vec3 axis = to_vec3(joint.axis);
        if (!is_finite(axis) || length(axis) < 1e-6)
            return error("joint \"{}\": the axis has no length", joint.name);
        if (joint.limits &&
            (!std::isfinite(joint.limits->lower) || !std::isfinite(joint.limits->upper) ||
             !std::isfinite(joint.limits->effort) || joint.limits->effort < 0 ||
             !std::isfinite(joint.limits->velocity) || joint.limits->velocity < 0))
            return error("joint \"{}\": its limits are not finite, or effort or velocity negative",
                         joint.name);
        if (is_limited(joint) && joint.limits->lower > joint.limits->upper)
            return error("joint \"{}\": the lower limit {} lies above the upper one, {}",
                         joint.name, joint.limits->lower, joint.limits->upper);
        if (joint.dynamics) {
            const double damping = joint.dynamics->damping, friction = joint.dynamics->friction;
            if (!(damping >= 0 && friction >= 0 && std::isfinite(damping + friction)))
                return error("joint \"{}\": damping {} and friction {} must be 0 or more",
                             joint.name, damping, friction);
            if (joint.type == urdf::Joint::PLANAR && damping + friction > 0)
                warn("joint \"{}\" is planar: its damping and friction are left out", joint.name);
        }
        return check_mimic(joint);
    }

    Status check_mimic(const urdf::Joint& joint) const {
        if (!joint.mimic) return Done{};
        if (joint.type == urdf::Joint::PLANAR)
            return error("joint \"{}\" is planar and mimics another one", joint.name);
        std::set<std::string> way{joint.name};
        for (const urdf::Joint* j = &joint; j->mimic;) {
            const auto source = model_->getJoint(j->mimic->joint_name);
            if (!source)
                return error("joint \"{}\" mimics \"{}\", which is not there", j->name,
                             j->mimic->joint_name);
            if (!turns(*source) && source->type != urdf::Joint::PRISMATIC)
                return error("joint \"{}\" mimics \"{}\", which neither turns nor slides", j->name,
                             source->name);
            if (!way.insert(source->name).second)
                return error("joint \"{}\" mimics itself", joint.name);
            j = source.get();
        }
        return Done{};
    }

    static bool is_limited(const urdf::Joint& joint) {
        return joint.limits &&
               (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::PRISMATIC);
    }

    /// Where a joint stands at the start [rad or m].
    double start_of(const urdf::Joint& joint) const {
        if (const auto* item = find_item(robot_.joints, &RobotJointItem::joint, joint.name)) {
            if (item->start_rad) return *item->start_rad;
            if (item->start_m) return *item->start_m;
        }
        if (joint.mimic)
            return joint.mimic->multiplier * start_of(*model_->getJoint(joint.mimic->joint_name)) +
                   joint.mimic->offset;
        return is_limited(joint) ? std::clamp(0.0, joint.limits->lower, joint.limits->upper) : 0;
    }

    bool is_fixed(const urdf::Joint& joint) const {
        const auto* item = find_item(robot_.joints, &RobotJointItem::joint, joint.name);
        return joint.type == urdf::Joint::FIXED || (item && item->locked);
    }

    /// The child's frame in the parent's at the start.
    Pose start_pose(const urdf::Joint& joint) const {
        const Pose origin = to_pose(joint.parent_to_joint_origin_transform);
        const Vec3 axis = to_vec3(joint.axis);
        const double start = start_of(joint);
        if (turns(joint)) return origin * Pose{{}, axis_rotation(axis, start)};
        if (joint.type == urdf::Joint::PRISMATIC)
            return origin * Pose{axis * (start / length(axis)), {}};
        return origin;
    }

    /// The body that starts at `link`: it and all links fixed to it. Then the bodies that hang on
    /// them. `parent` is the body that `joint` hangs on, or "world".
    Status add_body(const urdf::Link& link, const Pose& world, const urdf::Joint* joint,
                    const std::string& parent) {
        Merged merged;
        merged.body.at = robot_.at;
        merged.body.pose = world;
        merged.body.friction = robot_.friction;
        merged.body.shape.shape = "compound";
        const Status done = merge(link, Pose{}, merged);
        if (!done) return done;
        if (merged.body.name.empty()) {
            if (joint) return error("link \"{}\" has neither mass nor solid", link.name);
            if (merged.moving.empty()) return error("no link has a mass or a solid");
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
        if (stands)
            body.mass_kg = 0;
        else if (body.mass_kg <= 0)
            return error("link \"{}\" moves and has no mass: give it one with [[robot.link]]",
                         link.name);
        else
            body.inertial = merged.mass.principal();
        if (body.inertial) warn_of_gyration(body, link.name);
        if (joint && joint->type != urdf::Joint::FLOATING) {
            const Status added = add_joint(*joint, world, parent, body.name);
            if (!added) return added;
        }
        const std::string name = body.name;
        scene_.bodies.push_back(std::move(body));
        return add_children(merged.moving, world, name);
    }

    Status add_children(const std::vector<std::pair<const urdf::Joint*, Pose>>& moving,
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

    Status merge(const urdf::Link& link, const Pose& in_body, Merged& merged) {
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
        if (body.name.empty() && (link.inertial || (item && item->mass_kg) || !solids.empty()))
            body.name = link.name;
        std::vector<DrawnItem> drawn = visuals_of(link);
        merged.has_visual |= !drawn.empty();
        if (drawn.empty())
            for (const ShapeItem& solid : solids) drawn.push_back({solid, {}, {1, 1, 1}});
        for (DrawnItem& visual : drawn) {
            visual.solid.pose = in_body * visual.solid.pose;
            if (item && item->color) visual.solid.color = item->color;
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

    Status add_mass(const urdf::Link& link, const Pose& in_body, const RobotLinkItem* item,
                    const std::vector<ShapeItem>& solids, Merged& merged) {
        if (item && item->mass_kg) {
            merged.has_mass = true;
            return replace_mass(*item, in_body, solids, merged);
        }
        if (!link.inertial) return Done{};
        const urdf::Inertial& given = *link.inertial;
        if (!std::isfinite(given.mass) || given.mass < 0 || given.mass > kLargestMass)
            return error("link \"{}\": the mass {} kg is not within 0 .. {:g} kg", link.name,
                         given.mass, kLargestMass);
        const Pose frame = to_pose(given.origin);
        if (!is_finite(frame) || length(frame.position) > kLargestLength)
            return error("link \"{}\": its centre of mass has no place", link.name);
        merged.has_mass = true;
        if (given.mass == 0) return Done{};
        Eigen::Matrix3d inertia;
        inertia << given.ixx, given.ixy, given.ixz, given.ixy, given.iyy, given.iyz, given.ixz,
            given.iyz, given.izz;
        if (const auto fault = inertia_fault(inertia))
            return error("link \"{}\": {}; replace it with [[robot.link]]", link.name, *fault);
        merged.mass.add(given.mass, inertia, in_body * frame);
        return Done{};
    }

    Status replace_mass(const RobotLinkItem& item, const Pose& in_body,
                        const std::vector<ShapeItem>& solids, Merged& merged) const {
        const double mass_kg = *item.mass_kg;
        double volume_m3 = 0;
        for (const ShapeItem& solid : solids) volume_m3 += solid_volume_m3(solid);
        MassSum of_solids;
        if (volume_m3 > 0)
            for (const ShapeItem& solid : solids)
                of_solids.add_solid(solid, Pose{}, mass_kg / volume_m3);
        else
            of_solids.add(mass_kg, Eigen::Matrix3d::Zero(), Pose{});
        Inertial inertial = of_solids.principal();
        if (item.moments_kg_m2) inertial = {{inertial.frame.position, {}}, *item.moments_kg_m2};
        if (item.center_of_mass_m) inertial.frame.position = *item.center_of_mass_m;
        const Vec3 m = inertial.moments_kg_m2;
        const Eigen::Matrix3d inertia = Eigen::Vector3d(m.x, m.y, m.z).asDiagonal();
        if (item.moments_kg_m2)
            if (const auto fault = inertia_fault(inertia))
                return error_at(item.where("moments_kg_m2"), item.link + ": " + *fault);
        merged.mass.add(mass_kg, inertia, in_body * inertial.frame);
        return Done{};
    }

    void warn_of_gyration(const BodyItem& body, const std::string& link) {
        if (body.is_ghost) return;
        double reach_m = 0;
        for (const ShapeItem& solid : body.parts) {
            double own_m = length(solid.size_m) / 2;
            if (solid.shape == "cylinder") own_m = std::hypot(solid.radius_m, solid.height_m / 2);
            if (solid.shape == "sphere") own_m = solid.radius_m;
            if (solid.shape == "hull" || solid.shape == "mesh") own_m = 0;
            const Vec3 middle = solid.pose.position - body.inertial->frame.position;
            reach_m = std::max(reach_m, length(middle) + own_m);
            for (const Vec3 p : solid.mesh ? solid.mesh->vertices : solid.points_m)
                reach_m = std::max(
                    reach_m, length(transform(solid.pose, p) - body.inertial->frame.position));
        }
        const Vec3 m = body.inertial->moments_kg_m2;
        const double gyration_m = std::sqrt(std::max({m.x, m.y, m.z}) / body.mass_kg);
        if (gyration_m > kGyrationFactor * reach_m)
            warn(
                "link \"{}\": its inertia is that of {:.3g} kg at {:.3g} m, while its solids end "
                "{:.3g} m from the centre; [[robot.link]] replaces it",
                link, body.mass_kg, gyration_m, reach_m);
    }

    /// The solids of one <collision>, in the link's frame.
    Status add_solids(const urdf::Collision& collision, const std::string& link,
                      const RobotLinkItem* item, std::vector<ShapeItem>& solids) const {
        const std::string& mode =
            item && item->has("collision") ? item->collision : robot_.collision;
        if (!collision.geometry || mode == "none") return Done{};
        ShapeItem solid;
        if (collision.geometry->type == urdf::Geometry::MESH) {
            const Status placed = place(collision.origin, link, "collision", solid);
            if (!placed) return placed;
            return add_mesh(static_cast<const urdf::Mesh&>(*collision.geometry), solid, mode, link,
                            item, solids);
        }
        const Status made = make_primitive(*collision.geometry, collision.origin, link, solid);
        if (!made) return made;
        solids.push_back(std::move(solid));
        return Done{};
    }

    Status place(const urdf::Pose& origin, const std::string& link, const char* what,
                 ShapeItem& solid) const {
        solid.at = robot_.at;
        solid.pose = to_pose(origin);
        if (!is_finite(solid.pose) || length(solid.pose.position) > kLargestLength)
            return error("link \"{}\": its {} has no place", link, what);
        return Done{};
    }

    /// A box, sphere or cylinder in the link's frame.
    Status make_primitive(const urdf::Geometry& geometry, const urdf::Pose& origin,
                          const std::string& link, ShapeItem& solid) const {
        const Status placed = place(origin, link, "collision", solid);
        if (!placed) return placed;
        const auto size_is_wrong = [](double x) { return !(x >= 1e-5 && x <= kLargestLength); };
        switch (geometry.type) {
            case urdf::Geometry::BOX: {
                solid.shape = "box";
                solid.size_m = to_vec3(static_cast<const urdf::Box&>(geometry).dim);
                const Vec3 s = solid.size_m;
                if (size_is_wrong(s.x) || size_is_wrong(s.y) || size_is_wrong(s.z))
                    return error("link \"{}\": the box {} x {} x {} m is no solid", link, s.x, s.y,
                                 s.z);
                break;
            }
            case urdf::Geometry::SPHERE:
                solid.shape = "sphere";
                solid.radius_m = static_cast<const urdf::Sphere&>(geometry).radius;
                if (size_is_wrong(solid.radius_m))
                    return error("link \"{}\": the radius {} m is none", link, solid.radius_m);
                break;
            case urdf::Geometry::CYLINDER: {
                const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
                solid.shape = "cylinder";
                solid.radius_m = cylinder.radius;
                solid.height_m = cylinder.length;
                if (size_is_wrong(solid.radius_m) || size_is_wrong(solid.height_m))
                    return error(
                        "link \"{}\": the cylinder of radius {} m and length {} m is no "
                        "solid",
                        link, solid.radius_m, solid.height_m);
                break;
            }
            default:
                return error("link \"{}\": a solid of no known kind", link);
        }
        return Done{};
    }

    /// What pictures show of a link, in its frame: its <visual>s, without what cannot be drawn.
    std::vector<DrawnItem> visuals_of(const urdf::Link& link) {
        std::vector<DrawnItem> drawn;
        for (const auto& visual : link.visual_array) {
            if (!visual || !visual->geometry) continue;
            DrawnItem item;
            Status made = Done{};
            if (visual->geometry->type == urdf::Geometry::MESH) {
                const auto& mesh = static_cast<const urdf::Mesh&>(*visual->geometry);
                made = place(visual->origin, link.name, "visual", item.solid);
                const auto path = find_robot_mesh(mesh.filename, path_);
                if (made && !path) made = Error{path.error()};
                if (path) item.mesh_file = *path;
                item.mesh_scale = to_vec3(mesh.scale);
            } else {
                made = make_primitive(*visual->geometry, visual->origin, link.name, item.solid);
            }
            if (!made) {
                warn("link \"{}\": a visual is not drawn: {}", link.name, made.error());
                continue;
            }
            if (visual->material) item.solid.color = linear_color(visual->material->color);
            drawn.push_back(std::move(item));
        }
        return drawn;
    }

    Status add_mesh(const urdf::Mesh& mesh, ShapeItem solid, const std::string& mode,
                    const std::string& link, const RobotLinkItem* item,
                    std::vector<ShapeItem>& solids) const {
        const auto path = find_robot_mesh(mesh.filename, path_);
        if (!path) return error("link \"{}\": {}", link, path.error());
        auto triangles = read_robot_mesh(*path, to_vec3(mesh.scale));
        if (!triangles) return error("link \"{}\": {}", link, triangles.error());
        for (const Vec3 p : triangles->vertices)
            if (length(p) > kLargestLength)
                return error("link \"{}\": {}: a vertex lies {:g} m out, more than {:g} m", link,
                             *path, length(p), kLargestLength);
        if (mode == "mesh") {
            solid.shape = "mesh";
            solid.mesh = std::make_shared<const TriangleMesh>(std::move(*triangles));
            solids.push_back(std::move(solid));
            return Done{};
        }
        const ConvexHull whole = convex_hull(triangles->vertices);
        const int capacity = item ? item->part_capacity : RobotLinkItem{}.part_capacity;
        std::vector<ConvexHull> hulls{whole};
        if (mode == "components") {
            hulls = component_hulls(*triangles);
            if (hulls.size() > static_cast<size_t>(capacity))
                hulls.resize(static_cast<size_t>(capacity));
        }
        if (mode == "decompose") hulls = convex_parts(*triangles, capacity);
        if (whole.volume_m3 <= 0 || hulls.empty())
            return error("link \"{}\": {}: its hull has no volume", link, *path);
        Vec3 middle;
        for (const Vec3 p : whole.surface.vertices)
            middle += p * (1.0 / static_cast<double>(whole.surface.vertices.size()));
        solid.shape = "hull";
        for (const ConvexHull& hull : hulls) {
            solid.points_m = thickened(hull, item ? item->thickness_m : 0, middle).surface.vertices;
            solids.push_back(solid);
        }
        return Done{};
    }

    Status add_joint(const urdf::Joint& joint, const Pose& child_world, const std::string& parent,
                     const std::string& child) {
        JointItem item;
        item.at = robot_.at;
        item.name = robot_.name + '/' + joint.name;
        item.parent = parent;
        item.child = child;
        item.point_m = child_world.position;
        item.axis = rotate(child_world.rotation, to_vec3(joint.axis));
        item.kind = turns(joint)                           ? "hinge"
                    : joint.type == urdf::Joint::PRISMATIC ? "slider"
                                                           : "planar";
        item.start = start_of(joint);
        if (is_limited(joint)) {
            const double lower = joint.limits->lower, upper = joint.limits->upper;
            constexpr double kRounding = 1e-6;
            if (item.start < lower - kRounding || item.start > upper + kRounding)
                return error_at(robot_.at,
                                fmt::format("joint \"{}\" starts at {:.4g}, outside of its limits "
                                            "{:.4g} .. {:.4g} (rad or m)",
                                            joint.name, item.start, lower, upper));
            (turns(joint) ? item.lower_rad : item.lower_m) = lower;
            (turns(joint) ? item.upper_rad : item.upper_m) = upper;
        }
        if (joint.dynamics) {
            item.resisting_friction = joint.dynamics->friction;
            item.resisting_damping = joint.dynamics->damping;
        }
        if (joint.mimic)
            item.mimic = JointMimic{robot_.name + '/' + joint.mimic->joint_name,
                                    joint.mimic->multiplier, joint.mimic->offset};
        const auto* motor = find_item(robot_.motors, &RobotMotorItem::joint, joint.name);
        if (motor || joint.mimic) {
            const Status driven = add_motor(joint, motor, item);
            if (!driven) return driven;
        }
        scene_.joints.push_back(std::move(item));
        return Done{};
    }

    /// The motor's figures: the scene's, else the URDF's.
    Status add_motor(const urdf::Joint& joint, const RobotMotorItem* motor, JointItem& item) const {
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
                               "nor a [[robot.motor]]",
                               joint.name);
        }
        (slides ? item.motor_force_n : item.motor_torque_n_m) = effort;
        return Done{};
    }

    Scene& scene_;
    const RobotItem& robot_;
    const std::string& path_;
    urdf::ModelInterfaceSharedPtr model_;
    std::string root_;  // link of the body that the one being added hangs on over joints
};

}  // namespace

Status add_robot(Scene& scene, const RobotItem& robot, const std::string& path) {
    return RobotBuilder(scene, robot, path).build();
}

}  // namespace bsoil::scene
