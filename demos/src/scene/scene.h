/// A scene file in memory: what a world is made of and what its run has to show. Plain data, no
/// Bullet types. The keys of the file, with units, ranges and defaults, are in scene_schema.cpp and
/// demos/scenes/README.md.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bsoil/contact/bekker_soil.h"
#include "bsoil/geometry.h"
#include "bsoil/material.h"
#include "bsoil/result.h"
#include "bsoil/soil_def.h"
#include "bsoil/soil_flow.h"

namespace bsoil::scene {

/// A place in the scene file, both counted from 1; 0 where a default stands.
struct SourcePosition {
    int line = 0, column = 0;
};

/// What every table of a scene knows of its origin, so that errors found later still point at the
/// file.
struct SceneItem {
    SourcePosition at;                           ///< of the table
    std::map<std::string, SourcePosition> keys;  ///< of each value the file gives
    std::map<std::string, std::string> said;     ///< each of these values as text
    bool has(const std::string& key) const { return keys.count(key) != 0; }
    SourcePosition where(const std::string& key) const {
        const auto found = keys.find(key);
        return found == keys.end() ? at : found->second;
    }
};

/// [world]
struct WorldItem : SceneItem {
    std::string up = "z";
    double gravity_m_s2 = 9.81;
    double substep_s = 1.0 / 240;
    double step_s = SoilDef{}.step_s;  ///< of a run without soil; no key
    int solver_iterations = 30;
    bool ground_plane = true;
    double ground_height_m = 0;
    double duration_s = 10;
};

/// [soil]
struct SoilItem : SceneItem {
    SoilDef def;
    std::string material;                ///< name of a built-in or of a [[material]]
    std::vector<std::string> materials;  ///< likewise

    /// Of the soil's materials, once the scene is loaded.
    std::optional<size_t> material_index(const std::string& name) const;
};

/// [material.bekker]: pressure and sinkage as bevameters measure them, p = (kc / b + kphi) z^n.
struct BekkerItem : SceneItem {
    double kphi = 0, kc = 0, n = 1;
    double gravity_m_s2 = 9.81;
};

/// [[material]]
struct MaterialItem : SceneItem {
    std::string name;
    std::string base = "dry_sand";
    // Each number of a MaterialDef by its name, where it replaces the base's.
#define BSOIL_OPTIONAL(field, ...) std::optional<double> field;
    BSOIL_MATERIAL_FIELDS(BSOIL_OPTIONAL)
#undef BSOIL_OPTIONAL
    std::optional<BekkerItem> bekker;       ///< load_scene turns it into the densities
    std::optional<BekkerSoil> bekker_soil;  ///< made of it by load_scene
    std::optional<Vec3> color;
};

/// [[fill]]
struct FillItem : SceneItem {
    std::string kind, material;
    Vec3 min_m, max_m;
    Vec3 base_center_m;
    double radius_m = 1, height_m = 1;
    std::string file;
    double min_height_m = 0, max_height_m = 1;
    NoiseFill noise;
    HeightMapFill height_map;  ///< read from `file` by load_scene
};

/// [[source]]
struct SourceItem : SceneItem {
    SourceDef def;
};

/// [[sink]]
struct SinkItem : SceneItem {
    std::string shape;
    Vec3 size_m{1, 1, 1};
    double radius_m = 0.5, height_m = 1;
    Pose pose;
    double rate_kg_s = 0, water_kg_s = 0, start_s = 0, end_s = kFlowForever;

