#include "urdf_robot.h"

#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Eigenvalues>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "data_files.h"
#include "schema_table.h"

namespace bsoil::scene {
namespace {

Vec3 to_vec3(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }
Pose to_pose(const urdf::Pose& p) {
    return {to_vec3(p.position), {p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w}};
}

Eigen::Vector3d to_eigen(Vec3 v) { return {v.x, v.y, v.z}; }
Vec3 from_eigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Mass, first and second moments of the links merged into one body, in that body's frame.
struct MassSum {
    double mass_kg = 0;
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();   // of mass about the frame's origin
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the frame's origin

    void add(const urdf::Inertial& inertial, const Pose& link) {
        const Pose frame = link * to_pose(inertial.origin);
        const Quat q = frame.rotation;
        const Eigen::Matrix3d turn = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
        Eigen::Matrix3d own;
        own << inertial.ixx, inertial.ixy, inertial.ixz, inertial.ixy, inertial.iyy, inertial.iyz,
            inertial.ixz, inertial.iyz, inertial.izz;
        const Eigen::Vector3d c = to_eigen(frame.position);
        mass_kg += inertial.mass;
        moment += inertial.mass * c;
        inertia += turn * own * turn.transpose() + shifted(inertial.mass, c);
    }
    Inertial principal() const {
        const Eigen::Vector3d center = moment / mass_kg;
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia -
                                                                    shifted(mass_kg, center));
        Eigen::Matrix3d axes = solver.eigenvectors();
        if (axes.determinant() < 0) axes.col(0) *= -1;
        const Eigen::Quaterniond q(axes);
        return {{from_eigen(center), {q.x(), q.y(), q.z(), q.w()}},
                from_eigen(solver.eigenvalues().cwiseMax(1e-9 * mass_kg))};
    }

  private:
    /// Of a point mass about the origin: the parallel axis theorem.
    static Eigen::Matrix3d shifted(double mass_kg, const Eigen::Vector3d& c) {
        return mass_kg * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
    }
};

/// Adds one robot to a scene.
class RobotBuilder {
  public:
    RobotBuilder(Scene& scene, const RobotItem& robot, const std::string& path)
        : scene_(scene), robot_(robot), path_(path) {}

    Status build() {
        std::ifstream file(path_);
        std::stringstream text;
        text << file.rdbuf();
        if (!file) return Error{path_ + ": cannot be read"};
        static const std::regex kOptionalEnvironment(R"(\$\(optenv\s+\w+\s+([^)]*)\))");
        const std::string xml = std::regex_replace(text.str(), kOptionalEnvironment, "$1");
        model_ = urdf::parseURDF(xml);
        if (!model_ || !model_->getRoot()) return Error{path_ + ": not a valid URDF"};
        for (const LinkMassItem& item : robot_.link_masses)
            if (!model_->getLink(item.link)) return unknown("link", item.link, item.where("link"));
        for (const RobotMotorItem& item : robot_.motors)
            if (!model_->joints_.count(item.joint))
                return unknown("joint", item.joint, item.where("joint"));

        Pose root = robot_.pose;
        if (scene_.world.up == "y")
            root.rotation = root.rotation * axis_rotation({1, 0, 0}, -90 * kDegree);
        return add_body(*model_->getRoot(), root, nullptr, "");
    }

  private:
    Error unknown(const char* what, const std::string& name, SourcePosition at) const {
        return Error{scene_.message(at, fmt::format("the robot has no {} \"{}\"", what, name))};
    }

    /// The body that starts at `link`: it and all links fixed to it. Then the bodies that hang on
    /// them.
    Status add_body(const urdf::Link& link, const Pose& world, const urdf::Joint* joint,
                    const std::string& parent) {
        BodyItem body;
        body.at = robot_.at;
        body.pose = world;
        body.friction = robot_.friction;
        body.group = robot_.name;
        body.shape.shape = "compound";
        MassSum mass;
        bool mass_replaced = false;
        std::vector<std::pair<const urdf::Joint*, Pose>> moving;
        const Status merged = merge(link, Pose{}, body, mass, mass_replaced, moving);
        if (!merged) return merged;
        if (body.name.empty()) {
            if (moving.empty() && !joint) return Error{path_ + ": no link has a mass or a solid"};
            return Error{
                fmt::format("{}: link \"{}\" has neither mass nor solid", path_, link.name)};
        }
        body.name = robot_.name + '/' + body.name;
        body.mass_kg = mass.mass_kg;
        if (body.parts.empty()) {  // a body needs a solid: one too small to matter
            ShapeItem dot;
            dot.shape = "sphere";
            dot.radius_m = 0.01;
            body.parts.push_back(dot);
        }
        if (robot_.fixed_base && !joint)
            body.mass_kg = 0;
        else if (mass.mass_kg <= 0)
            return Error{fmt::format(
                "{}: link \"{}\" moves and has no mass: give it one with [[robot.link_mass]]",
                path_, link.name)};
        else if (!mass_replaced)
            body.inertial = mass.principal();
        if (joint) {
            const Status added = add_joint(*joint, world, parent, body.name);
            if (!added) return added;
        }
        const std::string name = body.name;
        scene_.bodies.push_back(std::move(body));
        for (const auto& [child_joint, pose] : moving) {
            const auto child = model_->getLink(child_joint->child_link_name);
            const Status added = add_body(*child, world * pose, child_joint, name);
            if (!added) return added;
        }
        return Done{};
    }

