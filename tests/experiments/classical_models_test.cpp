/// The classical models against published closed-form figures.
#include "experiment/classical_models.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "experiment/line_fit.h"

namespace bsoil::experiment::classical_models_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
// Tables give five or six digits.
constexpr double kTableShare = 1e-4;

// kc [N/m^(n+1)], kphi [N/m^(n+2)], n: Wong's table of terrain values
const BekkerSoil kDrySand{990, 1528430, 1.1};  // Land Locomotion Laboratory
const BekkerSoil kLeteSand{102e3, 5301e3, 0.793};
const BekkerSoil kHitSimulant{15.6e3, 2407.4e3, 1.1};  // Ding et al. 2011

TEST(LineFit, is_the_line_of_least_weighted_squares) {
    const Eigen::VectorXd x = Eigen::Vector4d(1, 2, 3, 10), y = Eigen::Vector4d(3, 5, 7, -4);
    // The first three lie on y = 2 x + 1; the last one does not count.
    const auto line = fit_line(x, y, Eigen::Vector4d(1, 2, 3, 0));
    ASSERT_TRUE(line);
    EXPECT_NEAR(line->slope, 2, 1e-12);
    EXPECT_NEAR(line->offset, 1, 1e-12);
    // With it no other line misses them by less.
    const Eigen::VectorXd w = Eigen::Vector4d(1, 2, 3, 0.5);
    const auto best = fit_line(x, y, w);
    ASSERT_TRUE(best);
    const auto missed = [&](double slope, double offset) {
        return w.dot((y.array() - slope * x.array() - offset).square().matrix());
    };
    const double least = missed(best->slope, best->offset);
    for (const double d : {-1e-3, 1e-3}) {
        EXPECT_GT(missed(best->slope + d, best->offset), least);
        EXPECT_GT(missed(best->slope, best->offset + d), least);
    }
    EXPECT_FALSE(fit_line(Eigen::Vector2d(4, 4), Eigen::Vector2d(1, 2), Eigen::Vector2d(1, 1)));
}

TEST(ClassicalModels, bekker_gives_the_tabulated_pressures) {
    EXPECT_NEAR(bekker_pressure_pa(kDrySand, 0.03, 0.01), 9851.96, 9852 * kTableShare);
    EXPECT_NEAR(bekker_pressure_pa(kDrySand, 0.1, 0.1), 122194, 122194 * kTableShare);
    EXPECT_NEAR(bekker_pressure_pa(kLeteSand, 0.03, 0.1), 1401420, 1401420 * kTableShare);
    EXPECT_NEAR(bekker_pressure_pa(kHitSimulant, 0.1, 0.02), 34669.6, 34669.6 * kTableShare);
    EXPECT_EQ(bekker_pressure_pa(kDrySand, 0.1, -0.01), 0);
}

TEST(ClassicalModels, bekker_fit_finds_the_parameters_that_made_the_readings) {
    std::vector<PlateReading> readings{{0.05, 0, 0}, {0.05, 0.01, -3}};  // left out
    for (const double b_m : {0.03, 0.05, 0.1}) {
        for (const double z_m : {0.005, 0.01, 0.02}) {
            readings.push_back({b_m, z_m, bekker_pressure_pa(kLeteSand, b_m, z_m)});
        }
    }
    const BekkerSoil fit = fit_bekker(readings);
    EXPECT_NEAR(fit.n, kLeteSand.n, 1e-9);
    EXPECT_NEAR(fit.kc, kLeteSand.kc, 1e-3);
    EXPECT_NEAR(fit.kphi, kLeteSand.kphi, 1e-2);
    readings.resize(5);  // one plate: all of its stiffness is kphi
    EXPECT_EQ(fit_bekker(readings).kc, 0);
    EXPECT_NEAR(fit_bekker(readings).kphi, kLeteSand.stiffness(0.03), 1e-2);
}

TEST(ClassicalModels, janosi_gives_the_tabulated_shares) {
    EXPECT_NEAR(janosi_share(0.0025, 0.01), 0.221199, 1e-6);
    EXPECT_NEAR(janosi_share(0.01, 0.01), 0.632121, 1e-6);
    EXPECT_NEAR(janosi_share(0.05, 0.01), 0.993262, 1e-6);
    EXPECT_EQ(janosi_share(0.01, 0), 1);
}

TEST(ClassicalModels, janosi_fit_finds_the_curve_that_made_the_readings) {
    const JanosiCurve curve{50e3, 0.008};
    std::vector<ShearReading> readings;
    for (const double j_m : {0.001, 0.003, 0.01, 0.03, 0.4}) {  // the last has all of the strength
        readings.push_back({j_m, curve.at_pa(j_m)});
    }
    const JanosiCurve fit = fit_janosi(readings);
    EXPECT_NEAR(fit.stress_pa, 50e3, 1);
    EXPECT_NEAR(fit.k_m, 0.008, 1e-6);
}

