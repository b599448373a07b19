/// The faces of a body's shapes: what the coverage field rounds off at its edges.
#pragma once

#include <optional>
#include <vector>

#include "bsoil/body.h"
#include "contact/wall_thickness.h"

namespace bsoil {

/// The face of a shape that a point is nearest to or deepest under.
struct NearestFace {
    double distance_m = 0;   ///< above the face, negative inside
    Vec3 normal;             ///< unit, outward
    Vec3 sheet_normal = {};  ///< of the sheet that the face is of, when rim_share < 1
    double rim_share = 1;    ///< SheetGrowth::rim_share of that sheet
};

/// point: in the shape's own frame.
NearestFace nearest_face(const ConvexShape& shape, Vec3 point_m);

/// Smallest width; of a hull no more than a guess, its bound, and of a lattice that of its box.
double shape_thickness_m(const ConvexShape& shape);

/// A body's shapes where they stand.
class BodyFaces {
  public:
    /// walls: of the body's shapes. Both must outlive the questions.
    void place(const SoilBody& body, const WallShapes& walls);
    /// The face, world axes, that a point of the world is nearest to. Parts thinner than thin_m
    /// (the lugs of a wheel in a coarse grid) do not count beside thicker ones: the coverage field
    /// does not tell their faces apart. Thickened sheets count as thick. Cost: the number of shapes
    /// and of their planes.
    NearestFace nearest(Vec3 point_m, double thin_m) const;
    /// The same, and none where the point is no further above that face than `least_m`: it costs
    /// less to find that out.
    std::optional<NearestFace> nearest_below(Vec3 point_m, double thin_m, double least_m) const;

  private:
    struct Part {
        const ConvexShape* shape;
        const SheetGrowth* growth;
        Pose to_world, to_shape;
        double thickness_m;
        double bound_m, bound_share;  ///< no face is nearer than bound_share times the way beyond
                                      ///< bound_m from the shape's origin
    };
    /// A part, and the face of its shape in the shape's frame.
    struct Found {
        const Part* part = nullptr;
        NearestFace face;
    };
    Found find(Vec3 point_m, double thin_m) const;
    static NearestFace in_world(const Found& found);

    std::vector<Part> parts_;
    double thickest_m_ = 0;
};

}  // namespace bsoil
