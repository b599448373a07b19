/// A body's surface cut into small pieces, from its shapes alone: no grid rounds off its edges.
#pragma once

#include <cmath>
#include <vector>

#include "bsoil/body.h"
#include "contact/tooth_rows.h"
#include "contact/wall_thickness.h"

namespace bsoil {

/// A piece of a face, in the body's frame.
struct SurfaceSample {
    Vec3 at, normal;  ///< normal: unit, outward
    double area_m2 = 0;
    double out_m = 0;      ///< how far the soil sees the face moved out: half a sheet's growth
    bool is_thin = false;  ///< of a part that the coverage field hardly knows beside thicker ones
    int row = -1;          ///< of SurfaceSamples::rows; -1: none
    ToothPart part = ToothPart::base;
};

/// A piece of the surface over the tips of a row of teeth, and the places on the body whose soil
/// tells what soil is there.
struct OverTips {
    SurfaceSample piece;
    Vec3 root, tip;  ///< what the teeth stand on below it, and the nearest tooth's tip
};

/// Samples beside each other, in a ball.
struct SampleCluster {
    Vec3 center;
    double radius_m = 0;
    size_t first = 0, last = 0;
};

/// The outer surface of a body's shapes, each piece no longer than a voxel. What
/// lies inside another of its shapes, or looks at one across less than half a voxel, is left out.
struct SurfaceSamples {
    std::vector<SurfaceSample> samples;
    std::vector<SampleCluster> clusters;
    std::vector<ToothedFace> rows;    ///< empty where not asked for
    std::vector<OverTips> over_tips;  ///< of all rows
    /// Whether they are all of the surface: not of a lattice, nor of a body too large for them.
    bool is_whole = false;
    bool is_made = false;  ///< make() was called
    /// cut_voxel_m: where that is less than voxel_m, pieces as in a grid of such voxels. Cost: the
    /// pieces; where shapes come near each other 64 times those, times the shapes and up to 17
    /// steps across a crack.
    void make(const std::vector<ConvexShape>& shapes, const std::vector<SheetGrowth>& growth,
              double voxel_m, bool with_teeth = false, double cut_voxel_m = HUGE_VAL);

  private:
    void add_rows(const std::vector<ConvexShape>& shapes, double spacing_m,
                  const std::vector<size_t>& ends);
};

}  // namespace bsoil
