#include "track_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace bsoil::scene {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
/// Two tangents closer than this [rad] are one: wheels in a row.
constexpr double kSameTangentRad = 1e-9;
/// The path starts here, and not where wheels in a row are equally far out.
constexpr double kStartRad = 0.1234567;
/// A wheel that the track bends round by more than this has to be as large as a link is long.
constexpr double kBendRad = std::numbers::pi / 3;
/// Halvings of an interval [m] down to the resolution of a double.
constexpr int kBisectionCount = 60;

PlanePoint operator+(PlanePoint a, PlanePoint b) { return {a.x + b.x, a.y + b.y}; }
PlanePoint operator-(PlanePoint a, PlanePoint b) { return {a.x - b.x, a.y - b.y}; }
PlanePoint operator*(double s, PlanePoint a) { return {s * a.x, s * a.y}; }
double distance(PlanePoint a, PlanePoint b) { return std::hypot(a.x - b.x, a.y - b.y); }
PlanePoint rim(const TrackCircle& c, double angle_rad) {
    return c.center_m + c.radius_m * PlanePoint{std::cos(angle_rad), std::sin(angle_rad)};
}

/// The direction, as an angle, from which on circle b reaches further out than circle a: that of
/// the normal of their common tangent, a before b. None where one lies within the other.
std::optional<double> tangent_rad(const TrackCircle& a, const TrackCircle& b) {
    const PlanePoint way = b.center_m - a.center_m;
    const double between_m = std::hypot(way.x, way.y);
    const double narrower_m = a.radius_m - b.radius_m;
    if (between_m <= std::abs(narrower_m)) return {};
    return std::atan2(way.y, way.x) - std::acos(narrower_m / between_m);
}

/// How far beyond the rim the pins of a chain of chords `pitch_m` lie so that no chord cuts into
/// the circle, where the path turns about it by `wrap_rad`. On a long arc the pins lie on a circle
/// that the chords' middles keep clear; at a slight bend a chord cuts off no more than its corner.
double pin_clearance_m(double radius_m, double pitch_m, double wrap_rad) {
    const double arc_m = std::hypot(radius_m, pitch_m / 2) - radius_m;
    return std::min(arc_m, pitch_m / 2 * std::sin(std::min(wrap_rad, std::numbers::pi) / 2));
}

/// The first place behind `along_m` that is `chord_m` away from it; none where the path is too
/// narrow.
std::optional<double> chord_end(const TrackPath& path, double along_m, double chord_m) {
    const PlanePoint from = path.point(along_m);
    const double step_m = chord_m / 8;
    double high = along_m + chord_m;  // no curve is shorter than its chord
    while (distance(from, path.point(high)) < chord_m) {
        high += step_m;
        if (high > along_m + path.length_m() / 2) return {};
    }
    double low = high - step_m;
    for (int i = 0; i < kBisectionCount; ++i) {
        const double middle = (low + high) / 2;
        (distance(from, path.point(middle)) < chord_m ? low : high) = middle;
    }
    return high;
}

/// The path of the pins of a chain of that pitch, taut about `wheels` (which include the pins'
/// height).
TrackPath pin_path(std::vector<TrackCircle> wheels, double pitch_m) {
    const TrackPath taut(wheels);
    for (size_t i = 0; i < wheels.size(); ++i) {
        wheels[i].radius_m += pin_clearance_m(wheels[i].radius_m, pitch_m, taut.wrap_rad(i));
    }
    return TrackPath(wheels);
}

/// How much further than once round `link_count` chords reach [m]; infinite where they do not fit.
double overlap_m(const TrackPath& path, double pitch_m, int link_count) {
    double along_m = 0;
    for (int i = 0; i < link_count; ++i) {
        const auto end = chord_end(path, along_m, pitch_m);
        if (!end) return std::numeric_limits<double>::infinity();
        along_m = *end;
    }
    return along_m - path.length_m();
}

}  // namespace

