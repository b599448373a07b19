/// How a body lies in soil: its lowest point, the surface beside it, and how deep it may be.
#pragma once

#include <map>
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

/// Of the terrain, else of the grid's floor. Neither stops a body: hosts have bodies for them.
/// Where a plate would go through all soil there is nothing to compare with (90127).
double ground_height_m(const BuiltWorld& world, int soil, Vec3 at);

/// How far one of Bullet's substeps has turned bodies into soil. Bullet turns a body by its spin
/// times the substep at once, and soil bears it where it lay before: what comes down on its other
/// side meets nobody in that substep, and soil does not push out what lies in it. World 1020065: in
/// 1/30 s a capsule of 32 mm went over from one end to the other, by 45 deg, and that end 13 mm
/// down. With four substeps for that one it lies 3 mm deep for 20.
class Turns {
  public:
    /// After a substep. is_borne: awake, and held up by anything.
    void note(const btCollisionObject& object, Vec3 up, bool is_borne);
    /// Somebody else has put it where it is.
    void forget(const btCollisionObject* object) { poses_.erase(object); }
    /// The most that the point of the body which lay lowest after a substep came down in it by
    /// turning about the body's middle.
    double most_m(const btCollisionObject* object) const;

  private:
    std::map<const btCollisionObject*, btTransform> poses_;
    std::map<const btCollisionObject*, double> most_m_;
};

}  // namespace bsoil::random_worlds
