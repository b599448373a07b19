// What is left of a face's sliding once the soil that it pushes flows along it.
#include "bsoil/contact/soil_flow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace bsoil::soil_flow_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr Vec3 kUp{0, 0, 1};

struct Sliding {
    Vec3 slide;
    double approach = 0;
};

/// Of a face that moves.
Sliding sliding_of(Vec3 velocity, Vec3 normal) {
    const double approach = dot(velocity, normal);
    return {velocity - approach * normal, approach};
}

// Soil before an upright wall goes up along it, at the tangent of the angle between the wall's
// normal and a Rankine wedge's plane.
TEST(SoilFlow, before_an_upright_wall_it_is_a_passive_wedges) {
    const double slope = flow_slope(30 * kDegree);
    EXPECT_NEAR(slope, std::tan(30 * kDegree), 1e-12);
    const Vec3 wall{1, 0, 0};
    const auto past = [&](Vec3 slide) { return slide_past_flow(slide, 1, wall, kUp, slope); };
    EXPECT_EQ(length(past({0, 0, 0.5 * slope})), 0) << "goes along with the soil";
    EXPECT_NEAR(length(past({0, 0, slope + 0.25}) - Vec3{0, 0, 0.25}), 0, 1e-12);
    EXPECT_NEAR(length(past({0, 0, -0.25}) - Vec3{0, 0, -0.25}), 0, 1e-12) << "against the flow";
    EXPECT_NEAR(length(past({0, 0.5, 0}) - Vec3{0, 0.5, 0}), 0, 1e-12) << "across the flow";
}

// Wong and Reece (1967), towed wheels: the rim rubs backwards up to where its motion makes an angle
// of 45 deg - phi / 2 with its normal. phi 29 deg: at slip -0.5 that is 34 deg before the lowest
// point, at -0.2 16, at -1 59.5.
TEST(SoilFlow, of_a_towed_wheel_ends_where_wong_and_reece_have_it) {
    const double slope = flow_slope(29 * kDegree);
    const auto rubs_back = [&](double slip, double at_deg) {
        const double sine = std::sin(at_deg * kDegree), cosine = std::cos(at_deg * kDegree);
        const Vec3 normal{sine, 0, -cosine}, forward{cosine, 0, sine};
        const double rim = 1 + slip;
        const auto [slide, approach] =
            sliding_of(Vec3{1, 0, 0} - rim * Vec3{cosine, 0, sine}, normal);
        return dot(slide_past_flow(slide, approach, normal, kUp, slope), forward);
    };
    for (const auto& [slip, ends_deg] : {std::pair{-0.2, 16.0}, {-0.5, 34.0}, {-1.0, 59.5}}) {
        EXPECT_GT(rubs_back(slip, ends_deg - 0.7), 0) << slip;
        EXPECT_NEAR(rubs_back(slip, ends_deg + 0.7), 0, 1e-12) << slip;
    }
    // A rim that is driven rubs against its turning all over: the soil does not flow down.
    for (const double at_deg : {5.0, 20.0, 40.0}) {
        EXPECT_NEAR(rubs_back(0.3, at_deg), std::cos(at_deg * kDegree) - 1.3, 1e-12) << at_deg;
    }
}

TEST(SoilFlow, never_turns_sliding_round_and_takes_no_jump) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int i = 0; i < 2000; ++i) {
        Vec3 normal{any(random), any(random), any(random)};
        if (length(normal) < 0.1) continue;
        normal = normal * (1 / length(normal));
        const Vec3 velocity{any(random), any(random), any(random)};
        const auto past = [&](Vec3 v, Vec3 n) {
            const auto [slide, approach] = sliding_of(v, n);
            return slide_past_flow(slide, approach, n, kUp, flow_slope(0.5));
        };
        const Sliding own = sliding_of(velocity, normal);
        const Vec3 found = past(velocity, normal);
        EXPECT_GE(dot(found, own.slide), -1e-12);
        EXPECT_LE(length(found), length(own.slide) + 1e-12);
        EXPECT_NEAR(dot(found, normal), 0, 1e-12);
        // What was taken off goes up along the face, no faster than the flow.
        const Vec3 flow = own.slide - found;
        EXPECT_LE(length(flow), flow_slope(0.5) * std::max(0.0, own.approach) + 1e-12);
        EXPECT_GE(dot(flow, kUp), -1e-12);
        EXPECT_NEAR(length(cross(flow, kUp - dot(kUp, normal) * normal)), 0, 1e-12);
        const Vec3 nearby = velocity + 1e-6 * Vec3{any(random), any(random), any(random)};
        EXPECT_LT(length(past(nearby, normal) - found), 1e-5);
        Vec3 tilted = normal + 1e-6 * Vec3{any(random), any(random), any(random)};
        tilted = tilted * (1 / length(tilted));
        EXPECT_LT(length(past(velocity, tilted) - found), 1e-4);
    }
}

TEST(SoilFlow, is_none_along_level_faces_and_behind_faces_that_draw_back) {
    const Vec3 down{0, 0, -1}, slide{0.3, 0.1, 0};
    EXPECT_EQ(length(slide_past_flow(slide, 1, down, kUp, 0.6) - slide), 0);
    const Vec3 up_wall{0, 0, 0.3};
    EXPECT_EQ(length(slide_past_flow(up_wall, -1, {1, 0, 0}, kUp, 0.6) - up_wall), 0);
    EXPECT_EQ(length(slide_past_flow(up_wall, 0, {1, 0, 0}, kUp, 0.6) - up_wall), 0);
}

// Slip lines of soil without weight turn from the face to the surface, and with each radian the
// mean stress changes by exp(2 tan phi).
TEST(SoilFlow, fan_is_narrower_by_the_turn_of_the_principal_stress) {
    for (const double phi : {20 * kDegree, 29 * kDegree, 40 * kDegree}) {
        const double sine = std::sin(phi), tangent = std::tan(phi);
        double last = 1 + 1e-12;
        for (int i = 0; i <= 20; ++i) {
            const double friction = tangent * i / 20;
            // The principal stress lies `turn` off the face's normal: Mohr's circle has this shear.
            double low = 0, high = std::numbers::pi / 4 + phi / 2;
            for (int k = 0; k < 60; ++k) {
                const double turn = (low + high) / 2;
                (sine * std::sin(2 * turn) < friction * (1 + sine * std::cos(2 * turn)) ? low
                                                                                        : high) =
                    turn;
            }
            const double by_hand =
                (1 + sine * std::cos(2 * low)) / (1 + sine) * std::exp(-2 * tangent * low);
            const double found = fan_share(phi, friction);
            // All friction is where the circle's tangent touches it: there the root is double.
            EXPECT_NEAR(found, by_hand, i == 20 ? 1e-6 : 1e-9) << phi << ' ' << friction;
            EXPECT_LT(found, last);
            last = found;
        }
    }
    EXPECT_EQ(fan_share(0.5, 0), 1);
    EXPECT_EQ(fan_share(0, 0), 1) << "soil without friction";
    EXPECT_NEAR(fan_share(29 * kDegree, std::tan(29 * kDegree)), 0.163, 1e-3);
    EXPECT_EQ(fan_share(0.5, 3), fan_share(0.5, std::tan(0.5))) << "soil shears before its tool";
}

}  // namespace
}  // namespace bsoil::soil_flow_test
