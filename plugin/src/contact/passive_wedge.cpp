#include "bsoil/contact/passive_wedge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace bsoil {
namespace {

/// A pole further off, in heights of the wall, takes the digits of what is summed up. Ours: a
/// thousandth of the spiral's angle is left. Smaller: planes, as smooth walls have, are not found.
constexpr double kFarthest = 1000;
constexpr double kNone = std::numeric_limits<double>::infinity();

struct Point {
    double x, y;
};

/// Twice the area of the triangle from the origin over p to q.
double turn(Point p, Point q) { return p.x * q.y - p.y * q.x; }

/// First moment about the y axis of the triangle origin, p, q.
double moment_of(Point p, Point q) { return turn(p, q) / 2 * (p.x + q.x) / 3; }

/// Coefficient that one spiral asks for. The wall is one unit high, its top is (0, 0). The spiral's
/// radius is at foot_rad below the horizontal where it leaves the wall's foot, and at top_rad where
/// it meets the surface: r = r0 exp((foot - angle) tan phi).
double factor_of_spiral(double phi, double wall, double foot_rad, double top_rad) {
    const double t = std::tan(phi);
    const double growth = std::exp((foot_rad - top_rad) * t);
    const double rise = std::sin(foot_rad) - growth * std::sin(top_rad);
    if (!(rise * kFarthest > 1)) return kNone;
    const double foot_radius = 1 / rise, top_radius = growth * foot_radius;
    // From the pole to the wall's top, its foot, and the spiral's end.
    const Point foot{foot_radius * std::cos(foot_rad), -foot_radius * std::sin(foot_rad)};
    const Point top{foot.x, foot.y + 1};
    const Point end{top_radius * std::cos(top_rad), -top_radius * std::sin(top_rad)};
    // Of the sector between foot and end: the integral of r^3 / 3 cos(angle).
    const double k = -3 * t;
    const auto integral = [&](double angle) {
        return (k * std::cos(angle) + std::sin(angle)) * std::exp(k * (angle - foot_rad)) /
               (k * k + 1);
    };
    const double sector =
        foot_radius * foot_radius * foot_radius / 3 * (integral(foot_rad) - integral(top_rad));
    const double weight_moment = sector + moment_of(end, top) + moment_of(top, foot);
    // The wall's force acts two thirds down, and the soil that rises drags on the wall.
    const double force_moment = -foot.x * std::sin(wall) - (top.y - 2.0 / 3) * std::cos(wall);
    return force_moment > 1e-9 && weight_moment > 0 ? 2 * weight_moment / force_moment : kNone;
}

/// Coulomb's coefficient where no plane fails: soil of 45 deg and more on a wall as rough. Ours: no
/// other bound of a wall comes near it. Larger: digits are lost beside it; smaller: it is a bound.
constexpr double kNoPlane = 1e6;

/// Of Coulomb's coefficient: it has a plane of failure only where this is below 1.
double coulomb_root(double phi, double wall) {
    return std::sqrt(std::sin(phi + wall) * std::sin(phi) / std::cos(wall));
}

}  // namespace

double passive_pressure_factor(double phi, double wall) {
    const double root = coulomb_root(phi, wall);
    if (!(root < 1)) return kNoPlane;
    return std::min(kNoPlane,
                    std::cos(phi) * std::cos(phi) / (std::cos(wall) * (1 - root) * (1 - root)));
}

