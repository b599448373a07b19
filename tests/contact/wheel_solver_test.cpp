// One wheel on its strut, against forces by hand.
#include "bsoil/contact/wheel_solver.h"

#include <gtest/gtest.h>

#include <cmath>

namespace bsoil::wheel_solver_test {
namespace {

constexpr double kRadiusM = 0.04;

/// A wheel of 0.1 kg whose strut is as short as it gets and pushes with 1 N.
WheelState wheel_at_its_end() {
    WheelState wheel;
    wheel.up = {0, 0, 1};
    wheel.axle = {0, 1, 0};
    wheel.forward = cross(wheel.up, wheel.axle);
    wheel.radius_m = kRadiusM;
    wheel.mass_kg = 0.1;
    wheel.forward_mass_kg = wheel.side_mass_kg = 0.14;
    wheel.length_m = wheel.length_least_m = 0;
    wheel.length_most_m = 0.02;
    wheel.strut_n = 1;
    wheel.strut_stiffness_n_m = 45;
    wheel.strut_limit_n = 1e9;
    return wheel;
}

/// Of firm soil under it, 1 rad to both sides.
std::vector<ContactPatch> patches_under(const WheelState& wheel) {
    std::vector<ContactPatch> patches;
    for (int i = -5; i <= 5; ++i) {
        for (const double aside_m : {-0.01, 0.01}) {
            ContactPatch& patch = patches.emplace_back();
            const double angle = 0.2 * i;
            patch.normal = std::sin(angle) * wheel.forward - std::cos(angle) * wheel.up;
            patch.point_m = patch.shear_point_m = kRadiusM * patch.normal + aside_m * wheel.axle;
            patch.normal_limit_n = 100 * std::cos(angle);
            patch.friction = 0.5;
            patch.area_m2 = 1e-4;
        }
    }
    return patches;
}

// At rest the soil gives what the strut pushes with, whatever it gave before. The end of the strut
// held what the first rounds of the solver gave too much: 1.76 N in the first substep.
TEST(WheelSolver, soil_gives_a_wheel_at_the_end_of_its_strut_what_that_pushes_with) {
    const WheelState wheel = wheel_at_its_end();
    const std::vector<ContactPatch> patches = patches_under(wheel);
    for (const double last_n : {0.0, 1.0, 2.0, 5.0}) {
        std::vector<double> patch_normal_n;
        WheelContact contact;
        contact.patches = patches;
        contact.last_force_n = last_n * wheel.up;
        const WheelForces forces = solve_wheel(wheel, contact, 1.0 / 30, patch_normal_n);
        EXPECT_NEAR(forces.normal_n, 1, 0.01) << last_n;
        EXPECT_NEAR(forces.rise_m_s, 0, 1e-6) << last_n;
    }
}

// Where it is pushed down by the chassis it goes along.
TEST(WheelSolver, a_wheel_at_the_end_of_its_strut_goes_down_with_the_chassis) {
    constexpr double kSubstepS = 1.0 / 30, kFallMS = 0.3;
    WheelState wheel = wheel_at_its_end();
    wheel.length_m = wheel.length_least_m - kSubstepS * kFallMS;
    std::vector<double> patch_normal_n;
    const std::vector<ContactPatch> patches = patches_under(wheel);
    WheelContact contact;
    contact.patches = patches;
    const WheelForces forces = solve_wheel(wheel, contact, kSubstepS, patch_normal_n);
    EXPECT_NEAR(forces.rise_m_s, -kFallMS, 0.01 * kFallMS);
}

// Nothing but the soil turns it: a disc has half of m r2.
TEST(WheelSolver, torque_of_the_soil_is_what_turns_a_free_wheel) {
    constexpr double kSubstepS = 1.0 / 240;
    const double inertia_kg_m2 = 0.5 * 0.1 * kRadiusM * kRadiusM;
    for (const double spin_rad_s : {40.0, -40.0}) {
        WheelState wheel = wheel_at_its_end();
        wheel.spin_rad_s = spin_rad_s;
        std::vector<double> patch_normal_n;
        const std::vector<ContactPatch> patches = patches_under(wheel);
        WheelContact contact;
        contact.patches = patches;
        const WheelForces forces = solve_wheel(wheel, contact, kSubstepS, patch_normal_n);
        EXPECT_LT(forces.torque_n_m * spin_rad_s, 0) << "against the spin";
        EXPECT_NEAR(forces.torque_n_m, inertia_kg_m2 * (forces.spin_rad_s - spin_rad_s) / kSubstepS,
                    1e-9 * std::abs(forces.torque_n_m));
    }
}

}  // namespace
}  // namespace bsoil::wheel_solver_test
