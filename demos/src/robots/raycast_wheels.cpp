#include "robots/raycast_wheels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace bsoil::scene {
namespace {

/// Looks of a wheel, its axle along y or z: a tyre, a rim and bolts.
std::vector<DrawnItem> drawn_wheel(const RaycastWheelItem& wheel, const std::string& axle) {
    constexpr int kBolts = 6;
    std::vector<DrawnItem> items;
    const auto add = [&](double radius_m, double length_m, double bevel_m, Vec3 color) -> Vec3& {
        DrawnItem& item = items.emplace_back();
        item.solid.shape = "cylinder";
        item.solid.radius_m = radius_m;
        item.solid.height_m = length_m;
        item.solid.axis = axle;
        item.solid.color = color;
        item.bevel_m = bevel_m;
        return item.solid.pose.position;
    };
    const double r = wheel.radius_m, w = wheel.width_m;
    add(r, w, 0.15 * std::min(r, w), wheel.color);
    add(0.55 * r, 1.02 * w, 0.05 * r, {0.55, 0.56, 0.58});
    add(0.16 * r, 1.08 * w, 0.03 * r, {0.14, 0.14, 0.15});
    for (int bolt = 0; bolt < kBolts; ++bolt) {
        const double angle = 2 * std::numbers::pi * bolt / kBolts;
        const double along = 0.36 * r * std::cos(angle), up = 0.36 * r * std::sin(angle);
        add(0.06 * r, 1.05 * w, 0, {0.05, 0.05, 0.055}) =
            axle == "y" ? Vec3{along, 0, up} : Vec3{along, up, 0};
    }
    return items;
}

}  // namespace

void add_raycast_wheels(Scene& scene, RaycastVehicleItem& vehicle,
                        std::vector<SchemaError>& errors) {
    const auto error = [&errors](SourcePosition at, std::string text) {
        errors.push_back({at, std::move(text)});
    };
    const BodyItem chassis = *scene.find_body(vehicle.chassis);
    if (!chassis.multibody.empty() || !chassis.bullet_file.empty() || chassis.kinematic ||
        chassis.mass_kg <= 0) {
        return error(vehicle.where("chassis"),
                     fmt::format("\"{}\" must be a rigid body of the scene's own that can move",
                                 vehicle.chassis));
    }
    std::set<std::string> names;
    for (const RaycastWheelItem& wheel : vehicle.wheels) {
        if (!names.insert(wheel.name).second) {
            error(wheel.where("name"),
                  fmt::format("a wheel named \"{}\" is there already; rename one", wheel.name));
        }
    }
    for (size_t k = 1; k < vehicle.drive_keys.size(); ++k) {
        if (vehicle.drive_keys[k].t_s <= vehicle.drive_keys[k - 1].t_s) {
            error(vehicle.drive_keys[k].where("t_s"), "keys must rise in time");
        }
    }
    vehicle.is_y_up = scene.world.up == "y";
    const std::string axle = vehicle.is_y_up ? "z" : "y";
    for (const RaycastWheelItem& wheel : vehicle.wheels) {
        BodyItem body;
        static_cast<SceneItem&>(body) = wheel;
        body.name = vehicle.name + '/' + wheel.name;
        body.pose = chassis.pose * Pose{wheel.position_m, {}};
        body.shape.shape = "cylinder";
        body.shape.radius_m = wheel.radius_m;
        body.shape.height_m = wheel.width_m;
        body.shape.axis = axle;
        body.kinematic = body.is_ghost = body.ignore_soil = true;
        body.color = wheel.color;
        body.drawn = drawn_wheel(wheel, axle);
        scene.bodies.push_back(std::move(body));
    }
}

}  // namespace bsoil::scene
