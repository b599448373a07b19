/// The single-wheel tester: a driven wheel on a carriage that is free to move up and down.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "rig_world.h"
#include "scene/rotations.h"

namespace bsoil::experiment {
namespace {

/// The motor holds its speed against any soil [N m].
constexpr double kAxleTorque = 1e6;
/// Between two passes the carriage takes this long for each of its ways: up, back and down [s].
constexpr double kReturnWayS = 1;

/// Rim speed and travel speed of a slip ratio [m/s].
struct Speeds {
    double travel_m_s, rim_m_s;
};
Speeds speeds_of(const TractionItem& wheel) {
    const double s = wheel.slip_ratio;
    // rim speed over travel speed is 1 / (1 - s), or 1 + s of a braked wheel
    if (wheel.held == "travel") {
        return {wheel.speed_m_s, s >= 0 ? wheel.speed_m_s / (1 - s) : wheel.speed_m_s * (1 + s)};
    }
    return {s >= 0 ? wheel.speed_m_s * (1 - s) : wheel.speed_m_s / (1 + s), wheel.speed_m_s};
}

/// When each pass over the bed settles, travels and ends.
class Passes {
  public:
    explicit Passes(const TractionItem& wheel)
        : settle_s_(wheel.settle_s),
          travel_s_(wheel.travel_m / wheel.speed_m_s),
          count_(wheel.earlier_passes + 1) {}

    double start_s(int pass) const { return pass * (settle_s_ + travel_s_ + 3 * kReturnWayS); }
    double travel_from_s(int pass) const { return start_s(pass) + settle_s_; }
    double travel_to_s(int pass) const { return travel_from_s(pass) + travel_s_; }
    double end_s() const { return travel_to_s(count_ - 1); }
    int at(double time_s) const {
        int pass = 0;
        while (pass + 1 < count_ && time_s >= start_s(pass + 1)) ++pass;
        return pass;
    }
    int count() const { return count_; }

