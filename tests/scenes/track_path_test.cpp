/// The belt round wheels and the links along it, against pulley formulas and Cauchy's.
#include "robots/track_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace bsoil::scene::track_path_test {
namespace {

constexpr double kPi = std::numbers::pi;

double distance(PlanePoint a, PlanePoint b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// Of a point from the piece of line between two others.
double distance_to_line(PlanePoint p, PlanePoint a, PlanePoint b) {
    const double dx = b.x - a.x, dy = b.y - a.y;
    const double t =
        std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
    return distance(p, {a.x + t * dx, a.y + t * dy});
}

/// Perimeter of the convex hull of circles by Cauchy's formula: the integral, over all directions,
/// of how far it reaches.
double cauchy_perimeter_m(const std::vector<TrackCircle>& circles) {
    constexpr int kCount = 200'000;
    double sum = 0;
    for (int k = 0; k < kCount; ++k) {
        const double angle = 2 * kPi * k / kCount;
        double reach = -1e9;
        for (const TrackCircle& c : circles) {
            reach = std::max(reach, c.center_m.x * std::cos(angle) +
                                        c.center_m.y * std::sin(angle) + c.radius_m);
        }
        sum += reach;
    }
    return sum * 2 * kPi / kCount;
}

TEST(TrackPath, two_equal_pulleys) {
    const TrackPath path({{{0, 0}, 0.3}, {{2, 1}, 0.3}});
    EXPECT_NEAR(path.length_m(), 2 * std::sqrt(5.0) + 2 * kPi * 0.3, 1e-9);
    EXPECT_NEAR(path.wrap_rad(0), kPi, 1e-9);
    EXPECT_NEAR(path.wrap_rad(1), kPi, 1e-9);
}

TEST(TrackPath, two_unequal_pulleys) {
    const double large = 0.5, small = 0.2, apart = 1.7;
    const TrackPath path({{{-0.3, 0}, small}, {{-0.3, apart}, large}});
    const double lean = std::asin((large - small) / apart);
    EXPECT_NEAR(path.length_m(),
                2 * std::sqrt(apart * apart - (large - small) * (large - small)) +
                    kPi * (large + small) + 2 * lean * (large - small),
                1e-9);
    EXPECT_NEAR(path.wrap_rad(0), kPi - 2 * lean, 1e-9);
    EXPECT_NEAR(path.wrap_rad(1), kPi + 2 * lean, 1e-9);
}

TEST(TrackPath, wheels_in_a_row_and_inside_do_not_bend_it) {
    const std::vector<TrackCircle> wheels{
        {{1, 0}, 0.2}, {{0.5, 0}, 0.2}, {{0, 0}, 0.2}, {{-1, 0}, 0.2}, {{0.2, 0}, 0.15}};
    const TrackPath path(wheels);
    EXPECT_NEAR(path.length_m(), 2 * 2 + 2 * kPi * 0.2, 1e-9);
    for (const size_t i : {1, 2, 4}) EXPECT_NEAR(path.wrap_rad(i), 0, 1e-9);
}

TEST(TrackPath, any_wheels_have_the_perimeter_of_their_hull) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-2, 2), radius(0.05, 0.6);
    for (int round = 0; round < 20; ++round) {
        std::vector<TrackCircle> wheels;
        for (int i = 0; i < 2 + round % 7; ++i) {
            wheels.push_back({{place(random), place(random)}, radius(random)});
        }
        const TrackPath path(wheels);
        EXPECT_NEAR(path.length_m(), cauchy_perimeter_m(wheels), 1e-4) << "round " << round;
        double wrap_rad = 0;
        for (size_t i = 0; i < wheels.size(); ++i) wrap_rad += path.wrap_rad(i);
        EXPECT_NEAR(wrap_rad, 2 * kPi, 1e-9);
        // Counterclockwise, closed, and one metre of path is one metre of way.
        double area = 0, way_m = 0;
        constexpr int kSteps = 1000;
        for (int k = 0; k < kSteps; ++k) {
            const PlanePoint a = path.point(path.length_m() * k / kSteps),
                             b = path.point(path.length_m() * (k + 1) / kSteps);
            area += (a.x * b.y - a.y * b.x) / 2;
            way_m += distance(a, b);
        }
        EXPECT_GT(area, 0);
        EXPECT_NEAR(way_m, path.length_m(), 1e-3 * path.length_m());
    }
}

/// Sprocket, idler and five road wheels.
const std::vector<TrackCircle> kCrawler{
    {{-0.8, 0}, 0.22}, {{0.8, 0}, 0.22},     {{-0.5, -0.19}, 0.1}, {{-0.25, -0.19}, 0.1},
    {{0, -0.19}, 0.1}, {{0.25, -0.19}, 0.1}, {{0.5, -0.19}, 0.1}};

TEST(TrackChain, links_are_alike_close_and_clear_the_wheels) {
    constexpr double kPinHeight = 0.02;
    for (const int count : {24, 40, 41, 90}) {
        const TrackChain chain = lay_track(kCrawler, kPinHeight, count);
        ASSERT_EQ(chain.pins_m.size(), static_cast<size_t>(count));
        EXPECT_EQ(chain.sharp_wheel, -1);
        for (int i = 0; i < count; ++i) {
            const PlanePoint a = chain.pins_m[i], b = chain.pins_m[(i + 1) % count];
            EXPECT_NEAR(distance(a, b), chain.pitch_m, 1e-9) << i << " of " << count;
            for (const TrackCircle& wheel : kCrawler) {
                EXPECT_GT(distance_to_line(wheel.center_m, a, b),
                          wheel.radius_m + kPinHeight - 1e-9)
                    << i << " of " << count;
            }
        }
        std::vector<TrackCircle> belt = kCrawler;
        for (TrackCircle& wheel : belt) wheel.radius_m += kPinHeight;
        const double slack = count * chain.pitch_m / TrackPath(belt).length_m() - 1;
        EXPECT_GT(slack, 0);
        EXPECT_LT(slack, 0.02 * (24.0 / count) * (24.0 / count) + 1e-3) << count;  // as pitch^2
    }
}

TEST(TrackChain, links_too_long_for_a_wheel_name_it) {
    const TrackChain chain = lay_track({{{0, 0}, 0.5}, {{2, 0}, 0.2}}, 0.02, 16);
    EXPECT_GT(chain.pitch_m, 0.22);
    EXPECT_EQ(chain.sharp_wheel, 1);
}

}  // namespace
}  // namespace bsoil::scene::track_path_test
