/// The keys of raycast vehicles.
#include "schema_table.h"

namespace bsoil::scene {

TableOf<RaycastVehicleItem> raycast_vehicle_table() {
    using V = RaycastVehicleItem;
    using W = RaycastWheelItem;
    const TableOf<W> wheel =
        TableOf<W>("raycast_vehicle.wheel", true,
                   "A wheel at the end of a strut: the soil meets it as a cylinder, and pictures "
                   "show it as a body `vehicle/wheel`. Telemetry and checks have the soil's force "
                   "on that body and its sinkage; its torque and its load read 0. Those of the "
                   "chassis are of what of itself touches soil, without the wheels.")
            .text("name", &W::name, "unique within the vehicle: front_left, ...")
            .required()
            .vector("position_m", &W::position_m, {-1e4, 1e4},
                    "its centre in the chassis's frame, with the strut at its rest length")
            .required()
            .number("radius_m", &W::radius_m, {1e-3, 100}, "radius")
            .required()
            .number("width_m", &W::width_m, {0.01, 10}, "along the axle")
            .number("mass_kg", &W::mass_kg, {0.1, 1e5},
                    "of wheel and tyre, for its spin and its motion along the strut; its weight is "
                    "the chassis's")
            .flag("driven", &W::is_driven, "the engine turns it")
            .flag("steered", &W::is_steered, "the steering turns it")
            .vector("color", &W::color, kFraction, "linear red, green, blue of its tyre");
    const TableOf<RaycastKey> key =
        TableOf<RaycastKey>("raycast_vehicle.key", true,
                            "What the driver does at a time, linear between keys; without keys the "
                            "vehicle stands.")
            .number("t_s", &RaycastKey::t_s, {0, 1e5},
                    "the time; later than that of the key before")
            .required()
            .number("throttle", &RaycastKey::throttle, {-1, 1},
                    "share of `engine_force_n`; negative: backward")
            .number("steering", &RaycastKey::steering, {-1, 1},
                    "share of `steering_deg`; positive: to the left")
            .number("brake", &RaycastKey::brake, kFraction, "share of `brake_force_n`");
    return TableOf<V>("raycast_vehicle", true,
                      "A btRaycastVehicle: a chassis on struts with wheels that are rays for "
                      "Bullet and wheels for the soil (docs/vehicles.md). Forward is x of the "
                      "chassis's frame, whose up is the scene's. Suspension as Bullet has it, per "
                      "mass of the chassis.")
        .text("name", &V::name, "unique")
        .required()
        .text("chassis", &V::chassis,
              "the body that the struts stand on; one that can move. Its own axes are taken for "
              "its principal ones")
        .required()
        .number("engine_force_n", &V::engine_force_n, {0, 1e8},
                "at the rims of all driven wheels together, at full throttle")
        .number("brake_force_n", &V::brake_force_n, {0, 1e8},
                "at the rims of all wheels together, at full brake")
        .number("steering_deg", &V::steering_rad, {0, 80}, "largest angle of steered wheels",
                kDegree)
        .number("max_speed_m_s", &V::max_speed_m_s, {0.1, 1000},
                "to which the engine drives a rim on soil")
        .number("rest_length_m", &V::rest_length_m, {0.01, 10}, "of the struts")
        .number("travel_m", &V::travel_m, {0.001, 10}, "of the struts, either way")
        .number("stiffness_1_s2", &V::stiffness_1_s2, {0.1, 1e4}, "of the struts, per mass")
        .number("damping_down_1_s", &V::damping_down_1_s, {0, 1e3},
                "while a strut is compressed, per mass")
        .number("damping_up_1_s", &V::damping_up_1_s, {0, 1e3},
                "while a strut gets longer, per mass")
        .number("strut_force_n", &V::strut_force_n, {0, 1e9}, "the most that a strut gives")
        .number("friction_slip", &V::friction_slip, {0, 100},
                "friction on what is rigid; on soil it is the soil's")
        .number("roll_influence", &V::roll_influence, kFraction,
                "share of a side force's lever that rolls the chassis")
        .number("tool_friction", &V::tool_friction, {0, 2},
                "of the wheels with soil; the material's where it is missing")
        .number("tool_adhesion_pa", &V::tool_adhesion_pa, {0, 200e3},
                "of the wheels with soil; the material's where it is missing")
        .child<W>("wheel", wheel, [](V& v) { return &v.wheels.emplace_back(); })
        .required()
        .child<RaycastKey>("key", key, [](V& v) { return &v.drive_keys.emplace_back(); });
}

}  // namespace bsoil::scene