    Status merge(const urdf::Link& link, const Pose& in_body, BodyItem& body, MassSum& mass,
                 bool& mass_replaced, std::vector<std::pair<const urdf::Joint*, Pose>>& moving) {
        double replaced_kg = 0;
        for (const LinkMassItem& item : robot_.link_masses)
            if (item.link == link.name) replaced_kg = item.mass_kg;
        if (replaced_kg > 0) {
            mass.mass_kg += replaced_kg;
            mass_replaced = true;
        } else if (link.inertial) {
            mass.add(*link.inertial, in_body);
        }
        for (const auto& collision : link.collision_array) {
            const Status added = add_solid(*collision, in_body, body);
            if (!added) return added;
        }
        if (body.name.empty() &&
            (link.inertial || replaced_kg > 0 || !link.collision_array.empty()))
            body.name = link.name;
        for (const auto& joint : link.child_joints) {
            const Pose child = in_body * to_pose(joint->parent_to_joint_origin_transform);
            if (joint->type == urdf::Joint::FIXED) {
                const Status merged = merge(*model_->getLink(joint->child_link_name), child, body,
                                            mass, mass_replaced, moving);
                if (!merged) return merged;
            } else {
                moving.emplace_back(joint.get(), child);
            }
        }
        return Done{};
    }

    Status add_solid(const urdf::Collision& collision, const Pose& in_body, BodyItem& body) {
        if (!collision.geometry) return Done{};
        ShapeItem solid;
        solid.at = robot_.at;
        solid.pose = in_body * to_pose(collision.origin);
        switch (collision.geometry->type) {
            case urdf::Geometry::BOX:
                solid.shape = "box";
                solid.size_m = to_vec3(static_cast<const urdf::Box&>(*collision.geometry).dim);
                break;
            case urdf::Geometry::SPHERE:
                solid.shape = "sphere";
                solid.radius_m = static_cast<const urdf::Sphere&>(*collision.geometry).radius;
                break;
            case urdf::Geometry::CYLINDER: {
                const auto& cylinder = static_cast<const urdf::Cylinder&>(*collision.geometry);
                solid.shape = "cylinder";
                solid.radius_m = cylinder.radius;
                solid.height_m = cylinder.length;
                break;
            }
            default: {
                const auto& mesh = static_cast<const urdf::Mesh&>(*collision.geometry);
                const std::filesystem::path file =
                    std::filesystem::path(path_).parent_path() / mesh.filename;
                auto triangles = read_mesh(file.string());
                if (!triangles) return Error{triangles.error()};
                solid.shape = "hull";
                for (const Vec3 p : triangles->vertices)
                    solid.points_m.push_back(
                        {p.x * mesh.scale.x, p.y * mesh.scale.y, p.z * mesh.scale.z});
            }
        }
        body.parts.push_back(std::move(solid));
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
        switch (joint.type) {
            case urdf::Joint::CONTINUOUS:
                item.kind = "hinge";
                break;
            case urdf::Joint::REVOLUTE:
                item.kind = "hinge";
                if (joint.limits) {
                    item.lower_rad = joint.limits->lower;
                    item.upper_rad = joint.limits->upper;
                }
                break;
            case urdf::Joint::PRISMATIC:
                item.kind = "slider";
                if (joint.limits) {
                    item.lower_m = joint.limits->lower;
                    item.upper_m = joint.limits->upper;
                }
                break;
            default:
                return Error{
                    fmt::format("{}: joint \"{}\" is floating or planar, which is not supported",
                                path_, joint.name)};
        }
        for (const RobotMotorItem& motor : robot_.motors) {
            if (motor.joint != joint.name) continue;
            item.motor_torque_n_m = motor.torque_n_m;
            item.motor_force_n = motor.force_n;
        }
        scene_.joints.push_back(std::move(item));
        return Done{};
    }

    Scene& scene_;
    const RobotItem& robot_;
    const std::string& path_;
    urdf::ModelInterfaceSharedPtr model_;
};

}  // namespace

Status add_robot(Scene& scene, const RobotItem& robot, const std::string& path) {
    return RobotBuilder(scene, robot, path).build();
}

}  // namespace bsoil::scene
