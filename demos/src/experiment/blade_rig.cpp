/// The soil bin: a blade on a carriage, lowered and then drawn at constant speed.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "rig_world.h"

namespace bsoil::experiment {
namespace {

constexpr double kReliefRad = 30 * std::numbers::pi / 180;

/// A parallelogram across the travel: its face has the rake. Behind the cutting edge its bottom
/// rises by the relief angle, as that of a real blade does, so that it cuts and does not slide on a
/// sole. The frame's origin is the middle of what it would be without relief.
scene::ShapeItem solid_of(const BladeItem& blade) {
    const Vec3 along_face =
        Vec3{-std::cos(blade.rake_rad), 0, std::sin(blade.rake_rad)} * (blade.height_m / 2);
    const Vec3 through{blade.thickness_m / std::sin(blade.rake_rad) / 2, 0, 0};
    const Vec3 relief = along_face * (2 / blade.height_m) *
                        (2 * through.x * std::tan(kReliefRad) / std::sin(blade.rake_rad));
    scene::ShapeItem shape;
    shape.shape = "hull";
    for (const double u : {-1.0, 1.0}) {
        for (const double v : {-1.0, 1.0}) {
            for (const double w : {-1.0, 1.0}) {
                shape.points_m.push_back(along_face * u + through * v +
                                         Vec3{0, w * blade.width_m / 2, 0} +
                                         (u < 0 && v < 0 ? relief : Vec3{}));
            }
        }
    }
    return shape;
}

}  // namespace

Result<RigOutput> run_blade(const RigSetup& setup, const BladeItem& blade,
                            const RigProgress& progress) {
    const double half_height_m = blade.height_m * std::sin(blade.rake_rad) / 2;
    const Vec3 center = bed_center_m(setup);
    const double surface_m = surface_z_m(setup);
    const double gap_m = setup.scene.soil ? setup.scene.soil->def.voxel_m : 0.01;
    const double start_x_m = center.x - blade.travel_m / 2;
    const Vec3 above{start_x_m, center.y, surface_m + gap_m + half_height_m};
    const Vec3 lowered{start_x_m, center.y, surface_m - blade.depth_m + half_height_m};
    const Vec3 end{start_x_m + blade.travel_m, center.y, lowered.z};
    const double lowered_s = (above.z - lowered.z) / blade.lowering_speed_m_s;
    const double end_s = lowered_s + blade.travel_m / blade.speed_m_s;

    scene::Scene scene = setup.scene;
    scene.bodies.push_back(carriage("carriage", above));
    scene.motions.push_back(way_of("carriage", {{0, above}, {lowered_s, lowered}, {end_s, end}}));
    scene::BodyItem& body = scene.bodies.emplace_back();
    body.name = "blade";
    body.shape = solid_of(blade);
    body.mass_kg = blade.mass_kg;
    body.pose.position = above;
    body.group = "rig";
    scene::JointItem& holder = scene.joints.emplace_back();
    holder.name = "holder";
    holder.kind = "fixed";
    holder.parent = "carriage";
    holder.child = "blade";
    holder.point_m = above;

    auto made = RigWorld::create(setup, std::move(scene), {"carriage"});
    if (!made) return Error{made.error()};
    RigWorld& world = **made;
    RigOutput out;
    out.series_columns = {"time_s", "travel_m", "depth_m", "draft_n", "lift_n"};
    Statistics draft_n, lift_n;
    // Hung up by its weight: holder and soil friction both keep the blade's height, and which of
    // them would bear its weight is up to the solver.
    world.set_force("blade", {0, 0, blade.mass_kg * setup.scene.world.gravity_m_s2});
    while (world.time_s() < end_s - world.step_s() / 2) {
        world.step();
        const Vec3 at = world.position("blade");
        const JointReading reading = world.reading("holder");
        const double travel_m = at.x - start_x_m;
        const double lift = -reading.force_n.z;
        out.series.push_back({world.time_s(), travel_m, surface_m - (at.z - half_height_m),
                              reading.force_n.x, lift});
        if (travel_m >= blade.window_from_m) {
            draft_n.add(reading.force_n.x);
            lift_n.add(lift);
        }
        progress(world.time_s() / end_s);
    }
    out.results = {{draft_n.mean(), draft_n.deviation(), lift_n.mean(), lift_n.deviation()}};
    const Status noted = world.note_conditions(out);
    if (!noted) return Error{noted.error()};
    return out;
}

}  // namespace bsoil::experiment
