/// A world as data: what a seed stands for. It can be printed, and parts of it can be dropped.
///
/// Places are in metres along a soil's own axes: x and y horizontal, z up, from the grid's lower
/// corner. So a plan says nothing of the up axis or the yaw but in its SoilPlan.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bsoil/soil_def.h"
#include "bsoil/soil_flow.h"

namespace bsoil::random_worlds {

struct ShapePlan {
    enum class Kind {
        box,
        sphere,
        capsule,
        cylinder,
        cone,
        hull,
        point_cloud,
        multi_sphere,
        scaled,         ///< btUniformScalingShape of the child, by half_m.x
        minkowski_sum,  ///< of two children
        compound,
        triangle_mesh,         ///< closed; fixed bodies only
        scaled_triangle_mesh,  ///< by half_m
        open_mesh,             ///< a sheet; fixed bodies only
        moving_mesh,           ///< btGImpactMeshShape
        triangle,
        heightfield,
        plane,
        none  ///< btEmptyShape: the soil refuses it
    };
    Kind kind = Kind::box;
    int axis = 2;  ///< of capsule, cylinder and cone: 0, 1 or 2
    /// Half of its extents, along the shape's axes with its own axis as z. Plane: its normal.
    Vec3 half_m;
    /// hull, point cloud: points; multi-sphere: centres; meshes, triangle: corners.
    std::vector<Vec3> points_m;
    std::vector<double> numbers_m;  ///< radii of a multi-sphere, heights of a heightfield
    std::vector<int> indices;       ///< of a mesh
    int side_count = 0;             ///< heights along a side of a heightfield
    double margin_m = 0;            ///< hulls and meshes
    std::vector<ShapePlan> children;
    std::vector<Pose> child_poses;
};
/// No point of the shape is farther from its origin; infinite for planes and heightfields.
double bound_m(const ShapePlan& shape);
ShapePlan box_plan(Vec3 half_m);
const char* name_of(ShapePlan::Kind kind);
/// Whether it may roll on for long.
bool is_round(const ShapePlan& shape);

struct BodyPlan {
    enum class Kind { moving, fixed, driven };
    Kind kind = Kind::moving;
    ShapePlan shape;
    double mass_kg = 0;
    int soil = 0;  ///< in whose frame it is placed
    Pose pose;
    Vec3 velocity_m_s, spin_rad_s;  ///< at first; of driven bodies until the action ends
    double friction = 0.5;
    int enters_step = 0, leaves_step = -1;  ///< -1: stays
    bool is_ignored = false, is_coverage_only = false;
    double surface_friction = -1;
    bool dropped = false;
};

struct JointPlan {
    enum class Kind { hinge, slider, point, six_dof };
    Kind kind = Kind::hinge;
    int a = 0, b = 0;  ///< indices of bodies
    Vec3 axis{1, 0, 0};
    double motor_speed = 0;  ///< rad/s or m/s; until the action ends
    double motor_most = 0;   ///< N m or N; 0: none
    bool dropped = false;
};

/// A btRaycastVehicle on four wheels of a SoilRaycaster.
struct CarPlan {
    int soil = 0;
    Pose pose;
    double radius_m = 0.4, mass_kg = 800, width_m = 0.3;
    double engine_n = 0, steering_rad = 0;  ///< until the action ends; then it brakes
    bool dropped = false;
};

/// A btMultiBody: a chain of boxes with revolute joints.
struct ChainPlan {
    int soil = 0;
    Pose pose;
    int link_count = 2;
    bool has_fixed_base = false;
    double half_m = 0.1, link_mass_kg = 1;
    double motor_speed = 0, motor_most = 0;  ///< of the last joint, until the action ends
    bool dropped = false;
};

struct EventPlan {
    enum class Kind { teleport, push, set_ignored, set_coupled, fill, disable, enable };
    int step = 0;
    Kind kind = Kind::push;
    int body = -1;  ///< fill, disable, enable: index of a soil
    Vec3 vector;    ///< place (teleport, fill), change of velocity (push)
    bool dropped = false;
};

struct FillPlan {
    enum class Kind { box, cylinder, noise, hill };
    Kind kind = Kind::box;
    int material = 0;
    Vec3 low_m, high_m;  ///< cylinder and hill: within this box
    uint64_t seed = 0;
    bool is_hanging = false;  ///< placed in the air
    bool dropped = false;
};

/// A source or a sink. Its places are along the soil's axes, too.
struct FlowPlan {
    bool is_source = false;
    SourceDef source;
    SinkDef sink;
    int moves_step = -1, ends_step = -1;  ///< put somewhere else, taken away; -1: never
    Vec3 moved_to_m;
    bool dropped = false;
};

struct SoilPlan {
    SoilDef def;  ///< size_m is of whole voxels
    std::vector<FillPlan> fills;
    double terrain_m = 0;  ///< height of a sloping fixed ground; 0: none
    double terrain_slope = 0;
    std::vector<FlowPlan> flows;
};

struct WorldPlan {
    uint64_t seed = 0;
    std::vector<SoilPlan> soils;
    std::vector<BodyPlan> bodies;
    std::vector<JointPlan> joints;
    std::vector<CarPlan> cars;
    std::vector<ChainPlan> chains;
    std::vector<EventPlan> events;
    double frame_s = 1.0 / 60;
    int substep_count = 1;
    int solver_iterations = 10;  ///< of Bullet's solver in a substep: its own default
    bool is_variable = false;    ///< frames last from a third of frame_s to all of it
    int action_steps = 60;       ///< then everything is left alone
    bool has_weather = false;    ///< see add_weather.h
};

/// Whether something in it does work on its bodies.
bool has_motors(const WorldPlan& plan);
/// How fast the strongest gust rises [m/s]; 0 where wind is level or sinks.
double rising_wind_m_s(const SoilDef& def);
/// Whether that holds a material up, or nearly so.
bool is_held_by_wind(const SoilDef& def, const MaterialDef& material);
/// For a reader: everything that is in the world, one line each.
std::string describe(const WorldPlan& plan);

}  // namespace bsoil::random_worlds
