/// The bevameter's shear head: a plate with grousers under constant normal load, turned (annulus)
/// or drawn (box).
#include <algorithm>
#include <cmath>
#include <numbers>

#include "rig_world.h"
#include "scene/rotations.h"

namespace bsoil::experiment {
namespace {

/// The motor holds its speed against any soil [N m].
constexpr double kShearTorque = 1e7;
/// Convex sectors an annulus is made of: chords lie within 0.6 % of the radius of the arc.
constexpr int kSectorCount = 32;
/// The way is longer than asked for, so that a station at its end is passed.
constexpr double kOvershoot = 1.02;
/// A head without stations of its own is recorded this often.
constexpr int kStationCount = 10;

/// A sector of the annulus between two angles, from the plane z = 0 up.
scene::ShapeItem sector(const ShearItem& shear, double from, double to) {
    scene::ShapeItem shape;
    shape.shape = "hull";
    for (const double angle : {from, to}) {
        for (const double radius : {shear.inner_radius_m, shear.outer_radius_m}) {
            for (const double z : {0.0, shear.height_m}) {
                shape.points_m.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
            }
        }
    }
    return shape;
}

scene::ShapeItem box(Vec3 center, Vec3 size_m) {
    scene::ShapeItem shape;
    shape.shape = "box";
    shape.size_m = size_m;
    shape.pose.position = center;
    return shape;
}

/// Plate and grousers; the plate's lower face lies at z = 0 of the body's frame.
std::vector<scene::ShapeItem> solids_of(const ShearItem& shear) {
    std::vector<scene::ShapeItem> solids;
    const double t = shear.grouser_thickness_m, h = shear.grouser_height_m;
    if (shear.head == "box") {
        solids.push_back(
            box({0, 0, shear.height_m / 2}, {shear.length_m, shear.width_m, shear.height_m}));
        for (int i = 0; i < shear.grouser_count; ++i) {
            const double x = shear.length_m * ((i + 0.5) / shear.grouser_count - 0.5);
            solids.push_back(box({x, 0, -h / 2}, {t, shear.width_m, h}));
        }
        return solids;
    }
    for (int i = 0; i < kSectorCount; ++i) {
        solids.push_back(sector(shear, 2 * std::numbers::pi * i / kSectorCount,
                                2 * std::numbers::pi * (i + 1) / kSectorCount));
    }
    const double middle_m = (shear.inner_radius_m + shear.outer_radius_m) / 2;
    for (int i = 0; i < shear.grouser_count; ++i) {
        const double angle = 2 * std::numbers::pi * i / shear.grouser_count;
        scene::ShapeItem& vane = solids.emplace_back(
            box({middle_m * std::cos(angle), middle_m * std::sin(angle), -h / 2},
                {shear.outer_radius_m - shear.inner_radius_m, t, h}));
        vane.pose.rotation = scene::axis_rotation({0, 0, 1}, angle);
    }
    return solids;
}

}  // namespace

Result<RigOutput> run_shear(const RigSetup& setup, const ShearItem& shear,
                            const RigProgress& progress) {
    const bool turns = shear.head == "annulus";
    const double outer = shear.outer_radius_m, inner = shear.inner_radius_m;
    const double area_m2 =
        turns ? std::numbers::pi * (outer * outer - inner * inner) : shear.length_m * shear.width_m;
    const double middle_m = (outer + inner) / 2;
    // moment of a shear stress of 1 Pa all over an annulus
    const double moment_m3 =
        2 * std::numbers::pi / 3 * (outer * outer * outer - inner * inner * inner);
    const double way_m = shear.displacement_m * kOvershoot;
    const double end_s = shear.settle_s + way_m / shear.speed_m_s;
    const double surface_m = surface_z_m(setup);
    const double grouser_m = shear.grouser_count > 0 ? shear.grouser_height_m : 0;
    const Vec3 center = bed_center_m(setup);
    const double carried_m = turns ? 0 : way_m;
    const Vec3 start{center.x - carried_m / 2, center.y, surface_m + grouser_m};
    const Vec3 end{start.x + carried_m, start.y, start.z};

    scene::Scene scene = setup.scene;
    scene.bodies.push_back(carriage("carriage", start));
    scene.motions.push_back(
        way_of("carriage", {{0, start}, {shear.settle_s, start}, {end_s, end}}));
    scene::BodyItem holder;  // between slider and head
    holder.name = "holder";
    holder.shape.shape = "box";
    const double holder_m = turns ? outer : std::min(shear.length_m, shear.width_m);
    holder.shape.size_m = {holder_m, holder_m, holder_m};
    holder.mass_kg = shear.mass_kg / 2;
    holder.pose.position = start;
    holder.pose.position.z += holder_m;
    holder.group = "rig";
    scene.bodies.push_back(holder);
    scene::BodyItem head;
    head.name = "head";
    head.shape.shape = "compound";
    head.parts = solids_of(shear);
    head.mass_kg = shear.mass_kg / 2;
    head.friction = shear.friction;
    head.pose.position = start;
    head.group = "rig";
    scene.bodies.push_back(head);
    scene::JointItem slider;
    slider.name = "slider";
    slider.kind = "slider";
    slider.parent = "carriage";
    slider.child = "holder";
    slider.point_m = start;
    slider.lower_m = -setup.bed.depth_m;  // where no soil holds it, the head hangs here
    slider.upper_m = setup.bed.depth_m;
    scene.joints.push_back(slider);
    scene::JointItem drive;
    drive.name = "drive";
    drive.kind = turns ? "hinge" : "fixed";
    drive.parent = "holder";
    drive.child = "head";
    drive.point_m = start;
    drive.motor_torque_n_m = kShearTorque;
    scene.joints.push_back(drive);

    auto made = RigWorld::create(setup, std::move(scene), {"carriage", "holder"});
    if (!made) return Error{made.error()};
    RigWorld& world = **made;
    auto* motor =
        turns ? static_cast<btHingeConstraint*>(world.joint("drive").constraint) : nullptr;
    const double gravity = setup.scene.world.gravity_m_s2;
    const double head_weight_n = shear.mass_kg / 2 * gravity;
    const double load_n = shear.normal_stress_pa * area_m2;

    std::vector<double> at_m = shear.stations_m;
    for (int i = 1; shear.stations_m.empty() && i <= kStationCount; ++i) {
        at_m.push_back(shear.displacement_m * i / kStationCount);
    }
    StationRecorder stations(at_m);
    RigOutput out;
    out.series_columns = {"time_s", "displacement_m", "shear_stress_pa", "normal_stress_pa",
                          "sinkage_m"};
    while (world.time_s() < end_s && stations.rows().size() < at_m.size()) {
        const double settled =
            shear.settle_s > 0 ? std::min(1.0, world.time_s() / shear.settle_s) : 1.0;
        world.set_force("holder", {0, 0, shear.mass_kg * gravity - settled * load_n});
        const bool sheared = world.time_s() > shear.settle_s - world.step_s() / 2;
        if (motor) {
            motor->setMotorTargetVelocity(
                static_cast<btScalar>(sheared ? shear.speed_m_s / middle_m : 0));
        }
        world.step();
        const JointReading reading = world.reading("drive");
        const Vec3 at = world.position("head");
        const double stress_pa =
            turns ? reading.torque_n_m.z / moment_m3 : reading.force_n.x / area_m2;
        const std::vector<double> row{
            turns ? world.joint("drive").position * middle_m : at.x - start.x, stress_pa,
            (head_weight_n - reading.force_n.z) / area_m2, surface_m - at.z};
        out.series.push_back({world.time_s()});
        out.series.back().insert(out.series.back().end(), row.begin(), row.end());
        if (sheared) stations.observe(row);
        progress(world.time_s() / end_s);
    }
    out.results = stations.rows();
    const Status noted = world.note_conditions(out);
    if (!noted) return Error{noted.error()};
    return out;
}

}  // namespace bsoil::experiment
