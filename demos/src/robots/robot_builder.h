/// RobotBuilder: a URDF becomes bodies and joints of a scene. Checks and links: urdf_robot.cpp;
/// joints: robot_joints.cpp; solids and what is drawn: robot_solids.cpp.
#pragma once

#include <fmt/format.h>
#include <urdf_model/model.h>
#include <urdf_world/types.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "robot_mass.h"
#include "scene/scene.h"
#include "scene/scene_error.h"

namespace bsoil::scene {

inline constexpr double kLargestMass = 1e6;    ///< of a link [kg]
inline constexpr double kLargestLength = 1e4;  ///< of a solid [m]

inline Vec3 to_vec3(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }
inline Pose to_pose(const urdf::Pose& p) {
    return {to_vec3(p.position), {p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w}};
}

template <typename T>
const T* find_item(const std::vector<T>& items, std::string T::*name, const std::string& wanted) {
    const auto found =
        std::find_if(items.begin(), items.end(), [&](const T& i) { return i.*name == wanted; });
    return found == items.end() ? nullptr : &*found;
}

inline bool turns(const urdf::Joint& joint) {
    return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
}

/// Adds one robot to a scene.
class RobotBuilder {
  public:
    RobotBuilder(Scene& scene, const RobotItem& robot, const std::string& path)
        : scene_(scene), robot_(robot), path_(path) {}

    Status build();

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
    Error error_at(SourcePosition at, const std::string& text) const;
    template <typename... Args>
    void warn(fmt::format_string<Args...> text, Args&&... args) {
        scene_.warnings.push_back(scene_.message(
            robot_.at, path_ + ": " + fmt::format(text, std::forward<Args>(args)...)));
    }

    /// Whether all that the scene says of links and joints is about some.
    Status check_names() const;

    Error unknown(const char* what, const std::string& name, SourcePosition at) const;

    Status check_joint(const urdf::Joint& joint);

    Status check_mimic(const urdf::Joint& joint) const;

    static bool is_limited(const urdf::Joint& joint) {
        return joint.limits &&
               (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::PRISMATIC);
    }

    /// Where a joint stands at the start [rad or m].
    double start_of(const urdf::Joint& joint) const;

    bool is_fixed(const urdf::Joint& joint) const;

    /// The child's frame in the parent's at the start.
    Pose start_pose(const urdf::Joint& joint) const;

    /// The body that starts at `link`: it and all links fixed to it. Then the bodies that hang on
    /// them. `parent` is the body that `joint` hangs on, or "world".
    Status add_body(const urdf::Link& link, const Pose& world, const urdf::Joint* joint,
                    const std::string& parent);

    Status add_children(const std::vector<std::pair<const urdf::Joint*, Pose>>& moving,
                        const Pose& world, const std::string& parent);

    Status merge(const urdf::Link& link, const Pose& in_body, Merged& merged);

    Status add_mass(const urdf::Link& link, const Pose& in_body, const RobotLinkItem* item,
                    const std::vector<ShapeItem>& solids, Merged& merged);

    Status replace_mass(const RobotLinkItem& item, const Pose& in_body,
                        const std::vector<ShapeItem>& solids, Merged& merged) const;

    void warn_of_gyration(const BodyItem& body, const std::string& link);

    /// The solids of one <collision>, in the link's frame.
    Status add_solids(const urdf::Collision& collision, const std::string& link,
                      const RobotLinkItem* item, std::vector<ShapeItem>& solids) const;

    Status place(const urdf::Pose& origin, const std::string& link, const char* what,
                 ShapeItem& solid) const;

    /// A box, sphere or cylinder in the link's frame.
    Status make_primitive(const urdf::Geometry& geometry, const urdf::Pose& origin,
                          const std::string& link, ShapeItem& solid) const;

    /// What pictures show of a link, in its frame: its <visual>s, without what cannot be drawn.
    std::vector<DrawnItem> visuals_of(const urdf::Link& link);

    /// What a visual's <material> says: its texture, else its colour.
    void use_material(const urdf::Material& material, const std::string& link, DrawnItem& item);

    Status add_mesh(const urdf::Mesh& mesh, ShapeItem solid, const std::string& mode,
                    const std::string& link, const RobotLinkItem* item,
                    std::vector<ShapeItem>& solids) const;

    Status add_joint(const urdf::Joint& joint, const Pose& child_world, const std::string& parent,
                     const std::string& child);

    /// The motor's figures: the scene's, else the URDF's.
    Status add_motor(const urdf::Joint& joint, const RobotMotorItem* motor, JointItem& item) const;

    Scene& scene_;
    const RobotItem& robot_;
    const std::string& path_;
    urdf::ModelInterfaceSharedPtr model_;
    std::string root_;  // link of the body that the one being added hangs on over joints
};

}  // namespace bsoil::scene
