// What a wall's wedge can resist, beside published tables and hand calculations.
#include "bsoil/contact/passive_wedge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bsoil/contact/granular_law.h"

namespace bsoil::passive_wedge_test {
namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180; }
double log_spiral(double phi_deg, double wall_deg) {
    return log_spiral_passive_factor(radians(phi_deg), radians(wall_deg));
}

TEST(PassiveWedge, smooth_wall_has_rankines) {
    for (const double phi : {5.0, 20.0, 30.0, 45.0}) {
        const double rankine = std::pow(std::tan(radians(45 + phi / 2)), 2);
        EXPECT_NEAR(log_spiral(phi, 0), rankine, 1e-3 * rankine) << phi;
    }
}

// Caquot and Kerisel 1948 as tables print them, to half a unit of the last digit and the 3 % that
// Soubra and Macuh find between a rotation and slip lines.
TEST(PassiveWedge, partly_rough_walls_are_as_in_published_tables) {
    const struct {
        double phi, share, published;
    } kTable[] = {{20, 1.0 / 3, 2.3}, {20, 0.5, 2.6}, {25, 1.0 / 3, 3.0}, {25, 0.5, 3.4},
                  {30, 1.0 / 3, 4.0}, {30, 0.5, 4.5}, {35, 1.0 / 3, 5.4}, {40, 1.0 / 3, 7.5}};
    for (const auto& [phi, share, published] : kTable) {
        EXPECT_NEAR(log_spiral(phi, share * phi), published, 0.05 + 0.03 * published)
            << phi << " deg, wall " << share * phi;
    }
}

// Kerisel and Absi's slip lines have 6.42 and 17.5 there; a rotation is an upper bound.
TEST(PassiveWedge, rough_walls_stay_bounded_where_coulombs_do_not) {
    EXPECT_GT(log_spiral(30, 30), 6.42);
    EXPECT_LT(log_spiral(30, 30), 1.10 * 6.42);
    EXPECT_GT(log_spiral(40, 40), 17.5);
    EXPECT_LT(log_spiral(40, 40), 1.16 * 17.5);
    EXPECT_GT(passive_pressure_factor(radians(40), radians(40)), 90);
    // Beyond 45 deg no plane before such a wall fails, and the formula falls again.
    for (const double deg : {44.99, 45.0, 50.0, 60.0, 68.7}) {
        EXPECT_GT(passive_pressure_factor(radians(deg), radians(deg)), 1e5) << deg;
    }
    double before = 0;
    for (double phi = 5; phi <= 46; phi += 1) {
        const double now = log_spiral(phi, phi);
        EXPECT_GT(now, before) << phi;
        EXPECT_LT(now, 50) << phi;
        before = now;
    }
}

// By trial of planes, as McKyes and Ali do without the sides.
TEST(PassiveWedge, wall_that_leans_back_meets_what_the_easiest_plane_asks_for) {
    const auto push = [](double phi, double wall, double lean) {  // over gamma d^2
        double least = 1e300;
        for (double plane = radians(1); plane < radians(89); plane += radians(0.02)) {
            const double held =
                std::cos(lean + wall) + std::sin(lean + wall) / std::tan(plane + phi);
            if (held <= 0) continue;
            least = std::min(least, (1 / std::tan(lean) + 1 / std::tan(plane)) / 2 / held);
        }
        return least;
    };
    for (const double phi : {15.0, 25.0, 33.0, 40.0}) {
        for (const double share : {0.0, 0.5, 1.0}) {
            const double wall = std::atan(share * std::tan(radians(phi)));
            // Coulomb's plane is lost where the two reach a right angle.
            if (phi > 35 && share == 1) continue;
            const double upright = push(radians(phi), wall, radians(90));
            double before = 1;
            for (double lean = 85; lean >= 10; lean -= 5) {
                const double want =
                    push(radians(phi), wall, radians(lean)) * std::sin(radians(lean)) / upright;
                const double found = leaning_wedge_share(std::tan(radians(phi)), std::tan(wall),
                                                         std::cos(radians(lean)));
                EXPECT_NEAR(found, want, 2e-3 * want) << phi << " " << share << " " << lean;
                EXPECT_LT(found, before) << "the flatter the easier";
                before = found;
            }
        }
    }
    EXPECT_EQ(leaning_wedge_share(0.6, 0.3, 0), 1);
    EXPECT_EQ(leaning_wedge_share(0.6, 0.3, -0.5), 1) << "it hangs over";
    EXPECT_EQ(leaning_wedge_share(0, 0, 0.5), 1) << "a fluid";
    EXPECT_TRUE(std::isfinite(leaning_wedge_share(0.6, 0.3, 1)));
}

TEST(PassiveWedge, narrow_wall_meets_up_to_twice_as_much_per_width) {
    // By hand: Kp 6.5, phi 30 deg, Ka 1/3; (6.1667)^(2/3) = 3.3629; b / d 2: 1 + 3.3629 1.6 / 11.
    EXPECT_NEAR(passive_width_factor(6.5, radians(30), 0.4, 0.2), 1.4891, 1e-3);
    EXPECT_EQ(passive_width_factor(6.5, radians(30), 0.01, 0.2), 2);
    EXPECT_NEAR(passive_width_factor(6.5, radians(30), 100, 0.2), 1, 3e-3);
    EXPECT_EQ(passive_width_factor(6.5, radians(30), 0.4, 0), 1);
}

}  // namespace
}  // namespace bsoil::passive_wedge_test
