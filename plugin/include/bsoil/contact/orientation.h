/// What of a body's surface is a sole, which presses on soil, and what a wall, which pushes it.
///
/// An element between the two takes part of both. Three questions are asked of its normal, and each
/// has one answer here:
///
///   what does it bear?            bearing_parts()  a face that looks up bears as a wall
///   where is its free surface?    surface_parts()  before a face that leans back, as before a wall
///   what connected face is it of? is_sole()        soles by place, walls by the body's own axes
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bsoil/geometry.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// Parts of an element, the sum is 1.
struct SoleAndWall {
    double sole = 0, wall = 0;
};

/// A unit vector across a unit vector: of all of them always the same.
inline Vec3 unit_across(Vec3 n) {
    const Vec3 axis = std::abs(n.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 across = axis - dot(axis, n) * n;
    return across * (1 / length(across));
}

/// Cosine between a normal and straight down; 0 where it looks up.
inline double looks_down(Vec3 normal, Vec3 up) { return std::max(0.0, -dot(normal, up)); }

/// Parts of what an element bears, by the squares of its normal's parts: those of a unit vector add
/// up to 1, and the force on a face that turns goes over smoothly from one to the other.
/// down: looks_down().
constexpr SoleAndWall bearing_parts(double down) { return {down * down, 1 - down * down}; }

/// Part of its normal that looks up from which an element leans back as far as that matters; what
/// is other for a leaning face than for an upright one comes in up to here. Ours: 10 deg. Larger:
/// blades that lean back a little are met as upright ones; smaller: their force jumps as they tilt.
inline constexpr double kLeaningSine = 0.17;

/// A level part of the normal below which a face that looks up lies rather than leans. Ours: 15
/// deg, about the flattest blade. Larger: the ground around flat blades counts, with the cut behind
/// them; smaller: of floors the ground before them counts.
inline constexpr double kLeaningLevel = 0.26;

/// Parts of an element in where its free surface lies: before a wall, around a sole. By the same
/// squares where it looks down. A face that leans back pushes what lies before it, however flat it
/// is, and around it there is the cut that it leaves. outward: unit normal, z up.
constexpr SoleAndWall surface_parts(Vec3 outward) {
    const double level = outward.x * outward.x + outward.y * outward.y;
    const double wall =
        outward.z > 0 ? std::min(1.0, level / (kLeaningLevel * kLeaningLevel)) : level;
    return {1 - wall, wall};
}

/// Cosine beyond which a face that looks down belongs to a sole. Ours: 45 deg, where both parts are
/// equal. Larger: a wheel's sole is shorter, and its width is taken of fewer elements.
inline constexpr double kSoleCosine = std::numbers::sqrt2 / 2;
/// Whether it does. down: looks_down().
constexpr bool is_sole(double down) { return down > kSoleCosine; }

/// Of Bekker's law, which knows pressure on soles only: below this cosine the pressure falls to
/// nothing. Ours: 78 deg; a wheel's front down to there has Bekker's pressure in full, as his
/// integral over the arc of contact has. Larger: steep fronts bear less.
inline constexpr double kUprightCosine = 0.2;

}  // namespace bsoil
#pragma GCC visibility pop