TEST(ClassicalModels, wide_wedge_is_that_of_the_fundamental_earthmoving_equation) {
    // Ngamma and failure angle for phi 35, delta 20 deg (McKyes, Agricultural Engineering Soil
    // Mechanics, 1985), force = gamma d^2 w Ngamma
    struct Case {
        double rake_deg, factor, failure_deg;
    };
    for (const Case& c : {Case{30, 1.71433, 35.5899}, Case{45, 1.60995, 32.8255},
                          Case{60, 1.81962, 28.1061}, Case{90, 4.16193, 16.1734}}) {
        const double width_m = 1e6, depth_m = 0.5, weight_n_m3 = 1800 * 9.81;
        const WedgeForce force = mckyes_ali_wedge(
            {width_m, depth_m, c.rake_deg * kDegree, 20 * kDegree}, weight_n_m3, 35 * kDegree);
        const double expected_n = weight_n_m3 * depth_m * depth_m * width_m * c.factor;
        const double attack = (c.rake_deg + 20) * kDegree;
        EXPECT_NEAR(force.draft_n / (expected_n * std::sin(attack)), 1, kTableShare) << c.rake_deg;
        EXPECT_NEAR(force.lift_n / (-expected_n * std::cos(attack)), 1, kTableShare) << c.rake_deg;
        EXPECT_NEAR(force.failure_angle_rad / kDegree, c.failure_deg, 0.01) << c.rake_deg;
    }
}

TEST(ClassicalModels, wide_upright_wedge_is_coulombs) {
    // Kp = 6.8583 for phi 35, delta 16 deg
    const double depth_m = 0.2, width_m = 1e6;
    const WedgeForce force =
        mckyes_ali_wedge({width_m, depth_m, 90 * kDegree, 16 * kDegree}, 15e3, 35 * kDegree);
    const double passive_n = 0.5 * 15e3 * depth_m * depth_m * width_m * 6.8583;
    EXPECT_NEAR(std::hypot(force.draft_n, force.lift_n) / passive_n, 1, kTableShare);
}

TEST(ClassicalModels, narrow_blade_has_more_resistance_for_its_width) {
    const auto draft_n = [](double width_m) {
        return mckyes_ali_wedge({width_m, 0.2, 90 * kDegree, 0.3}, 15e3, 35 * kDegree).draft_n;
    };
    EXPECT_GT(draft_n(0.1) / 0.1, draft_n(1) / 1);
    EXPECT_GT(draft_n(1), draft_n(0.1));
}

const ShearSoil kShear{250, 31.9 * kDegree, 0.011};
ClassicalWheel wheel_at(double slip) { return {0.15735, 0.15735, 0.165, 80, slip, 0, 0.43, 0.32}; }

TEST(ClassicalModels, locked_smooth_wheel_without_friction_sinks_as_bekkers_towed_one) {
    // z0 = (3 W / ((3 - n) (kc + b kphi) sqrt(D)))^(2 / (2 n + 1)) approximates the rim by a
    // parabola: some percent at 9 mm
    ClassicalWheel wheel = wheel_at(0);
    wheel.peak_stress_c1 = wheel.peak_stress_c2 = 0;
    const WheelForces force = wong_reece_wheel(wheel, kHitSimulant, {0, 0, 0});
    EXPECT_NEAR(force.sinkage_m / 0.00912992, 1, 0.03);
    // the work of compacting its rut is all that holds it back: Rc = b k z0^(n+1) / (n+1)
    EXPECT_NEAR(force.tractive_n, -10.2453, 0.5);
    EXPECT_EQ(force.torque_n_m, 0);
}

TEST(ClassicalModels, wheel_pulls_more_the_more_it_slips) {
    double last_n = -1e9;
    for (const double slip : {-1.0, -0.5, 0.0, 0.2, 0.5, 0.9}) {
        const WheelForces force = wong_reece_wheel(wheel_at(slip), kHitSimulant, kShear);
        EXPECT_GT(force.tractive_n, last_n) << slip;
        EXPECT_EQ(force.lateral_n, 0) << slip;
        last_n = force.tractive_n;
    }
    EXPECT_LT(wong_reece_wheel(wheel_at(-1), kHitSimulant, kShear).torque_n_m, 0);
    EXPECT_GT(wong_reece_wheel(wheel_at(0.5), kHitSimulant, kShear).torque_n_m, 0);
    ClassicalWheel lugs = wheel_at(0.5);
    lugs.shear_radius_m += 0.01;
    EXPECT_GT(wong_reece_wheel(lugs, kHitSimulant, kShear).torque_n_m,
              wong_reece_wheel(wheel_at(0.5), kHitSimulant, kShear).torque_n_m);
}

TEST(ClassicalModels, wheel_that_heads_to_its_left_is_pushed_left) {
    ClassicalWheel wheel = wheel_at(0.2);
    wheel.slip_angle_rad = 15 * kDegree;
    const WheelForces force = wong_reece_wheel(wheel, kHitSimulant, kShear);
    EXPECT_GT(force.lateral_n, 0);
    EXPECT_LT(std::hypot(force.lateral_n, force.tractive_n), 80);
}

}  // namespace
}  // namespace bsoil::experiment::classical_models_test
