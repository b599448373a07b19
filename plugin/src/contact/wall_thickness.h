/// Walls thin against a voxel, made thick enough to hold soil back.
#pragma once

#include <vector>

#include "bsoil/body.h"

namespace bsoil {

/// How a shape is thickened. A sheet is thin along one axis and at least
/// limits::kThinnestWallVoxels along the others: bars and pebbles stay as they are, soil goes round
/// them.
struct SheetGrowth {
    Vec3 normal;             ///< unit, of its faces, in the shape's frame; zero: no thin sheet
    double thickness_m = 0;  ///< as it is
    double growth_m = 0;     ///< what is added, half on each face
    bool is_thin() const { return growth_m > 0; }
    /// Real area of its rim over that of the thickened one: 0..1.
    double rim_share() const { return thickness_m / (thickness_m + growth_m); }
};

/// Of boxes, cylinders, and hulls whose two faces are parallel within 10 degrees. Cost: the square
/// of a hull's planes.
SheetGrowth sheet_growth(const ConvexShape& shape, double voxel_m);

/// The shape with its faces moved apart.
ConvexShape thickened(ConvexShape shape, const SheetGrowth& growth);

/// A body's shapes as the soil sees them.
struct WallShapes {
    std::vector<SheetGrowth> growth;  ///< of each shape
    std::vector<ConvexShape> shapes;  ///< thickened; empty when none of them is thin
    void make(const std::vector<ConvexShape>& body_shapes, double voxel_m);
};

}  // namespace bsoil
