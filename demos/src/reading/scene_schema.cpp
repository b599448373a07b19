/// The scene schema: every key a scene file may have. The README of the scenes is printed from this
/// table.
#include <fmt/format.h>

#include "scene_load.h"
#include "schema_table.h"

namespace bsoil::scene {
namespace {

constexpr Range kPlace{-1e4, 1e4};    // [m] float positions keep a millimetre within it
constexpr Range kLength{1e-4, 1e4};   // [m]
constexpr Range kMass{0, 1e6};        // [kg]
constexpr Range kTime{0, 1e5};        // [s]
constexpr Range kForce{0, 1e8};       // [N], [N m]
constexpr Range kAngle{-3600, 3600};  // [deg]
constexpr Range kSpeed{-100, 100};    // [m/s]
constexpr Range kDirection{-1, 1};

/// The keys of a convex solid, for whatever table has one.
template <typename T, typename P>
void add_shape_keys(TableOf<T>& table, P place) {
    table
        .vector(
            "size_m", [place](T& t) -> Vec3& { return std::invoke(place, t).size_m; }, kLength,
            "full edge lengths of the box")
        .only({"box"})
        .required()
        .number(
            "radius_m", [place](T& t) -> double& { return std::invoke(place, t).radius_m; },
            kLength, "radius; of a cone: of its base")
        .only({"sphere", "capsule", "cylinder", "cone"})
        .required()
        .number(
            "height_m", [place](T& t) -> double& { return std::invoke(place, t).height_m; },
            kLength, "length along the axis; of a capsule: without the round ends")
        .only({"capsule", "cylinder", "cone"})
        .required()
        .word(
            "axis", [place](T& t) -> std::string& { return std::invoke(place, t).axis; },
            {"x", "y", "z"},
            "the shape's own axis in the frame of the body or part; cone: apex at its positive end")
        .only({"capsule", "cylinder", "cone"})
        .points(
            "points_m",
            [place](T& t) -> std::vector<Vec3>& { return std::invoke(place, t).points_m; }, kPlace,
            "points whose convex hull the solid is, at least 4 and not in one plane")
        .only({"hull"})
        .required();
}

TableOf<WorldItem> world_table() {
    return TableOf<WorldItem>("world", false, "The Bullet world and the length of the run.")
        .word("up", &WorldItem::up, {"y", "z"}, "the world axis that points up")
        .number("gravity_m_s2", &WorldItem::gravity_m_s2, {0, 30},
                "gravity along -up, also of the soil")
        .number("substep_s", &WorldItem::substep_s, {1e-4, 0.05},
                "Bullet's fixed step; a step of the soil is cut into a whole number of them")
        .integer("solver_iterations", &WorldItem::solver_iterations, {1, 1000},
                 "iterations of Bullet's constraint solver")
        .flag("ground_plane", &WorldItem::ground_plane,
              "an endless static plane, on which bodies that leave the soil's box stand")
        .number("ground_height_m", &WorldItem::ground_height_m, kPlace, "height of that plane")
        .number("duration_s", &WorldItem::duration_s, {1e-3, 1e5}, "simulated time of a run")
        .required();
}

TableOf<FillItem> fill_table() {
    using F = FillItem;
    const auto noise = [](auto member) {
        return [member](F & f) -> auto& { return f.noise.*member; };
    };
    return TableOf<F>("fill", true,
                      "Soil put in before the first step; only room free of terrain and other soil "
                      "is filled.")
        .selected_by("kind")
        .word("kind", &F::kind, {"box", "cylinder", "height_map", "noise"}, "the form of the fill")
        .required()
        .text("material", &F::material,
              "one of the soil's materials; its first where the key is missing")
        .vector("min_m", &F::min_m, kPlace, "lower corner")
        .only({"box"})
        .required()
        .vector("max_m", &F::max_m, kPlace, "upper corner")
        .only({"box"})
        .required()
        .vector("base_center_m", &F::base_center_m, kPlace, "centre of the base")
        .only({"cylinder"})
        .required()
        .number("radius_m", &F::radius_m, kLength, "radius")
        .only({"cylinder"})
        .required()
        .number("height_m", &F::height_m, kLength, "height along up")
        .only({"cylinder"})
        .required()
        .text(
            "file", &F::file,
            "grey PNG of 8 or 16 bits, beside the scene; stretched over the grid's floor; at most "
            "8193 x 8193 pixels. Its left edge lies at the low end of x, its top row at that of y, "
            "and of z where y is up, before `yaw_deg`")
        .only({"height_map"})
        .required()
        .number("min_height_m", &F::min_height_m, {0, 1e4},
                "height of black above the grid's floor")
        .only({"height_map"})
        .number("max_height_m", &F::max_height_m, {0, 1e4},
                "height of white above the grid's floor")
        .only({"height_map"})
        .required()
        .number("base_m", noise(&NoiseFill::base_m), {0, 1e4}, "mean height above the grid's floor")
        .only({"noise"})
        .number("amplitude_m", noise(&NoiseFill::amplitude_m), {0, 1e4},
                "half the range of the largest octave")
        .only({"noise"})
        .number("wavelength_m", noise(&NoiseFill::wavelength_m), {1e-2, 1e4},
                "of the largest octave")
        .only({"noise"})
        .integer("octaves", noise(&NoiseFill::octaves), {1, 12},
                 "each half as long as the one before")
        .only({"noise"})
        .number("persistence", noise(&NoiseFill::persistence), kFraction,
                "height of an octave over that of the one before")
        .only({"noise"})
        .integer("seed", noise(&NoiseFill::seed), {0, 2147483647}, "another seed, another ground")
        .only({"noise"});
}

/// From when to when a source or sink works.
template <typename T, typename P>
void add_times(TableOf<T>& table, P place) {
    table
        .number(
            "start_s", [place](T& t) -> double& { return std::invoke(place, t).start_s; }, kTime,
            "works from this time on")
        .number(
            "end_s", [place](T& t) -> double& { return std::invoke(place, t).end_s; }, {0, 1e9},
            "until this time");
}

TableOf<SourceItem> source_table() {
    using S = SourceItem;
    TableOf<S> table("source", true,
                     "A flat region out of which soil comes while the scene runs: the end of a "
                     "pipe, a belt or a hopper, rain. One of the two rates is given. Rates are of "
                     "dry soil: its water comes on top.");
    table.selected_by("shape")
        .choice("shape", {"disc", "rectangle"}, "", "the region",
                [](S& s, size_t i) {
                    s.def.shape = i == 0 ? SourceDef::Shape::disc : SourceDef::Shape::rectangle;
                })
        .required()
        .vector(
            "center_m", [](S& s) -> Vec3& { return s.def.center_m; }, kPlace, "its middle")
        .required()
        .vector(
            "direction", [](S& s) -> Vec3& { return s.def.direction; }, kDirection,
            "the soil leaves along it, square to the region; down where it is zero")
        .number(
            "radius_m", [](S& s) -> double& { return s.def.radius_m; }, kLength, "radius")
        .only({"disc"})
        .required()
        .number(
            "length_m", [](S& s) -> double& { return s.def.length_m; }, kLength,
            "along x, as far as that is square to the direction; else along up")
        .only({"rectangle"})
        .required()
        .number(
            "width_m", [](S& s) -> double& { return s.def.width_m; }, kLength, "across the length")
        .only({"rectangle"})
        .required()
        .number(
            "turn_deg", [](S& s) -> double& { return s.def.turn_rad; }, {-360, 360},
            "turns the rectangle about the direction", kDegree)
        .only({"rectangle"})
        .number(
            "speed_m_s", [](S& s) -> double& { return s.def.speed_m_s; }, {0, 100},
            "with which it leaves; at most 8 voxels a step of the soil")
        .number(
            "spread_deg", [](S& s) -> double& { return s.def.spread_rad; }, {0, 57},
            "half the angle of the jet's cone", kDegree)
        .number(
            "rate_kg_s", [](S& s) -> double& { return s.def.rate_kg_s; }, {0, 1e9},
            "mass of dry soil a second")
        .number(
            "rate_m3_s", [](S& s) -> double& { return s.def.rate_m3_s; }, {0, 1e6},
            "volume of loose soil a second")
        .text(
            "material", [](S& s) -> std::string& { return s.def.material; },
            "one of the soil's materials; its first where the key is missing");
    add_times(table, &S::def);
    return table;
}

TableOf<SinkItem> sink_table() {
    using S = SinkItem;
    TableOf<S> table("sink", true,
                     "A region that takes soil away while the scene runs: a pit, the end of a "
                     "belt, the mouth of a suction pipe.");
    table.selected_by("shape")
        .word("shape", &S::shape, {"box", "sphere", "cylinder"}, "the region")
        .required()
        .vector("size_m", &S::size_m, kLength, "full edge lengths of the box")
        .only({"box"})
        .required()
        .number("radius_m", &S::radius_m, kLength, "radius")
        .only({"sphere", "cylinder"})
        .required()
        .number("height_m", &S::height_m, kLength, "length along its axis, its own z")
        .only({"cylinder"})
        .required()
        .vector(
            "position_m", [](S& s) -> Vec3& { return s.pose.position; }, kPlace, "its middle")
        .required()
        .rotation([](S& s) -> Quat& { return s.pose.rotation; }, "of the region")
        .number("rate_kg_s", &S::rate_kg_s, {0, 1e9},
                "what it takes of dry soil, as far as there is some; all of it in every step where "
                "it is 0")
        .number("water_kg_s", &S::water_kg_s, {-1e9, 1e9},
                "not 0: a well, which moves water instead of soil: out of the region's pores, "
                "below 0 into them");
    add_times(table, [](S& s) -> S& { return s; });
    return table;
}

TableOf<TerrainItem> terrain_table() {
    using T = TerrainItem;
    return TableOf<T>("terrain", true, "Fixed ground that soil cannot enter.")
        .selected_by("kind")
        .word(
            "kind", &T::kind, {"hills", "caves", "mesh"},
            "hills: a noise surface with overhangs; caves: hills with round hollows cut out; "
            "mesh: a closed mesh from a file. Hills and caves may take 2e10 octaves of noise (27 a "
            "voxel near their surface, three times with overhangs), 15 minutes")
        .required()
        .number("base_m", &T::base_m, {-1e4, 1e4}, "mean height above the grid's floor")
        .only({"hills", "caves"})
        .number("amplitude_m", &T::amplitude_m, {0, 1e4}, "half the range of the largest octave")
        .only({"hills", "caves"})
        .number("wavelength_m", &T::wavelength_m, {1e-2, 1e4}, "of the largest octave")
        .only({"hills", "caves"})
        .integer("octaves", &T::octaves, {1, 12}, "each half as long as the one before")
        .only({"hills", "caves"})
        .number("persistence", &T::persistence, kFraction,
                "height of an octave over that of the one before")
        .only({"hills", "caves"})
        .integer("seed", &T::seed, {0, 2147483647}, "another seed, another terrain")
        .only({"hills", "caves"})
        .number("overhang_m", &T::overhang_m, {0, 1e3},
                "how far the surface is pushed sideways by a second noise")
        .only({"hills", "caves"})
        .number("cave_radius_m", &T::cave_radius_m, kLength, "largest radius of a hollow")
        .only({"caves"})
        .number("cave_spacing_m", &T::cave_spacing_m, kLength,
                "distance between hollows, one in each cube of this edge")
        .only({"caves"})
        .text("file", &T::file, "OBJ, STL or DAE beside the scene, or data:PATH; at most 256 MiB")
        .only({"mesh"})
        .required()
        .number("scale", &T::scale, {1e-6, 1e6}, "metres per unit of the file")
        .only({"mesh"})
        .vector(
            "position_m", [](T& t) -> Vec3& { return t.pose.position; }, kPlace,
            "of the mesh's origin")
        .only({"mesh"})
        .rotation([](T& t) -> Quat& { return t.pose.rotation; }, "of the mesh");
}

TableOf<ShapeItem> part_table() {
    using S = ShapeItem;
    TableOf<S> table("body.part", true,
                     "One convex solid of a compound body, in the body's frame.");
    table.selected_by("shape")
        .word("shape", &S::shape, {"box", "sphere", "capsule", "cylinder", "cone", "hull"},
              "the solid")
        .required();
    add_shape_keys(table, [](S& s) -> S& { return s; });
    table
        .vector(
            "position_m", [](S& s) -> Vec3& { return s.pose.position; }, kPlace,
            "in the body's frame")
        .rotation([](S& s) -> Quat& { return s.pose.rotation; }, "of the part in the body's frame")
        .number("mass_kg", &S::mass_kg, kMass,
                "share of the body's mass; give it for all parts or for none (then by volume)")
        .vector("color", &S::color, kFraction,
                "linear red, green, blue; the body's where it is missing");
    return table;
}

TableOf<VisualItem> visual_table() {
    using V = VisualItem;
    TableOf<V> table("body.visual", true,
                     "What pictures show of a body in place of its solids, in the body's frame. "
                     "Looks only: nothing collides with it.");
    table.selected_by("shape")
        .word(
            "shape", [](V& v) -> std::string& { return v.solid.shape; },
            {"box", "sphere", "capsule", "cylinder", "cone", "hull", "mesh"}, "the form")
        .required();
    add_shape_keys(table, &V::solid);
    table
        .text("file", &V::file,
              "OBJ, STL or DAE beside the scene, or data:PATH; at most 256 MiB; without a "
              "`color` its textures show")
        .only({"mesh"})
        .required()
        .number("scale", &V::scale, {1e-6, 1e6}, "metres per unit of the file")
        .only({"mesh"})
        .number("bevel_m", &V::bevel_m, {0, 1e3},
                "how far its edges are cut off, at most a third of the thinnest extent")
        .only({"box", "cylinder"})
        .vector(
            "position_m", [](V& v) -> Vec3& { return v.solid.pose.position; }, kPlace,
            "in the body's frame")
        .rotation([](V& v) -> Quat& { return v.solid.pose.rotation; },
                  "of the form in the body's frame")
        .vector(
            "color", [](V& v) -> std::optional<Vec3>& { return v.solid.color; }, kFraction,
            "linear red, green, blue; the body's where it is missing")
        .integer("repeat_count", &V::repeat_count, {1, 500}, "copies in a row or a ring")
        .vector("repeat_step_m", &V::repeat_step_m, kPlace, "from one copy to the next")
        .number("repeat_turn_deg", &V::repeat_turn_rad, {-360, 360},
                "from one copy to the next, about `repeat_axis` through `repeat_center_m`", kDegree)
        .word("repeat_axis", &V::repeat_axis, {"x", "y", "z"}, "of the body's frame")
        .vector("repeat_center_m", &V::repeat_center_m, kPlace, "a point on that axis")
        .flag("mirror", &V::mirror,
              "each copy once more, on the other side of the plane y = 0 of the body's frame; not "
              "for shape mesh");
    return table;
}

TableOf<BodyItem> body_table() {
    using B = BodyItem;
    TableOf<B> table("body", true, "A rigid body.");
    table.selected_by("shape")
        .text("name", &B::name, "unique")
        .required()
        .word(
            "shape", [](B& b) -> std::string& { return b.shape.shape; },
            {"box", "sphere", "capsule", "cylinder", "cone", "hull", "compound"},
            "the solid, centred on the body's frame; compound: [[body.part]] follow")
        .required();
    add_shape_keys(table, &B::shape);
    table.child<ShapeItem>("part", part_table(), [](B& b) { return &b.parts.emplace_back(); })
        .only({"compound"})
        .child<VisualItem>("visual", visual_table(), [](B& b) { return &b.visuals.emplace_back(); })
        .number("mass_kg", &B::mass_kg, kMass, "0: static (or kinematic)")
        .vector(
            "position_m", [](B& b) -> Vec3& { return b.pose.position; }, kPlace,
            "of the body's frame")
        .rotation([](B& b) -> Quat& { return b.pose.rotation; }, "of the body")
        .flag("kinematic", &B::kinematic,
              "moved by a [[motion]] whatever resists; its mass is ignored")
        .number("friction", &B::friction, {0, 10},
                "Coulomb friction with other bodies; with soil `tool_friction` counts")
        .number("tool_friction", &B::tool_friction, {0, 2},
                "Coulomb friction with soil; the material's where the key is missing")
        .number("tool_adhesion_pa", &B::tool_adhesion_pa, {0, 200e3},
                "shear stress with soil without pressure; the material's where the key is missing")
        .flag("ignore_soil", &B::ignore_soil, "the body passes through soil as if there were none")
        .number("restitution", &B::restitution, kFraction, "share of the speed that a bounce keeps")
        .number("linear_damping", &B::linear_damping, kFraction,
                "share of the speed lost each second")
        .number("angular_damping", &B::angular_damping, kFraction,
                "share of the rotation lost each second")
        .vector("color", &B::color, kFraction, "linear red, green, blue for pictures")
        .vector("velocity_m_s", &B::velocity_m_s, kSpeed, "at the start")
        .vector("angular_velocity_deg_s", &B::angular_velocity_rad_s, {-36000, 36000},
                "at the start, world axes", kDegree)
        .text("group", &B::group, "bodies of one group do not collide with each other");
    return table;
}

TableOf<JointItem> joint_table() {
    using J = JointItem;
    return TableOf<J>("joint", true,
                      "A joint between two bodies, given in world coordinates at the start.")
        .selected_by("kind")
        .text("name", &J::name, "unique")
        .required()
        .word("kind", &J::kind, {"hinge", "slider", "fixed", "point", "suspension"},
              "hinge: turns about the axis; slider: moves along it; point: turns freely; "
              "suspension: a wheel that turns about the axis and springs along `spring_axis`")
        .required()
        .text("parent", &J::parent, "a body, or \"world\"")
        .required()
        .text("child", &J::child,
              "a body; joint positions are the child's against the parent's, 0 at the start")
        .required()
        .vector("point_m", &J::point_m, kPlace, "a point of the joint's axis")
        .required()
        .vector("axis", &J::axis, kDirection,
                "direction of the axis; positive turns follow the right-hand rule")
        .only({"hinge", "slider", "suspension"})
        .number("lower_deg", &J::lower_rad, {-180, 180}, "lower stop", kDegree)
        .only({"hinge"})
        .number("upper_deg", &J::upper_rad, {-180, 180}, "upper stop", kDegree)
        .only({"hinge"})
        .number("lower_m", &J::lower_m, kPlace, "lower stop")
        .only({"slider"})
        .number("upper_m", &J::upper_m, kPlace, "upper stop")
        .only({"slider"})
        .number("motor_torque_n_m", &J::motor_torque_n_m, kForce,
                "largest torque of the motor; 0: no motor")
        .only({"hinge", "suspension"})
        .number("motor_force_n", &J::motor_force_n, kForce,
                "largest force of the motor; 0: no motor")
        .only({"slider"})
        .number("max_velocity_deg_s", &J::max_velocity, {1e-3, 36000},
                "largest velocity of the motor, whatever the [[motion]] asks", kDegree)
        .only({"hinge", "suspension"})
        .number("max_velocity_m_s", &J::max_velocity, {1e-5, 100},
                "largest velocity of the motor, whatever the [[motion]] asks")
        .only({"slider"})
        .vector("spring_axis", &J::spring_axis, kDirection,
                "direction of the spring, square to the axis")
        .only({"suspension"})
        .number("travel_m", &J::travel_m, {0, 10}, "way from the start to either stop")
        .only({"suspension"})
        .number("stiffness_n_m", &J::stiffness_n_m, kForce, "of the spring, relaxed at the start")
        .only({"suspension"})
        .number("damping_n_s_m", &J::damping_n_s_m, kForce, "of the damper")
        .only({"suspension"})
        .flag("collide", &J::collide, "whether the two bodies still collide with each other");
}

TableOf<RobotItem> robot_table() {
    using R = RobotItem;
    using L = RobotLinkItem;
    using J = RobotJointItem;
    using M = RobotMotorItem;
    const std::vector<std::string> collisions{"hull", "components", "decompose", "mesh", "none"};
    const TableOf<L> link =
        TableOf<L>("robot.link", true, "Replaces what the URDF says of a link.")
            .text("link", &L::link, "name of the link in the URDF")
            .required()
            .number("mass_kg", &L::mass_kg, {1e-3, 1e6},
                    "its mass; centre and moments of inertia are then those of its solids, evenly "
                    "dense, where the two keys below are missing")
            .vector("center_of_mass_m", &L::center_of_mass_m, kPlace, "in the link's frame")
            .vector("moments_kg_m2", &L::moments_kg_m2, {0, 1e9},
                    "moments of inertia about the centre of mass, along the link's axes")
            .number("friction", &L::friction, {0, 10}, "with other bodies; else the robot's")
            .number("tool_friction", &L::tool_friction, {0, 2},
                    "Coulomb friction with soil; the material's where the key is missing")
            .number("tool_adhesion_pa", &L::tool_adhesion_pa, {0, 200e3},
                    "shear stress with soil without pressure; the material's where the key is "
                    "missing")
            .flag("ignore_soil", &L::ignore_soil, "the link passes through soil")
            .word("collision", &L::collision, collisions,
                  "what becomes of its collision meshes; the robot's where the key is missing")
            .integer(
                "part_capacity", &L::part_capacity, {1, 500},
                "most solids of a mesh: the largest `components`, or what `decompose` may cut it "
                "into")
            .number("thickness_m", &L::thickness_m, {0, 10},
                    "hulls of the link that are thinner are made so thick, away from the link's "
                    "middle: soil leaks through plates below two voxels")
            .vector("color", &L::color, kFraction, "linear red, green, blue for pictures");
    const TableOf<J> joint =
        TableOf<J>("robot.joint", true, "How a joint of the robot starts.")
            .text("joint", &J::joint, "name of the joint in the URDF")
            .required()
            .flag("locked", &J::locked, "taken as fixed where it starts")
            .number("start_deg", &J::start_rad, kAngle,
                    "position at the start, of a joint that turns; else 0 or the limit next to it",
                    kDegree)
            .number("start_m", &J::start_m, kPlace, "the same of a joint that slides");
    const TableOf<M> motor =
        TableOf<M>("robot.motor", true, "Gives a joint of the robot a motor, for a [[motion]].")
            .text("joint", &M::joint, "name of the joint in the URDF")
            .required()
            .number("torque_n_m", &M::torque_n_m, kForce,
                    "largest torque, of a joint that turns; the URDF's effort where it is missing")
            .number("force_n", &M::force_n, kForce, "largest force, of a joint that slides")
            .number("max_velocity_deg_s", &M::max_velocity_rad_s, {1e-3, 36000},
                    "largest velocity; the URDF's where it is missing", kDegree)
            .number("max_velocity_m_s", &M::max_velocity_m_s, {1e-5, 100},
                    "largest velocity of a joint that slides");
    return TableOf<R>(
               "robot", true,
               "A robot from a URDF: its links become bodies `robot/link`, its joints "
               "`robot/joint`, whose positions are the URDF's; links joined by fixed joints "
               "become one body. Mesh files are looked for beside the URDF, `package://` "
               "names in the folders above it. Pictures show textures: the one of a visual's "
               "`<material>`, and without such the diffuse ones that an OBJ or DAE names. "
               "They are PNG of at most 4096 pixels a side, 256 MiB unpacked in a scene. "
               "What is missing or of another format, JPEG too, is named in one line, and "
               "the colour shows. A `color` of [[robot.link]] hides textures.")
        .text("name", &R::name, "unique")
        .required()
        .text("file", &R::file,
              "the URDF, beside the scene, or data:PATH for a file under $BULLETSOIL_DATA (else "
              "`shared/data` beside the project); a scene whose data is absent is skipped")
        .required()
        .vector(
            "position_m", [](R& r) -> Vec3& { return r.pose.position; }, kPlace, "of the root link")
        .rotation([](R& r) -> Quat& { return r.pose.rotation; },
                  "of the root link; the URDF's z is turned up first")
        .word("build", &R::build, {"bodies", "multibody"},
              "bodies: rigid bodies and constraints; multibody: one btMultiBody (Featherstone), "
              "whose "
              "joints cannot come apart, with a part of its own behind each floating joint")
        .flag("fixed_base", &R::fixed_base, "the root link does not move")
        .flag("self_collide", &R::self_collide,
              "links collide with each other, save those that a joint connects")
        .number("friction", &R::friction, {0, 10}, "of all its links")
        .word("collision", &R::collision, collisions,
              "what becomes of collision meshes; hull: the mesh's convex hull; components: a hull "
              "of each connected part; decompose: the parts cut into convex solids; mesh: the "
              "triangles themselves; none: all solids of the URDF are left out")
        .child<L>("link", link, [](R& r) { return &r.links.emplace_back(); })
        .child<J>("joint", joint, [](R& r) { return &r.joints.emplace_back(); })
        .child<M>("motor", motor, [](R& r) { return &r.motors.emplace_back(); });
}

TableOf<BulletFileItem> bullet_file_table() {
    using F = BulletFileItem;
    return TableOf<F>("bullet_file", true,
                      "What is in a .bullet file, as btDynamicsWorld::serialize writes it: its "
                      "rigid bodies become bodies `name/body`, where those without a name in the "
                      "file are numbered from 0. Its gravity and solver settings are left out.")
        .text("name", &F::name, "unique")
        .required()
        .text("file", &F::file, "beside the scene, or data:PATH as for a robot")
        .required()
        .vector(
            "position_m", [](F& f) -> Vec3& { return f.pose.position; }, kPlace,
            "of the file's origin")
        .rotation([](F& f) -> Quat& { return f.pose.rotation; },
                  "of the file's axes, which are not turned where the scene's `up` is another")
        .flag("ignore_soil", &F::ignore_soil, "its rigid bodies pass through soil");
}

TableOf<TrackItem> track_table() {
    using T = TrackItem;
    using W = TrackWheelItem;
    const TableOf<W> wheel =
        TableOf<W>("track.wheel", true,
                   "A wheel that the track runs round or on: a body `track/wheel` on a hinge "
                   "`track/wheel`, which a [[motion]] drives where it has a motor.")
            .text("name", &W::name, "unique within the track: sprocket, idler, road_wheel_1, ...")
            .required()
            .vector("position_m", &W::position_m, kPlace,
                    "its centre, in the hull's frame; all wheels of a track lie in one plane")
            .required()
            .number("radius_m", &W::radius_m, kLength, "radius of the rim the links run on")
            .required()
            .number("width_m", &W::width_m, kLength, "along the axle")
            .number("mass_kg", &W::mass_kg, {1e-3, 1e6}, "mass")
            .number("friction", &W::friction, {0, 10},
                    "Coulomb friction with links, multiplied by theirs; 3 for a sprocket stands "
                    "for its teeth: round half a turn it then pulls 10000 times the slack side's "
                    "tension")
            .number("motor_torque_n_m", &W::motor_torque_n_m, kForce,
                    "largest torque of the motor; 0: the wheel runs free")
            .number("bearing_torque_n_m", &W::bearing_torque_n_m, kForce,
                    "dry friction of the bearing of a wheel without motor")
            .number("max_velocity_deg_s", &W::max_velocity_rad_s, {1e-3, 36000},
                    "largest velocity of the motor, whatever the [[motion]] asks", kDegree)
            .vector("color", &W::color, kFraction, "linear red, green, blue for pictures");
    return TableOf<T>("track", true,
                      "A track of rigid links round wheels on a body: links `track/link_01`, ... "
                      "hinged to each other by `track/pin_01`, ..., laid along the taut way round "
                      "the wheels. Links touch the wheels and everything else but each other and "
                      "the hull's group. Wheels and links may fall asleep below 3 rad/s.")
        .text("name", &T::name, "unique")
        .required()
        .text("hull", &T::hull, "the body that the wheels turn on; the wheels do not touch it")
        .required()
        .vector(
            "axis", &T::axis, kDirection,
            "of the axles, in the hull's frame: with y forward is x where z is up, and positive "
            "velocities of a motor drive forward")
        .integer("link_count", &T::link_count, {0, 1000},
                 "number of links, at least 3; 0: as `pitch_m` says")
        .number("pitch_m", &T::pitch_m, kLength,
                "length of a link from pin to pin; the nearest that closes is taken")
        .number("link_width_m", &T::link_width_m, kLength, "along the axles")
        .number("link_thickness_m", &T::link_thickness_m, kLength,
                "of the plate; the pins lie in its middle")
        .number("link_mass_kg", &T::link_mass_kg, {1e-3, 1e6}, "mass of a link")
        .number("grouser_height_m", &T::grouser_height_m, {0, 10},
                "of a bar across the link's outer face; 0: none")
        .number("grouser_thickness_m", &T::grouser_thickness_m, kLength, "of that bar")
        .number("guide_height_m", &T::guide_height_m, {0, 10},
                "of the two guides on the inner face that keep the link on the wheels; 0: none")
        .number("pin_torque_n_m", &T::pin_torque_n_m, kForce,
                "dry friction of a pin; without any the upper run swings and does not sleep")
        .number("friction", &T::friction, {0, 10}, "of links with other bodies")
        .number("tool_friction", &T::tool_friction, {0, 2},
                "Coulomb friction of links with soil; the material's where the key is missing")
        .number("tool_adhesion_pa", &T::tool_adhesion_pa, {0, 200e3},
                "shear stress of links with soil without pressure; the material's where the key is "
                "missing")
        .vector("color", &T::color, kFraction, "linear red, green, blue for pictures")
        .child<W>("wheel", wheel, [](T& t) { return &t.wheels.emplace_back(); });
}

TableOf<MotionItem> motion_table() {
    using M = MotionItem;
    using K = MotionKey;
    const TableOf<K> key =
        TableOf<K>("motion.key", true,
                   "A key frame; times rise. All keys of a motion give the same quantity.")
            .number("t_s", &K::t_s, kTime, "time since the start of the run or of the period")
            .required()
            .number("position_deg", &K::position_rad, kAngle, "of a hinge or wheel", kDegree)
            .number("offset_m", &K::offset_m, kPlace, "of a slider")
            .number("velocity_deg_s", &K::velocity_rad_s, {-36000, 36000}, "of a hinge or wheel",
                    kDegree)
            .number("velocity_m_s", &K::velocity_m_s, kSpeed, "of a slider")
            .vector("position_m", &K::position_m, kPlace, "of a kinematic body, world axes")
            .rotation(&K::rotation, "of a kinematic body");
    return TableOf<M>("motion", true,
                      "A scripted movement of a joint's motor or of a kinematic body.")
        .text("joint", &M::joint, "a joint with a motor; or `body`")
        .text("body", &M::body, "a kinematic body; or `joint`")
        .word("interpolation", &M::interpolation, {"smooth", "linear", "step"},
              "between keys; smooth: a cubic that does not overshoot")
        .number("period_s", &M::period_s, kTime, "length of one round where the keys are repeated")
        .integer("repeat_count", &M::repeat_count, {1, 10000}, "rounds")
        .child<K>("key", key, [](M& m) { return &m.motion_keys.emplace_back(); })
        .required();
}

TableOf<ProbeItem> probe_table() {
    using P = ProbeItem;
    return TableOf<P>("probe", true,
                      "Something to measure besides the bodies. Masses of probes, of `mass_in` and "
                      "`mass_out` and `soil_mass_kg` of the summary are of dry soil; `load_kg` of "
                      "a body includes the water.")
        .selected_by("kind")
        .text("name", &P::name, "unique; its column in telemetry.csv")
        .required()
        .word("kind", &P::kind, {"mass_inside", "profile"},
              "mass_inside: dry soil in a box that moves with a body [kg]; profile: heights of the "
              "surface along a line, in profiles.csv")
        .required()
        .text("body", &P::body, "the box moves with it; a box at rest where the key is missing")
        .only({"mass_inside"})
        .text("material", &P::material,
              "only this one of the soil's materials counts; all of them where the key is missing")
        .only({"mass_inside"})
        .vector(
            "size_m", [](P& p) -> Vec3& { return p.region.size_m; }, kLength,
            "full edge lengths of the box")
        .only({"mass_inside"})
        .required()
        .vector(
            "position_m", [](P& p) -> Vec3& { return p.region.pose.position; }, kPlace,
            "of the box in the body's frame")
        .only({"mass_inside"})
        .rotation([](P& p) -> Quat& { return p.region.pose.rotation; },
                  "of the box in the body's frame")
        .vector("from_m", &P::from_m, kPlace, "start of the line; its height does not matter")
        .only({"profile"})
        .required()
        .vector("to_m", &P::to_m, kPlace, "end of the line")
        .only({"profile"})
        .required()
        .integer("sample_count", &P::sample_count, {2, 10000}, "samples along the line")
        .only({"profile"});
}

TableOf<RecordItem> record_table() {
    using R = RecordItem;
    return TableOf<R>("record", false, "What a run writes down.")
        .texts("bodies", &R::bodies,
               "bodies in telemetry.csv; all that can move where the key is missing")
        .number("every_s", &R::every_s, {1e-4, 1e5},
                "time between rows of telemetry.csv, rounded to whole steps")
        .numbers("moments_s", &R::moments_s, kTime,
                 "times of the pictures on the contact sheet and of the samples in a baseline; "
                 "eight evenly spaced where the key is missing");
}

TableOf<CameraItem> camera_table() {
    using C = CameraItem;
    return TableOf<C>("camera", false, "Where pictures are taken from.")
        .vector("eye_m", &C::eye_m, kPlace,
                "the camera; above a corner of the soil where the key is missing")
        .vector("target_m", &C::target_m, kPlace,
                "what it looks at; the soil's centre where the key is missing")
        .number("view_angle_deg", &C::view_angle_rad, {5, 120}, "vertical angle of view", kDegree)
        .text("follow", &C::follow, "a body whose way the camera and its target go along");
}

TableOf<CheckItem> check_table() {
    using C = CheckItem;
    return TableOf<C>("check", true,
                      "Something a run has to show; it prints PASS or FAIL and the figure. "
                      "`soil_conserved` is always checked.")
        .selected_by("kind")
        .word("kind", &C::kind,
              {"soil_conserved", "body_at_rest", "mass_in_region", "repose_angle", "surface_height",
               "distance_travelled", "body_force", "force_steady", "speed_steady", "body_rise",
               "body_height", "energy_not_rising", "no_status", "mass_in", "mass_out"},
              "soil_conserved: units per material at the end are those at the start, and what came "
              "in, without what went out; "
              "body_at_rest: slower than `creep_mm_s` from `by_s` on; mass_in_region: a probe's "
              "reading at a time; repose_angle: mean slope of a pile at the end; surface_height: "
              "height at a place and time; distance_travelled: of a body between start and end; "
              "body_force: largest force of the soil on a body; force_steady, speed_steady: mean "
              "and unsteadiness of the soil's force on a body and of the body's speed over a time, "
              "steps of the soil as samples; body_rise: how far a body comes up above its lowest "
              "place so far; body_height: lowest and highest place of a body; energy_not_rising: "
              "largest rise, in a step of the soil, of the kinetic and potential energy of bodies "
              "(without what they carry); no_status: no sticky condition, and no source that falls "
              "short by a hundredth; mass_in, mass_out: "
              "dry soil that sources have poured in, that sinks and open sides have taken out by a "
              "time")
        .required()
        .text("body", &C::body, "the body")
        .only({"body_at_rest", "distance_travelled", "body_force", "force_steady", "speed_steady",
               "body_rise", "body_height"})
        .required()
        .texts("bodies", &C::bodies,
               "bodies whose energies are added up; all that can move where the key is missing")
        .only({"energy_not_rising"})
        .text("probe", &C::probe, "a probe of kind mass_inside")
        .only({"mass_in_region"})
        .required()
        .number("by_s", &C::by_s, kTime, "at rest from this time on")
        .only({"body_at_rest"})
        .required()
        .number("creep_mm_s", &C::creep_mm_s, {0, 1e4},
                "largest mean speed from `by_s` to the end that still is rest")
        .only({"body_at_rest"})
        .flag("must_sleep", &C::must_sleep, "Bullet has to have put the body to sleep by the end")
        .only({"body_at_rest"})
        .number("at_s", &C::at_s, kTime, "time of the measurement")
        .only({"mass_in_region", "surface_height", "mass_in", "mass_out"})
        .required()
        .number("reference_s", &C::reference_s, kTime,
                "time of the reading that fractions refer to")
        .only({"mass_in_region"})
        .number("min_kg", &C::min_kg, kMass, "least mass")
        .only({"mass_in_region", "mass_in", "mass_out"})
        .number("max_kg", &C::max_kg, kMass, "largest mass")
        .only({"mass_in_region", "mass_in", "mass_out"})
        .number("min_fraction", &C::min_fraction, {0, 100},
                "least share of the reading at `reference_s`")
        .only({"mass_in_region"})
        .number("max_fraction", &C::max_fraction, {0, 100},
                "largest share of the reading at `reference_s`")
        .only({"mass_in_region"})
        .vector("center_m", &C::center_m, kPlace, "a point under the top of the pile, on its base")
        .only({"repose_angle"})
        .required()
        .number("expected_deg", &C::expected_rad, {0, 90}, "the slope", kDegree)
        .only({"repose_angle"})
        .required()
        .number("tolerance_deg", &C::tolerance_rad, {0, 90}, "on either side", kDegree)
        .only({"repose_angle"})
        .required()
        .vector("at_m", &C::at_m, kPlace, "the place; its height does not matter")
        .only({"surface_height"})
        .required()
        .number("expected_m", &C::expected_m, kPlace, "height above the grid's floor")
        .only({"surface_height"})
        .required()
        .number("tolerance_m", &C::tolerance_m, {0, 1e4}, "on either side")
        .only({"surface_height"})
        .required()
        .number("min_m", &C::min_m, kPlace, "least distance, height above the world's origin")
        .only({"distance_travelled", "body_height"})
        .number("max_m", &C::max_m, kPlace, "largest distance, rise, height")
        .only({"distance_travelled", "body_rise", "body_height"})
        .number("from_s", &C::from_s, kTime, "measured from this time on")
        .only({"body_force", "force_steady", "speed_steady", "body_rise", "body_height",
               "energy_not_rising"})
        .number("to_s", &C::to_s, kTime, "measured until this time; to the end where it is missing")
        .only({"body_force", "force_steady", "speed_steady", "body_rise", "body_height",
               "energy_not_rising"})
        .vector("direction", &C::direction, kDirection,
                "the part of the force or velocity along it counts, by default its length")
        .only({"force_steady", "speed_steady"})
        .number("min_n", &C::min_n, {-1e8, 1e8}, "the largest or mean force is at least this")
        .only({"body_force", "force_steady"})
        .number("max_n", &C::max_n, {-1e8, 1e8}, "the largest or mean force is at most this")
        .only({"body_force", "force_steady"})
        .number("min_m_s", &C::min_m_s, kSpeed, "the mean speed is at least this")
        .only({"speed_steady"})
        .number("max_m_s", &C::max_m_s, kSpeed, "the mean speed is at most this")
        .only({"speed_steady"})
        .number("max_deviation_fraction", &C::max_deviation_fraction, {0, 100},
                "largest standard deviation from the straight line that fits the time best (a heap "
                "may grow), as a share of the mean's size")
        .only({"force_steady", "speed_steady"})
        .number("max_range_fraction", &C::max_range_fraction, {0, 100},
                "largest way from the lowest to the highest deviation from that line, likewise")
        .only({"force_steady", "speed_steady"})
        .number("tolerance_j", &C::tolerance_j, {0, 1e9}, "rise that still counts as none")
        .only({"energy_not_rising"})
        .required();
}

}  // namespace

const TableSpec& scene_schema() {
    static const std::shared_ptr<const TableSpec> schema = [] {
        using S = Scene;
        return TableOf<S>("", false, "")
            .text("title", &S::title, "one line, for headings")
            .text("description", &S::description, "what the scene shows and what to look at")
            .child<WorldItem>("world", world_table(), [](S& s) { return &s.world; })
            .required()
            .child<SoilItem>("soil", soil_table(), [](S& s) { return &s.soil.emplace(); })
            .child<MaterialItem>("material", material_table(),
                                 [](S& s) { return &s.materials.emplace_back(); })
            .child<FillItem>("fill", fill_table(), [](S& s) { return &s.fills.emplace_back(); })
            .child<SourceItem>("source", source_table(),
                               [](S& s) { return &s.sources.emplace_back(); })
            .child<SinkItem>("sink", sink_table(), [](S& s) { return &s.sinks.emplace_back(); })
            .child<TerrainItem>("terrain", terrain_table(),
                                [](S& s) { return &s.terrains.emplace_back(); })
            .child<BodyItem>("body", body_table(), [](S& s) { return &s.bodies.emplace_back(); })
            .child<JointItem>("joint", joint_table(), [](S& s) { return &s.joints.emplace_back(); })
            .child<RobotItem>("robot", robot_table(), [](S& s) { return &s.robots.emplace_back(); })
            .child<BulletFileItem>("bullet_file", bullet_file_table(),
                                   [](S& s) { return &s.bullet_files.emplace_back(); })
            .child<TrackItem>("track", track_table(), [](S& s) { return &s.tracks.emplace_back(); })
            .child<RaycastVehicleItem>("raycast_vehicle", raycast_vehicle_table(),
                                       [](S& s) { return &s.raycast_vehicles.emplace_back(); })
            .child<MotionItem>("motion", motion_table(),
                               [](S& s) { return &s.motions.emplace_back(); })
            .child<ProbeItem>("probe", probe_table(), [](S& s) { return &s.probes.emplace_back(); })
            .child<RecordItem>("record", record_table(), [](S& s) { return &s.record; })
            .child<CameraItem>("camera", camera_table(), [](S& s) { return &s.camera; })
            .child<CheckItem>("check", check_table(), [](S& s) { return &s.checks.emplace_back(); })
            .spec();
    }();
    return *schema;
}

std::string schema_markdown() {
    const std::string out =
        "# Scenes\n\n"
        "A scene is a TOML file that says what is in a Bullet world, what soil lies in it, what "
        "moves and what the run\n"
        "has to show. `bsoil run SCENE --out DIR` runs one. Every number carries its unit in its "
        "key. An unknown key, a\n"
        "wrong unit, a value out of range or a name that is not defined is an error with file, "
        "line and column.\n\n"
        "A scene has at most 8 MiB, a dotted key at most 16 parts. A URDF has at most 16 MiB, 1000 "
        "links and elements 100\n"
        "deep.\n\n"
        "This page is printed by `bsoil scene-keys --markdown`; a test compares the two.\n\n"
        "## Top level\n";
    return out + table_markdown(scene_schema());
}

}  // namespace bsoil::scene