namespace {

/// Least push P on a wall over unit weight times the square of its foot's depth, times the sine of
/// its angle. The planes' run x per height: P = (run + x) / 2 / (cos a + sin a cot(plane + phi)), a
/// = angle + wall friction, is a quotient of polynomials in x, with its least at a root.
double least_push(double tan_phi, double tan_wall, double cos_lean, double sin_lean) {
    const double cos_wall = 1 / std::sqrt(1 + tan_wall * tan_wall), sin_wall = tan_wall * cos_wall;
    const double c = cos_lean * cos_wall - sin_lean * sin_wall;
    const double s = sin_lean * cos_wall + cos_lean * sin_wall;
    const double run = cos_lean / sin_lean;
    const double slope = c * tan_phi + s, offset = c - s * tan_phi;
    const double root = tan_phi * tan_phi * offset * offset -
                        slope * tan_phi * ((1 + run * tan_phi) * offset - slope * run);
    const double x = (std::sqrt(std::max(0.0, root)) - tan_phi * offset) / (slope * tan_phi);
    return sin_lean * (run + x) * (tan_phi * x + 1) / (2 * (slope * x + offset));
}

/// A wall flatter than this sine counts as this: a level one has no run. Ours: 1 deg. Larger: flat
/// faces meet a steeper one's wedge; smaller: digits are lost.
constexpr double kFlattestSine = 0.0175;
/// Soil with less friction than this has the stress of a fluid on a wall at any angle. Ours: 0.06
/// deg. Larger: the share jumps there; smaller: digits are lost.
constexpr double kNoFriction = 1e-3;

}  // namespace

double leaning_wedge_share(double tan_phi, double tan_wall, double look_up) {
    if (tan_phi < kNoFriction || !(look_up > 0)) return 1;
    const double sin_lean =
        std::max(kFlattestSine, std::sqrt(std::max(0.0, 1 - look_up * look_up)));
    const double cos_lean = std::sqrt(1 - sin_lean * sin_lean);
    return least_push(tan_phi, tan_wall, cos_lean, sin_lean) / least_push(tan_phi, tan_wall, 0, 1);
}

double log_spiral_passive_factor(double phi, double wall) {
    // A table over the two angles, then steps that halve.
    // Ours: its cells of 4 deg are narrower than the basin of the least, and smaller ones only take
    // longer.
    constexpr int kTable = 48;
    // From level, or a radian above it, half round. Ours: a pole above the wall's top or behind it
    // asks for no force. Larger: cells get wider; smaller: rough walls lose their least.
    constexpr double kFootLow = 0, kTopLow = -1, kRange = std::numbers::pi;
    double least = kNone, foot_rad = 0, top_rad = 0;
    const auto look = [&](double foot, double top) {
        if (!(top < foot)) return;
        const double found = factor_of_spiral(phi, wall, foot, top);
        if (!(found < least)) return;
        least = found;
        foot_rad = foot;
        top_rad = top;
    };
    for (int i = 0; i < kTable; ++i) {
        for (int j = 0; j < kTable; ++j) {
            look(kFootLow + kRange * i / kTable, kTopLow + kRange * j / kTable);
        }
    }
    for (double step = kRange / kTable; step > 1e-6;) {
        const double before = least, foot = foot_rad, top = top_rad;
        for (const double a : {-step, 0.0, step}) {
            for (const double b : {-step, 0.0, step}) look(foot + a, top + b);
        }
        if (!(least < before)) step /= 2;
    }
    return std::min(least, passive_pressure_factor(phi, wall));
}

double passive_width_growth(double passive_factor, double friction_angle_rad) {
    const double active_root = std::tan(std::numbers::pi / 4 - friction_angle_rad / 2);
    const double apart = std::max(0.0, passive_factor - active_root * active_root);
    return std::pow(apart, 2.0 / 3) * 1.6;
}

double passive_width_factor(double growth, double width_m, double depth_m) {
    // Duncan and Mokwa (2001) take Brinch Hansen's factor no larger. Larger: narrow and deep faces
    // meet more than tests of slabs show.
    constexpr double kMost = 2;
    if (!(depth_m > 0)) return 1;
    return std::min(kMost, 1 + growth / (1 + 5 * width_m / depth_m));
}

double passive_width_factor(double passive_factor, double friction_angle_rad, double width_m,
                            double depth_m) {
    return passive_width_factor(passive_width_growth(passive_factor, friction_angle_rad), width_m,
                                depth_m);
}

}  // namespace bsoil