    SinkDef def() const;
};

/// [[terrain]]
struct TerrainItem : SceneItem {
    std::string kind;
    double base_m = 0.5, amplitude_m = 0.5, wavelength_m = 4;
    int octaves = 4;
    double persistence = 0.5;
    int seed = 1;
    double overhang_m = 0;
    double cave_radius_m = 0.5, cave_spacing_m = 2;
    std::string file;
    double scale = 1;
    Pose pose;
    TriangleMesh mesh;  ///< read from `file` by load_scene, in world coordinates
};

/// A solid of a [[body]]; also the region of a [[probe]]. All are convex but "mesh", which only
/// robots have.
struct ShapeItem : SceneItem {
    std::string shape;
    Vec3 size_m{1, 1, 1};
    double radius_m = 0.5, height_m = 1;
    std::string axis = "z";
    std::vector<Vec3> points_m;
    std::shared_ptr<const TriangleMesh> mesh;  ///< of shape "mesh", in the solid's frame
    Pose pose;                                 ///< in the body's frame
    std::optional<double>
        mass_kg;  ///< share of a compound's mass; by volume where no part states one
    std::optional<Vec3> color;
};

/// What a picture shows in place of a solid: the same forms, or a mesh file, read when it is drawn.
struct DrawnItem {
    ShapeItem solid{};        ///< in the body's frame
    std::string mesh_file{};  ///< where it is given: the triangles, in the solid's frame
    Vec3 mesh_scale{1, 1, 1};
    std::string texture_file{};    ///< PNG, in place of the colour
    bool has_own_textures = true;  ///< where no other is given: those that the mesh file names
    double bevel_m = 0;            ///< of a box and a cylinder: how much of each edge is cut off
};

/// [[body.visual]]: one part of what pictures show of a body, or a row of it.
struct VisualItem : SceneItem {
    ShapeItem solid;
    std::string file;
    double scale = 1, bevel_m = 0;
    int repeat_count = 1;
    Vec3 repeat_step_m, repeat_center_m;
    double repeat_turn_rad = 0;
    std::string repeat_axis = "y";
    bool mirror = false;
};
/// What is drawn for it, all copies.
std::vector<DrawnItem> drawn_items(const VisualItem& visual, const std::string& mesh_file);

/// Mass distribution given from outside (a URDF): principal axes and moments.
struct Inertial {
    Pose frame;  ///< principal axes in the body's frame, origin at the centre of mass
    Vec3 moments_kg_m2;
};

/// [[body]]
struct BodyItem : SceneItem {
    std::string name;
    ShapeItem shape;
    std::vector<ShapeItem> parts;
    double mass_kg = 0;
    Pose pose;
    bool kinematic = false;
    double friction = 0.5, restitution = 0;
    std::optional<double> tool_friction, tool_adhesion_pa;  ///< with soil; else the material's
    bool ignore_soil = false;
    double linear_damping = 0, angular_damping = 0;
    Vec3 color{0.7, 0.7, 0.7};
    Vec3 velocity_m_s, angular_velocity_rad_s;
    std::string group;
    std::optional<Inertial> inertial;
    std::string multibody;   ///< bodies of one name are links of one btMultiBody; empty: rigid
    double sleep_rad_s = 1;  ///< turning slower it may fall asleep; 1 is Bullet's own
    bool is_ghost = false;   ///< touches nothing: a link without a solid
    std::vector<VisualItem> visuals;  ///< as the scene file gives them: they become `drawn`
    std::vector<DrawnItem> drawn;     ///< in pictures; empty: the solids
    std::string bullet_file;          ///< name of the [[bullet_file]] that it comes out of

