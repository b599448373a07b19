/// A raycast vehicle's wheel on soil: what it is, and what is told of it.
#pragma once

#include "bsoil/body.h"
#include "bsoil/bullet/precision.h"
#include "bsoil/result.h"

#pragma GCC visibility push(default)
namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION {

/// A wheel as the soil meets it: a cylinder of the radius that btRaycastVehicle::addWheel was
/// given.
struct SoilWheelDef {
    double width_m = 0.3;  ///< 0.01..10
    /// Of wheel and tyre, 0.1..1e5. Only for its motion along the strut and its spin, as a disc's:
    /// its weight is in the chassis.
    double mass_kg = 20;
    double rim_speed_max_m_s = 20;  ///< that the engine drives the rim to, 0.1..1000
    SurfaceFriction surface{};      ///< between wheel and soil
    /// Names the field, its value and its range when something is wrong.
    Status validate() const;
};

/// What soil and wheel did to each other in the last substep.
struct SoilWheelReport {
    bool is_on_soil =
        false;  ///< the soil carries it; else it stands on something rigid or on nothing
    double normal_force_n = 0;  ///< of the soil on the wheel, along the strut
    double traction_n = 0;      ///< forward: thrust less motion resistance
    double side_force_n = 0;    ///< along the axle
    /// Of the soil about the axle, positive: it turns the wheel forward. A wheel that is driven at
    /// a steady spin has its engine's torque here, with the sign turned.
    double torque_n_m = 0;
    double sinkage_m = 0;   ///< of the deepest contact below the local surface
    double spin_rad_s = 0;  ///< positive: rolls forward
    /// Of the rim against the ground: 1 - v / (R spin) when driven, R spin / v - 1 when braked;
    /// -1..1, positive: spins
    double slip = 0;
};

}  // namespace bsoil::bullet::inline BSOIL_BULLET_PRECISION
#pragma GCC visibility pop
