/// A body's surface cut into small pieces, from its shapes alone: no grid rounds off its edges.
#pragma once

#include <vector>

#include "bsoil/body.h"
#include "soil/wall_thickness.h"

namespace bsoil {

/// A piece of a face, in the body's frame.
struct SurfaceSample {
    Vec3 at, normal;  ///< normal: unit, outward
    double area_m2 = 0;
    double out_m = 0;      ///< how far the soil sees the face moved out: half a sheet's growth
    bool is_thin = false;  ///< of a part that the coverage field hardly knows beside thicker ones
};

/// Samples beside each other, in a ball.
struct SampleCluster {
    Vec3 center;
    double radius_m = 0;
    size_t first = 0, last = 0;
};

/// The outer surface of a body's shapes, each piece no longer than three quarters of a voxel. What
/// lies inside another of its shapes is left out.
struct SurfaceSamples {
    std::vector<SurfaceSample> samples;
    std::vector<SampleCluster> clusters;
    /// Whether they are all of the surface: not of a lattice, nor of a body too large for them.
    bool is_whole = false;
    bool is_made = false;  ///< make() was called
    /// Cost: the pieces, and where shapes meet 64 times those times the shapes.
    void make(const std::vector<ConvexShape>& shapes, const std::vector<SheetGrowth>& growth,
              double voxel_m);
};

}  // namespace bsoil
