/// Rows of teeth on a body's shapes: a wheel's lugs, a track's grousers, ribs across a plate.
#pragma once

#include <vector>

#include "bsoil/body.h"

namespace bsoil {

/// A cylinder's mantle or a side of a box with teeth across it, evenly apart. Lengths and axes in
/// the frame of the shape that they stand on.
struct ToothedFace {
    double height_m = 0, thickness_m = 0, pitch_m = 0;
    size_t base = 0;              ///< the shape that the teeth stand on
    Pose to_body;                 ///< its frame
    bool is_mantle = false;       ///< about z; else flat
    double level_m = 0;           ///< the mantle's radius, or the flat side's height along `out`
    Vec3 out, along, across;      ///< flat side: unit axes
    double from_m = 0, to_m = 0;  ///< of the teeth on the base, along z of a mantle, else `across`
    double half_m = 0;            ///< flat side: half its length along the row
    std::vector<size_t> shapes;   ///< the teeth
    std::vector<double> places;   ///< of each: angle about z [rad], else along the row [m]

    /// Where a point of the body is above the base, in the base's frame: unit direction, and how
    /// far.
    struct Above {
        Vec3 outward;
        double height_m = 0;
    };
    Above above(Vec3 at_base) const;
    /// Whether a point of the base's surface lies between the teeth, its normal out of the base.
    bool has(Vec3 at_base, Vec3 normal_base) const;
    /// Whether a point of a tooth lies on a face towards the next, no further out than the base.
    bool looks_along(Vec3 at_base, Vec3 normal_base) const;
    /// The foot of a point over the tips, and the tip of the tooth that is nearest to it.
    Vec3 root(Vec3 at_base) const;
    Vec3 nearest_tip(Vec3 at_base) const;
};

/// Boxes, and hulls of few planes, that stand on a cylinder or a box. On a cylinder at least five,
/// none more than a quarter turn from the next and no higher than half the radius; on a box's side
/// one or more, no higher than a third of the pitch. Each reaches across at least half of what it
/// stands on, and hardly beyond it. Anything else (an arm, a table's legs, a bucket's walls) is no
/// tooth. Cost: shapes squared.
std::vector<ToothedFace> find_toothed_faces(const std::vector<ConvexShape>& shapes);

}  // namespace bsoil
