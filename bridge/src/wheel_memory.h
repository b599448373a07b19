/// What the wheels of raycast vehicles remember from one substep to the next.
#pragma once

#include <LinearMath/btScalar.h>

#include <limits>
#include <vector>

#include "bsoil/bullet/soil_wheel.h"
#include "bsoil/contact/wheel_solver.h"

namespace bsoil::bullet {

/// What a wheel remembers from one substep to the next.
struct WheelMemory {
    SoilWheelDef def;
    double radius_m = 0;
    int id = -1;                ///< SoilBody::id
    bool is_placed = false;     ///< it has been cast before: what follows is valid
    bool has_met_soil = false;  ///< the soil has seen it where it is
    double length_m = 0;        ///< of the strut
    double rise_m_s = 0, spin_rad_s = 0;
    BodyMotion motion;
    // The soil's side.
    bool was_cast = false;  ///< since the soil's last step
    bool was_in_grid = false;
    Vec3 contact_center_m;  ///< where it was when its patches were found
    // Of the last substep; a chassis that sleeps keeps them.
    bool is_on_soil = false;
    WheelForces forces;
    double strut_most_n = kNoLimitN;  ///< that the strut can give the chassis
    SoilWheelReport report;

    static constexpr double kNoLimitN = std::numeric_limits<btScalar>::max();
};

/// What all wheels of one vehicle remember.
struct VehicleMemory {
    std::vector<WheelMemory> wheels;
    /// Of the soil on all wheels in the last substep: across their struts, and along them.
    Vec3 across_struts_n;
    double normal_n = 0;
};

}  // namespace bsoil::bullet
