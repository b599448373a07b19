/// Wheels of raycast vehicles in a snapshot.
#pragma once

#include <string>
#include <utility>

#include "bsoil/limits.h"
#include "bsoil/snapshot_file.h"
#include "patch_stream.h"
#include "wheel_memory.h"

namespace bsoil::bullet {

inline void list(StateStream& stream, SoilWheelReport& report) {
    stream(report.is_on_soil, report.normal_force_n, report.traction_n, report.side_force_n,
           report.torque_n_m, report.sinkage_m, report.spin_rad_s, report.slip);
}

inline void list(StateStream& stream, WheelForces& forces) {
    stream(forces.rise_m_s, forces.spin_rad_s, forces.normal_n, forces.forward_n, forces.side_n,
           forces.torque_n_m, forces.strut_n, forces.is_at_end);
}

inline void list(StateStream& stream, WheelMemory& wheel) {
    SoilWheelDef& def = wheel.def;
    stream(def.width_m, def.mass_kg, def.rim_speed_max_m_s, def.surface.friction,
           def.surface.adhesion_pa, wheel.radius_m);
    stream(wheel.id, wheel.is_placed, wheel.has_met_soil, wheel.length_m, wheel.rise_m_s,
           wheel.spin_rad_s);
    list(stream, wheel.motion);
    stream(wheel.was_cast, wheel.was_in_grid, wheel.contact_center_m, wheel.is_on_soil,
           wheel.strut_most_n);
    list(stream, wheel.forces);
    list(stream, wheel.report);
    if (wheel.id < 0 || wheel.id > limits::kBodyIdMost) stream.refuse();
}

inline void list(StateStream& stream, VehicleMemory& vehicle) {
    stream.list(vehicle.wheels, 300, [&](WheelMemory& wheel) { list(stream, wheel); });
    stream(vehicle.across_struts_n, vehicle.normal_n);
    if (vehicle.wheels.empty()) stream.refuse();
}

/// How a wheel that was saved differs; empty: not at all.
inline std::string difference(const WheelMemory& saved, const WheelMemory& here) {
    const std::pair<const char*, double WheelMemory::*> own[] = {
        {"m_wheelsRadius", &WheelMemory::radius_m}};
    const std::pair<const char*, double SoilWheelDef::*> of_def[] = {
        {"width_m", &SoilWheelDef::width_m},
        {"mass_kg", &SoilWheelDef::mass_kg},
        {"rim_speed_max_m_s", &SoilWheelDef::rim_speed_max_m_s}};
    const std::pair<const char*, double SurfaceFriction::*> of_surface[] = {
        {"friction", &SurfaceFriction::friction}, {"adhesion_pa", &SurfaceFriction::adhesion_pa}};
    std::string out;
    const auto compare = [&out](const auto& fields, const auto& a, const auto& b) {
        for (const auto& [name, field] : fields) {
            if (out.empty() && a.*field != b.*field) {
                out = std::string(name) + " " + std::to_string(b.*field) + ", in the snapshot " +
                      std::to_string(a.*field);
            }
        }
    };
    compare(own, saved, here);
    compare(of_def, saved.def, here.def);
    compare(of_surface, saved.def.surface, here.def.surface);
    return out;
}

}  // namespace bsoil::bullet