TrackPath::TrackPath(const std::vector<TrackCircle>& circles) : wraps_rad_(circles.size(), 0) {
    // Gift wrapping: the circle that reaches furthest out in a direction, while that turns round.
    const auto reach = [&](size_t i) {
        const TrackCircle& c = circles[i];
        return c.center_m.x * std::cos(kStartRad) + c.center_m.y * std::sin(kStartRad) + c.radius_m;
    };
    size_t current = 0;
    for (size_t i = 1; i < circles.size(); ++i) {
        if (reach(i) > reach(current)) current = i;
    }
    double angle = kStartRad;
    for (;;) {
        size_t next = current;
        double turn = kStartRad + kTurn - angle;
        for (size_t i = 0; i < circles.size(); ++i) {
            if (i == current) continue;
            const auto tangent = tangent_rad(circles[current], circles[i]);
            if (!tangent) continue;
            double ahead = std::fmod(*tangent - angle, kTurn);
            if (ahead < -kSameTangentRad) ahead += kTurn;
            ahead = std::max(ahead, 0.0);
            // Of wheels in a row the nearest, so that the path touches all of them.
            const bool is_nearer = next != current && std::abs(ahead - turn) <= kSameTangentRad &&
                                   distance(circles[current].center_m, circles[i].center_m) <
                                       distance(circles[current].center_m, circles[next].center_m);
            if (!is_nearer && ahead >= turn - kSameTangentRad) continue;
            next = i;
            turn = ahead;
        }
        Piece piece;
        piece.circle = circles[current];
        piece.from_rad = angle;
        piece.turn_rad = turn;
        wraps_rad_[current] += turn;
        piece.arc_m = piece.circle.radius_m * turn;
        angle += turn;
        piece.line_from_m = rim(circles[current], angle);
        piece.line_to_m = rim(circles[next], angle);
        piece.line_m = distance(piece.line_from_m, piece.line_to_m);
        length_m_ += piece.arc_m + piece.line_m;
        pieces_.push_back(piece);
        if (next == current) return;
        current = next;
    }
}

PlanePoint TrackPath::point(double along_m) const {
    double rest_m = std::fmod(along_m, length_m_);
    for (const Piece& piece : pieces_) {
        if (rest_m <= piece.arc_m) {
            return rim(piece.circle, piece.from_rad + rest_m / piece.circle.radius_m);
        }
        rest_m -= piece.arc_m;
        if (rest_m <= piece.line_m) {
            return piece.line_from_m +
                   rest_m / piece.line_m * (piece.line_to_m - piece.line_from_m);
        }
        rest_m -= piece.line_m;
    }
    return pieces_.back().line_to_m;
}

TrackChain lay_track(const std::vector<TrackCircle>& wheels, double pin_height_m, int link_count) {
    std::vector<TrackCircle> circles = wheels;
    for (TrackCircle& circle : circles) circle.radius_m += pin_height_m;
    const TrackPath taut(circles);
    // Chords are shorter than the arcs below them, and the pins lie outside the taut path.
    double low = taut.length_m() / link_count / 2, high = 2 * taut.length_m() / link_count;
    for (int i = 0; i < kBisectionCount; ++i) {
        const double middle = (low + high) / 2;
        const bool is_short = overlap_m(pin_path(circles, middle), middle, link_count) < 0;
        (is_short ? low : high) = middle;
    }
    TrackChain chain;
    chain.pitch_m = low;
    for (size_t i = 0; i < wheels.size(); ++i) {
        if (taut.wrap_rad(i) > kBendRad && chain.pitch_m > circles[i].radius_m) {
            chain.sharp_wheel = static_cast<int>(i);
        }
    }
    const TrackPath path = pin_path(circles, chain.pitch_m);
    double along_m = 0;
    for (int i = 0; i < link_count; ++i) {
        chain.pins_m.push_back(path.point(along_m));
        along_m = chord_end(path, along_m, chain.pitch_m).value_or(along_m);
    }
    return chain;
}

}  // namespace bsoil::scene
