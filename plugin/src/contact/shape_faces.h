/// The faces of a body's shapes: what the coverage field rounds off at its edges.
#pragma once

#include "bsoil/body.h"
#include "soil/wall_thickness.h"

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

/// The face of a body, world axes, that a point of the world is nearest to. Parts thinner than
/// thin_m (the lugs of a wheel in a coarse grid) do not count beside thicker ones: the coverage
/// field does not tell their faces apart. Thickened sheets count as thick. walls: of the body's
/// shapes. Cost: the number of the body's shapes and of their planes.
NearestFace nearest_face(const SoilBody& body, const WallShapes& walls, Vec3 point_m,
                         double thin_m);

}  // namespace bsoil
