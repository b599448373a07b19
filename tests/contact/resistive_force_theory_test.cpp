#include "bsoil/contact/resistive_force_theory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "measured_data.h"

namespace bsoil::resistive_force_theory_test {
namespace {

constexpr Vec3 kUp{0, 0, 1};
constexpr double kRough = 1e9;  ///< friction that cuts nothing

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

TEST(ResistiveForceTheory, stresses_equal_the_published_check_values) {
    std::ifstream file(measured_data("rft_spot_checks.csv"));
    if (!file) {
        GTEST_SKIP() << measured_data("rft_spot_checks.csv") << " is not there";
    }
    std::string line;
    std::getline(file, line);
    int checked = 0;
    while (std::getline(file, line)) {
        std::vector<double> row;
        std::stringstream cells(line);
        for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
        ASSERT_EQ(row.size(), 7u);
        const double beta = radians(row[0]), gamma = radians(row[1]);
        // The tilt is that of either side of a plate: the one that goes ahead counts.
        Vec3 normal{std::sin(beta), 0, -std::cos(beta)};
        Vec3 direction{std::cos(gamma), 0, -std::sin(gamma)};
        double approach = dot(normal, direction);
        if (approach < -1e-9) {
            normal = -1.0 * normal;
            approach = -approach;
        }
        // Motion along the surface is the limit from inside.
        if (approach < 1e-9) direction += 1e-7 * normal;
        const Vec3 stress = resistive_stress(normal, direction, kUp, kRough);
        EXPECT_NEAR(stress.x, row[4], 1e-4) << line;  // the table has four digits
        EXPECT_NEAR(stress.y, row[5], 1e-4) << line;
        EXPECT_NEAR(stress.z, row[6], 1e-4) << line;
        ++checked;
    }
    EXPECT_EQ(checked, 11);
}

TEST(ResistiveForceTheory, plate_pressed_straight_down_feels_0875) {
    EXPECT_NEAR(resistive_stress({0, 0, -1}, {0, 0, -1}, kUp, kRough).z, 0.875, 1e-4);
}

TEST(ResistiveForceTheory, trailing_faces_feel_nothing) {
    EXPECT_EQ(length(resistive_stress({0, 0, -1}, {0, 0, 1}, kUp, 0.5)), 0);
    EXPECT_EQ(length(resistive_stress({1, 0, 0}, {0, 0, -1}, kUp, 0.5)), 0);
}

TEST(ResistiveForceTheory, plate_lifted_straight_up_feels_a_tenth_of_that) {
    const Vec3 stress = resistive_stress({0, 0, 1}, {0, 0, 1}, kUp, kRough);
    EXPECT_NEAR(stress.z, -0.0797, 1e-4);  // of the published check values
    EXPECT_NEAR(stress.x, 0, 1e-12);
}

// Soil neither pulls nor drives a face, and no small turn of it makes a large difference.
TEST(ResistiveForceTheory, of_faces_that_look_up_resists_their_motion_and_has_no_jump) {
    constexpr double kStep = 0.25;  // degrees
    for (double ahead = -80; ahead <= 80; ahead += 10) {
        const Vec3 v{std::cos(radians(ahead)), 0, std::sin(radians(ahead))};
        double before = -1;
        for (double tilt = 0; tilt <= 180; tilt += kStep) {
            const Vec3 n{std::sin(radians(tilt)), 0, -std::cos(radians(tilt))};
            if (dot(n, v) <= 0.05) {
                before = -1;
                continue;
            }
            const Vec3 stress = resistive_stress(n, v, kUp, 0.4);
            EXPECT_LE(dot(stress, v), 0.01) << "the fit is so good" << tilt << " " << ahead;
            const double normal = -dot(stress, n);
            EXPECT_GE(normal, 0) << tilt << " " << ahead;
            if (before >= 0) {
                EXPECT_LT(std::abs(normal - before), 0.02) << tilt << " " << ahead;
            }
            before = normal;
        }
    }
}

TEST(ResistiveForceTheory, stress_turns_with_the_frame) {
    const Vec3 n{0.6, 0, -0.8}, v{0.8, 0, -0.6};
    const Vec3 z_up = resistive_stress(n, v, kUp, 0.4);
    const Vec3 y_up = resistive_stress({n.y, n.z, n.x}, {v.y, v.z, v.x}, {0, 1, 0}, 0.4);
    EXPECT_NEAR(z_up.x, y_up.z, 1e-12);
    EXPECT_NEAR(z_up.y, y_up.x, 1e-12);
    EXPECT_NEAR(z_up.z, y_up.y, 1e-12);
}

TEST(ResistiveForceTheory, stress_along_the_surface_keeps_to_friction) {
    const Vec3 n{1, 0, 0};
    const Vec3 s = resistive_stress(n, {1, 0, 0}, kUp, 0.29);
    // 0.19185 and 0.0556: Obermayr's blade, tool friction 0.29.
    EXPECT_NEAR(s.x, -0.19185, 1e-5);
    EXPECT_NEAR(s.z, 0.29 * 0.19185, 1e-5);
}

TEST(ResistiveForceTheory, stiffness_of_measured_sands) {
    EXPECT_NEAR(resistive_stiffness_pa_m(1330, 9.81, std::tan(radians(29))), 1082852.6, 1);
    EXPECT_NEAR(resistive_stiffness_pa_m(1600, 9.81, std::tan(radians(33))), 2195140.4, 1);
}

struct WheelForce {
    Vec3 force_n;
    double torque_n_m = 0;
};

/// A smooth wheel on a flat bed, rolling along +x, by sums over rim and sides.
WheelForce wheel(double slip, double sinkage_m) {
    const double radius = 0.058, width = 0.05, friction = std::tan(radians(29));
    const double xi = resistive_stiffness_pa_m(1330, 9.81, friction);
    const int n = 240, strips = 12, rings = 16;
    const double omega = 1 / (1 - slip) / radius;
    WheelForce out;
    const auto add = [&](Vec3 p, Vec3 normal, double area) {
        const Vec3 v{1 + omega * p.z, 0, -omega * p.x};
        const double depth = std::max(sinkage_m - (p.z + radius), 0.0);
        const Vec3 f =
            xi * depth * area * resistive_stress(normal, v * (1 / length(v)), kUp, friction);
        out.force_n += f;
        out.torque_n_m += cross(p, f).y;
    };
    for (int i = 0; i < n; ++i) {
        const double t = 2 * std::numbers::pi * (i + 0.5) / n;
        for (int j = 0; j < strips; ++j) {
            add({radius * std::sin(t), (j + 0.5) / strips * width - width / 2,
                 -radius * std::cos(t)},
                {std::sin(t), 0, -std::cos(t)}, 2 * std::numbers::pi * radius / n * width / strips);
        }
        for (int j = 0; j < rings; ++j) {
            for (const double side : {-1.0, 1.0}) {
                const double r = (j + 0.5) / rings * radius;
                add({r * std::sin(t), side * width / 2, -r * std::cos(t)}, {0, side, 0},
                    r * 2 * std::numbers::pi / n * radius / rings);
            }
        }
    }
    return out;
}

TEST(ResistiveForceTheory, wheel_equals_the_reference_script) {
    // An independent script with the same sums, wheel of Pavlov et al. (2022), 20 mm deep.
    const struct {
        double slip, pull_n, lift_n, torque_n_m;
    } expected[] = {{0, -4.57188, 30.54948, -0.299640},
                    {0.2, 0.61317, 26.40509, -0.593986},
                    {0.5, 1.37006, 15.53335, -0.430346}};
    for (const auto& e : expected) {
        const WheelForce w = wheel(e.slip, 0.02);
        EXPECT_NEAR(w.force_n.x, e.pull_n, 1e-4);
        EXPECT_NEAR(w.force_n.y, 0, 1e-9);
        EXPECT_NEAR(w.force_n.z, e.lift_n, 1e-4);
        EXPECT_NEAR(w.torque_n_m, e.torque_n_m, 1e-5);
    }
}

}  // namespace
}  // namespace bsoil::resistive_force_theory_test
