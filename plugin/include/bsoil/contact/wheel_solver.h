/// Forces between soil and one wheel of a btRaycastVehicle, for one substep.
#pragma once

#include <span>
#include <vector>

#include "bsoil/contact/contact_patches.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// A wheel on its strut. The soil's patches hold the wheel as they hold a rigid body: each takes
/// out the motion of its point as far as its limits allow.
struct WheelState {
    Vec3 up, forward, axle;  ///< unit, world: away from the soil along the strut, u x a, a
    double radius_m = 0.4;
    double mass_kg = 20;    ///< moves along the strut and spins, as a disc
    double spin_rad_s = 0;  ///< positive: rolls forward
    double rise_m_s = 0;    ///< of the wheel along up, in the last substep
    /// Of the chassis at the wheel, with the gravity of the substep to come across the strut.
    Vec3 chassis_velocity_m_s;
    double forward_mass_kg = 100, side_mass_kg = 100;  ///< the wheel's share of the chassis
    /// The strut's length if the wheel stays at its height, its bounds, its force there and how
    /// much that grows per metre; of it no more than the limit.
    double length_m = 0, length_least_m = 0, length_most_m = 1;
    double strut_n = 0, strut_stiffness_n_m = 0, strut_limit_n = 0;
    double engine_force_n = 0;     ///< of the engine's torque at the rim, positive: forward
    double engine_spin_rad_s = 0;  ///< that the engine does not exceed
    double brake_n_s = 0;          ///< most impulse at the rim
};

/// What the soil offers it.
struct WheelContact {
    std::span<const ContactPatch> patches;
    Vec3 center_m;  ///< of the wheel where the patches were found: points are relative to it
    /// How much the patches' limits along up grow when the wheel sinks.
    double stiffness_n_m = 0;
    Vec3 last_force_n;  ///< of the soil on the wheel in the last substep: where the solver starts
};

/// What solve_wheel() finds, at the end of the substep.
struct WheelForces {
    double rise_m_s = 0, spin_rad_s = 0;
    double normal_n = 0, forward_n = 0, side_n = 0;  ///< of the soil on the wheel
    double torque_n_m = 0;   ///< of the soil about the axle; positive: it turns the wheel forward
    double strut_n = 0;      ///< of the strut on the chassis
    bool is_at_end = false;  ///< the strut is at its full length and pulls the wheel along
};

/// Projected Gauss-Seidel on four unknowns: the speeds of rise, of spin and of the chassis forward
/// and sideways. patch_normal_n: normal force per patch. Cost: some 40 us for 24 patches.
WheelForces solve_wheel(const WheelState& wheel, const WheelContact& contact, double substep_s,
                        std::vector<double>& patch_normal_n);

}  // namespace bsoil
#pragma GCC visibility pop
