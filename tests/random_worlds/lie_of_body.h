/// How a body lies in soil: its lowest point, the surface beside it, and how deep it may be.
#pragma once

#include <optional>
#include <vector>

#include "mechanics.h"

namespace bsoil::random_worlds {

/// Of a shape, along `up`. A box about a hull, a compound or a mesh reaches farther where it is
/// turned.
Vec3 lowest_point(const btCollisionShape& shape, const btTransform& pose, Vec3 up);

/// Height, under a point, of the plane through the soil's surface around it: on a slope a long body
/// has its lowest point where the surface is low. The circle is as large as the body, so that it
/// crosses soil beside it. Where banks stand there it is the level between them. Empty where most
/// of the circle lies beside the soil.
std::optional<double> surface_beside_m(const BuiltWorld& world, const bullet::SoilAction& soil,
                                       Vec3 at, double radius_m);

/// What of a body looks down: equal areas, each so high above the body's lowest point.
struct Underside {
    double each_m2 = 0;
    std::vector<double> heights_m;  ///< sorted
};
Underside disc(double radius_m);
/// Of an object, by rays from below, which meet the margins of round shapes as well. `radius_m`: a
/// sphere about its middle has it inside.
Underside underside_of(const btCollisionObject& object, Vec3 up, double radius_m);

/// How deep a body sinks that falls from a height onto the weakest of the soils: as far as the
/// soil's work, by its own contact law, is that of its weight. What of the underside lies below the
/// surface bears as one plate of that area, as deep as its mean. At most the grid's height.
double sinkage_after_fall_m(const Soil& soil, const Underside& underside, double weight_n,
                            double fall_m);

}  // namespace bsoil::random_worlds