    /// The solids that make the body up: its parts, or itself.
    std::vector<ShapeItem> solids() const;
};

/// A joint that follows another one: multiplier x the other's position + offset.
struct JointMimic {
    std::string joint;
    double multiplier = 1, offset = 0;
};

/// [[joint]]. Frames are in world coordinates at the start. A "planar" joint, which only robots
/// have, lets the child slide square to the axis and turn about it.
struct JointItem : SceneItem {
    std::string name, kind, parent, child;
    Vec3 point_m;
    Vec3 axis{0, 0, 1};
    Vec3 spring_axis{0, 0, 1};
    std::optional<double> lower_rad, upper_rad, lower_m, upper_m;
    double motor_torque_n_m = 0, motor_force_n = 0;
    std::optional<double> max_velocity;  ///< of the motor [rad/s or m/s]; none: as commanded
    double travel_m = 0.1, stiffness_n_m = 20e3, damping_n_s_m = 2e3;
    bool collide = false;
    double start =
        0;  ///< position at the start [rad or m]; positions and stops count from its zero
    std::optional<JointMimic> mimic;
    bool is_of_multibody = false;  ///< a robot's own, between two links of its multibody
    /// What resists every motion of a hinge or slider: a dry friction [N m or N] and a damping
    /// [N m s/rad or N s/m].
    double resisting_friction = 0, resisting_damping = 0;
};

/// [[robot.link]]: what replaces the URDF's figures of a link.
struct RobotLinkItem : SceneItem {
    std::string link;
    std::optional<double> mass_kg, friction, tool_friction, tool_adhesion_pa;
    std::optional<Vec3> center_of_mass_m, moments_kg_m2;
    bool ignore_soil = false;
    std::string collision = "hull";  ///< the robot's where the key is missing
    int part_capacity = 48;
    double thickness_m = 0;
    std::optional<Vec3> color;
};
/// [[robot.joint]]
struct RobotJointItem : SceneItem {
    std::string joint;
    bool locked = false;
    std::optional<double> start_rad, start_m;
};
/// [[robot.motor]]: the URDF's limits where a figure is missing.
struct RobotMotorItem : SceneItem {
    std::string joint;
    std::optional<double> torque_n_m, force_n, max_velocity_rad_s, max_velocity_m_s;
};
/// [[robot]]: expanded into bodies `robot/link` and joints `robot/joint` by load_scene.
struct RobotItem : SceneItem {
    std::string name, file;
    Pose pose;
    std::string build = "bodies";
    bool fixed_base = false, self_collide = false;
    double friction = 0.5;
    std::string collision = "hull";
    std::vector<RobotLinkItem> links;
    std::vector<RobotJointItem> joints;
    std::vector<RobotMotorItem> motors;
};

/// [[bullet_file]]: its rigid bodies become bodies `name/body` by load_scene; the world gets all
/// that is in it.
struct BulletFileItem : SceneItem {
    std::string name, file;
    Pose pose;
    bool ignore_soil = false;
    std::string path;  ///< of the file, found by load_scene
    bool has_multibodies = false;
};

/// [[track.wheel]]. Places are in the frame of the track's hull.
struct TrackWheelItem : SceneItem {
    std::string name;
    Vec3 position_m;
    double radius_m = 0.2, width_m = 0.1, mass_kg = 10;
    double friction = 1;
    double motor_torque_n_m = 0, bearing_torque_n_m = 1;
    std::optional<double> max_velocity_rad_s;
    Vec3 color{0.3, 0.3, 0.3};
};
/// [[track]]: expanded into bodies `track/wheel`, `track/link_01` and joints `track/wheel`,
/// `track/pin_01` by load_scene.
struct TrackItem : SceneItem {
    std::string name, hull;
    Vec3 axis{0, 1, 0};
    int link_count = 0;  ///< 0: by the pitch
    std::optional<double> pitch_m;
    double link_width_m = 0.3, link_thickness_m = 0.04, link_mass_kg = 5;
    double grouser_height_m = 0, grouser_thickness_m = 0.02;
    double guide_height_m = 0.04;
    double friction = 1, pin_torque_n_m = 1;
    std::optional<double> tool_friction, tool_adhesion_pa;
    Vec3 color{0.1, 0.1, 0.1};
    std::vector<TrackWheelItem> wheels;
};

/// [[raycast_vehicle.wheel]]
struct RaycastWheelItem : SceneItem {
    std::string name;
    Vec3 position_m;  ///< of its centre in the chassis's frame, with the strut at its rest length
    double radius_m = 0.4, width_m = 0.3, mass_kg = 20;
    bool is_driven = true, is_steered = false;
    Vec3 color{0.03, 0.03, 0.03};
};
/// [[raycast_vehicle.key]]
struct RaycastKey : SceneItem {
    double t_s = 0, throttle = 0, steering = 0, brake = 0;
};
/// [[raycast_vehicle]]: its wheels become bodies `vehicle/wheel` that touch nothing, by load_scene;
/// a RaycastVehicle moves them.
struct RaycastVehicleItem : SceneItem {
    std::string name, chassis;
    double engine_force_n = 3000, brake_force_n = 10e3, steering_rad = 0.5, max_speed_m_s = 10;
    double rest_length_m = 0.3, travel_m = 0.25;
    double stiffness_1_s2 = 40, damping_down_1_s = 4.4, damping_up_1_s = 4.6;
    double strut_force_n = 1e5;
    double friction_slip = 1.5, roll_influence = 0.1;
    std::optional<double> tool_friction, tool_adhesion_pa;
    std::vector<RaycastWheelItem> wheels;
    std::vector<RaycastKey> drive_keys;
    bool is_y_up = false;  ///< in the chassis's frame; set by load_scene
};

/// [[motion.key]]
struct MotionKey : SceneItem {
    double t_s = 0;
    std::optional<double> position_rad, offset_m, velocity_rad_s, velocity_m_s;
    std::optional<Vec3> position_m;
    std::optional<Quat> rotation;
};
/// [[motion]]
struct MotionItem : SceneItem {
    std::string joint, body;
    std::string interpolation = "smooth";
    double period_s = 0;
    int repeat_count = 1;
    std::vector<MotionKey> motion_keys;
};

/// [[probe]]
struct ProbeItem : SceneItem {
    std::string name, kind, body;
    std::string material;  ///< empty: all
    ShapeItem region;
    Vec3 from_m, to_m;
    int sample_count = 50;
};

/// [record]
struct RecordItem : SceneItem {
    std::vector<std::string> bodies;
    double every_s = 1.0 / 30;
    std::vector<double> moments_s;
};

/// [camera]
struct CameraItem : SceneItem {
    std::optional<Vec3> eye_m, target_m;
    double view_angle_rad = 0.7;
    std::string follow;
};

/// [[check]]
struct CheckItem : SceneItem {
    std::string kind, body, probe;
    double by_s = 0, at_s = 0, reference_s = 0, from_s = 0;
    double creep_mm_s = 1;
    bool must_sleep = false;
    std::optional<double> min_kg, max_kg, min_fraction, max_fraction;
    std::optional<double> to_s, max_deviation_fraction, max_range_fraction;
    std::optional<double> min_m_s, max_m_s;
    double tolerance_j = 0;
    std::vector<std::string> bodies;
    Vec3 direction;  ///< zero: none given
    Vec3 center_m, at_m;
    double expected_rad = 0, tolerance_rad = 0;
    double expected_m = 0, tolerance_m = 0;
    std::optional<double> min_m, max_m, min_n, max_n;