  private:
    double settle_s_, travel_s_;
    int count_;
};

/// Of the carriage: every pass from start to end, and back through the air.
std::vector<WayPoint> carriage_way(const Passes& passes, Vec3 start, Vec3 end, double lift_m) {
    const Vec3 lift{0, 0, lift_m};
    std::vector<WayPoint> way;
    for (int pass = 0; pass < passes.count(); ++pass) {
        const double to_s = passes.travel_to_s(pass);
        way.push_back({passes.start_s(pass), start});
        way.push_back({passes.travel_from_s(pass), start});
        way.push_back({to_s, end});
        if (pass + 1 == passes.count()) break;
        way.push_back({to_s + kReturnWayS, end + lift});
        way.push_back({to_s + 2 * kReturnWayS, start + lift});
    }
    return way;
}

/// Rim and grousers about the y axis.
std::vector<scene::ShapeItem> solids_of(const TractionItem& wheel) {
    std::vector<scene::ShapeItem> solids(1);
    solids[0].shape = "cylinder";
    solids[0].axis = "y";
    solids[0].radius_m = wheel.radius_m;
    solids[0].height_m = wheel.width_m;
    for (int i = 0; i < wheel.grouser_count; ++i) {
        const double angle = 2 * std::numbers::pi * i / wheel.grouser_count;
        // from inside the rim, so that no gap is left beside the box's corners
        const double root_m = wheel.radius_m * 0.9;
        const double top_m = wheel.radius_m + wheel.grouser_height_m;
        const double middle_m = (root_m + top_m) / 2;
        scene::ShapeItem& grouser = solids.emplace_back();
        grouser.shape = "box";
        grouser.size_m = {wheel.grouser_thickness_m, wheel.width_m, top_m - root_m};
        grouser.pose.position = {middle_m * std::sin(angle), 0, middle_m * std::cos(angle)};
        grouser.pose.rotation = scene::axis_rotation({0, 1, 0}, angle);
    }
    return solids;
}

}  // namespace

double carriage_way_m(const TractionItem& wheel) {
    return speeds_of(wheel).travel_m_s * wheel.travel_m / wheel.speed_m_s;
}

Result<RigOutput> run_traction(const RigSetup& setup, const TractionItem& wheel,
                               const RigProgress& progress) {
    const Speeds speeds = speeds_of(wheel);
    const Passes passes(wheel);
    const double end_s = passes.end_s();
    const double way_m = carriage_way_m(wheel);
    const double surface_m = surface_z_m(setup);
    const double grouser_m = wheel.grouser_count > 0 ? wheel.grouser_height_m : 0;
    const Vec3 center = bed_center_m(setup);
    const Vec3 start{center.x - way_m / 2, center.y, surface_m + wheel.radius_m + grouser_m};
    const Vec3 end{start.x + way_m, start.y, start.z};
    const Quat yaw = scene::axis_rotation({0, 0, 1}, wheel.slip_angle_rad);
    const Vec3 heading = rotate(yaw, {1, 0, 0}), axle = rotate(yaw, {0, 1, 0});

    scene::Scene scene = setup.scene;
    scene.bodies.push_back(carriage("carriage", start));
    // The slider lets the wheel hang two radii below the carriage.
    scene.motions.push_back(
        way_of("carriage", carriage_way(passes, start, end, 5 * wheel.radius_m)));
    scene::BodyItem fork;  // between slider and axle; it lies inside the wheel
    fork.name = "fork";
    fork.shape.shape = "box";
    fork.shape.size_m = {wheel.radius_m, wheel.width_m, wheel.radius_m};
    fork.mass_kg = wheel.carriage_mass_kg;
    fork.pose = {start, yaw};
    fork.group = "rig";
    scene.bodies.push_back(fork);
    scene::BodyItem body;
    body.name = "wheel";
    body.shape.shape = "compound";
    body.parts = solids_of(wheel);
    body.mass_kg = wheel.wheel_mass_kg;
    body.friction = wheel.friction;
    if (wheel.grouser_count == 0) body.tool_friction = wheel.rim_friction;
    body.pose = {start, yaw};
    body.group = "rig";
    scene.bodies.push_back(body);
    scene::JointItem slider;
    slider.name = "slider";
    slider.kind = "slider";
    slider.parent = "carriage";
    slider.child = "fork";
    slider.point_m = start;
    slider.lower_m = -2 * wheel.radius_m;  // where no soil holds it, the wheel hangs here
    slider.upper_m = 2 * wheel.radius_m;
    scene.joints.push_back(slider);
    scene::JointItem axle_joint;
    axle_joint.name = "axle";
    axle_joint.kind = "hinge";
    axle_joint.parent = "fork";
    axle_joint.child = "wheel";
    axle_joint.point_m = start;
    axle_joint.axis = axle;
    axle_joint.motor_torque_n_m = kAxleTorque;
    scene.joints.push_back(axle_joint);

    auto made = RigWorld::create(setup, std::move(scene), {"carriage", "fork"});
    if (!made) return Error{made.error()};
    RigWorld& world = **made;
    auto* motor = static_cast<btHingeConstraint*>(world.joint("axle").constraint);
    const double gravity = setup.scene.world.gravity_m_s2;
    const double wheel_weight_n = wheel.wheel_mass_kg * gravity;
    const double weight_n = wheel_weight_n + wheel.carriage_mass_kg * gravity;

    RigOutput out;
    out.series_columns = {"time_s",          "travel_m",   "drawbar_pull_n",
                          "side_force_n",    "tractive_n", "lateral_n",
                          "vertical_load_n", "torque_n_m", "sinkage_m"};
    std::vector<Statistics> window(out.series_columns.size() - 2);
    while (world.time_s() < end_s - world.step_s() / 2) {
        const int pass = passes.at(world.time_s());
        const double in_pass_s = world.time_s() - passes.start_s(pass);
        const bool is_over = world.time_s() > passes.travel_to_s(pass) - world.step_s() / 2;
        const double settled =
            is_over ? 0 : (wheel.settle_s > 0 ? std::min(1.0, in_pass_s / wheel.settle_s) : 1.0);
        world.set_force("fork", {0, 0, weight_n - settled * wheel.load_n});
        const bool travels = !is_over && in_pass_s > wheel.settle_s - world.step_s() / 2;
        motor->setMotorTargetVelocity(
            static_cast<btScalar>(travels ? speeds.rim_m_s / wheel.radius_m : 0));
        world.step();
        const Vec3 at = world.position("wheel");
        const Vec3 pull = -world.reading("slider").force_n;
        const JointReading at_axle = world.reading("axle");
        const std::vector<double> values{pull.x,
                                         pull.y,
                                         dot(pull, heading),
                                         dot(pull, axle),
                                         wheel_weight_n - at_axle.force_n.z,
                                         dot(at_axle.torque_n_m, axle),
                                         surface_m - (at.z - wheel.radius_m)};
        out.series.push_back({world.time_s(), at.x - start.x});
        out.series.back().insert(out.series.back().end(), values.begin(), values.end());
        const double travelled_s = world.time_s() - passes.travel_from_s(passes.count() - 1);
        if (travelled_s * wheel.speed_m_s >= wheel.window_from_m) {
            for (size_t i = 0; i < values.size(); ++i) window[i].add(values[i]);
        }
        progress(world.time_s() / end_s);
    }
    std::vector<double>& row = out.results.emplace_back();
    for (const Statistics& quantity : window) {
        row.push_back(quantity.mean());
        row.push_back(quantity.deviation());
    }
    const Status noted = world.note_conditions(out);
    if (!noted) return Error{noted.error()};
    return out;
}

}  // namespace bsoil::experiment
