/// The press: a plate on a vertical slider that a motor moves at constant speed.
#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "rig_world.h"
#include "scene/rotations.h"

namespace bsoil::experiment {
namespace {

/// The press is far stronger than any soil a plate stands on [N].
constexpr double kPressForce = 1e7;
/// Unloading ends at this share of the largest force: the load cell reads zero.
constexpr double kUnloadedFraction = 1e-3;

/// Area of the convex hull of points seen from above (Andrew's monotone chain).
double area_from_above_m2(std::vector<Vec3> points) {
    std::sort(points.begin(), points.end(),
              [](Vec3 a, Vec3 b) { return std::pair(a.x, a.y) < std::pair(b.x, b.y); });
    const auto turn = [](Vec3 o, Vec3 a, Vec3 b) {
        return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
    };
    double doubled = 0;
    for (int side = 0; side < 2; ++side) {  // lower chain, then the upper one backwards
        std::vector<Vec3> chain;
        for (const Vec3 p : points) {
            while (chain.size() >= 2 && turn(chain[chain.size() - 2], chain.back(), p) <= 0) {
                chain.pop_back();
            }
            chain.push_back(p);
        }
        for (size_t i = 1; i < chain.size(); ++i) {
            doubled += chain[i - 1].x * chain[i].y - chain[i].x * chain[i - 1].y;
        }
        std::reverse(points.begin(), points.end());
    }
    return doubled / 2;
}

struct PlateSolid {
    scene::BodyItem body;
    double lowest_m = 0;  ///< of the solid, in the body's frame
    double area_m2 = 0;   ///< seen from above
};

PlateSolid solid_of(const PlateItem& plate) {
    PlateSolid solid;
    scene::ShapeItem& shape = solid.body.shape;
    shape.radius_m = plate.radius_m;
    shape.height_m = plate.height_m;
    solid.lowest_m = -plate.height_m / 2;
    solid.area_m2 = std::numbers::pi * plate.radius_m * plate.radius_m;
    if (plate.shape == "rectangle") {
        shape.shape = "box";
        shape.size_m = {plate.length_m, plate.width_m, plate.height_m};
        solid.area_m2 = plate.length_m * plate.width_m;
    } else if (plate.shape == "cone") {
        shape.shape = "cone";  // its apex is up: half a turn
        solid.body.pose.rotation = scene::axis_rotation({1, 0, 0}, std::numbers::pi);
    } else if (plate.shape == "hull") {
        shape.shape = "hull";
        shape.points_m = plate.points_m;
        solid.lowest_m = plate.points_m.front().z;
        for (const Vec3 p : plate.points_m) solid.lowest_m = std::min(solid.lowest_m, p.z);
        solid.area_m2 = area_from_above_m2(plate.points_m);
    } else {
        shape.shape = "cylinder";
    }
    return solid;
}

}  // namespace

Result<RigOutput> run_plate(const RigSetup& setup, const PlateItem& plate,
                            const RigProgress& progress) {
    const double surface_m = surface_z_m(setup);
    const double deepest_m = *std::max_element(plate.reach_m.begin(), plate.reach_m.end());
    const double gap_m = setup.scene.soil ? setup.scene.soil->def.voxel_m : 0.01;

    PlateSolid solid = solid_of(plate);
    const Vec3 center = bed_center_m(setup);
    const Vec3 start{center.x, center.y, surface_m + gap_m - solid.lowest_m};
    scene::Scene scene = setup.scene;
    scene.bodies.push_back(carriage("frame", start));
    solid.body.name = "plate";
    solid.body.mass_kg = plate.mass_kg;
    solid.body.pose.position = start;
    solid.body.group = "rig";
    scene.bodies.push_back(solid.body);
    scene::JointItem slider;
    slider.name = "slider";
    slider.kind = "slider";
    slider.parent = "frame";
    slider.child = "plate";
    slider.point_m = start;
    slider.motor_force_n = kPressForce;
    scene.joints.push_back(slider);

    auto made = RigWorld::create(setup, std::move(scene), {"frame"});
    if (!made) return Error{made.error()};
    RigWorld& world = **made;
    auto* motor = static_cast<btSliderConstraint*>(world.joint("slider").constraint);

    RigOutput out;
    out.series_columns = {"time_s", "sinkage_m", "force_n", "pressure_pa"};
    StationRecorder stations(plate.stations_m.empty() ? plate.reach_m : plate.stations_m);
    double peak_n = 0, sinkage_m = -gap_m;
    const auto step = [&](double velocity_m_s) {
        motor->setTargetLinMotorVelocity(static_cast<btScalar>(velocity_m_s));
        world.step();
        sinkage_m = surface_m - (world.position("plate").z + solid.lowest_m);
        const double weight_n = plate.mass_kg * setup.scene.world.gravity_m_s2;
        const double force_n = weight_n - world.reading("slider").force_n.z;
        peak_n = std::max(peak_n, force_n);
        const std::vector<double> row{sinkage_m, force_n, force_n / solid.area_m2};
        stations.observe(row);
        out.series.push_back({world.time_s(), row[0], row[1], row[2]});
        return force_n;
    };
    for (const double reach_m : plate.reach_m) {
        const double start_s = world.time_s();
        const double expected_s = (reach_m - sinkage_m) / plate.speed_m_s;
        while (sinkage_m < reach_m) {
            step(-plate.speed_m_s);
            progress(sinkage_m / deepest_m);
            if (world.time_s() - start_s > 2 * expected_s + 1) {
                return Error{fmt::format(
                    "the plate stuck at a sinkage of {:.4g} m; lower `reach_m`", sinkage_m)};
            }
        }
        while (plate.unload && sinkage_m > 0 &&
               step(plate.speed_m_s) > kUnloadedFraction * peak_n) {
        }
    }
    out.results = stations.rows();
    const Status noted = world.note_conditions(out);
    if (!noted) return Error{noted.error()};
    return out;
}

}  // namespace bsoil::experiment