    /// Whether there is nothing to measure in a scene without soil.
    bool needs_soil() const;
};

/// A whole scene.
struct Scene {
    std::string path;  ///< of the file, for messages
    std::string title;
    std::string description;
    WorldItem world;
    std::optional<SoilItem> soil;
    std::vector<MaterialItem> materials;
    std::vector<FillItem> fills;
    std::vector<SourceItem> sources;
    std::vector<SinkItem> sinks;
    std::vector<TerrainItem> terrains;
    std::vector<BodyItem> bodies;
    std::vector<JointItem> joints;
    std::vector<RobotItem> robots;
    std::vector<BulletFileItem> bullet_files;
    std::vector<TrackItem> tracks;
    std::vector<RaycastVehicleItem> raycast_vehicles;
    std::vector<MotionItem> motions;
    std::vector<ProbeItem> probes;
    RecordItem record;
    CameraItem camera;
    std::vector<CheckItem> checks;
    /// Data files that are not there (of robots found through $BULLETSOIL_DATA): the scene is to be
    /// skipped.
    std::vector<std::string> missing_data;
    /// What whoever runs the scene should know of it, each with its place in the file.
    std::vector<std::string> warnings;

    const BodyItem* find_body(const std::string& name) const;
    const JointItem* find_joint(const std::string& name) const;
    const ProbeItem* find_probe(const std::string& name) const;
    /// Whether a [[raycast_vehicle]] has that body for its chassis.
    bool is_raycast_chassis(const std::string& body) const;
    /// "file:line:column: text"
    std::string message(SourcePosition at, const std::string& text) const;
};

/// A step of the run: so many of Bullet's.
struct FrameLength {
    double step_s = 0;
    int substep_count = 1;
};
/// Of the soil's length; without soil whole steps of Bullet, as near as can be to
/// WorldItem::step_s.
FrameLength frame_length(const Scene& scene);

/// Turns the whole scene so that the other axis points up (a quarter turn about x). Nothing where
/// it does already.
void set_up_axis(Scene& scene, UpAxis up);

/// The soil a scene describes: SoilDef with materials, axis and gravity filled in. Only where
/// scene.soil is set.
SoilDef soil_def(const Scene& scene);

}  // namespace bsoil::scene
