/// Convex solids that a few planes do not make: multi-spheres, Minkowski sums, hulls of many faces.
#pragma once

#include <LinearMath/btVector3.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "bsoil/body.h"

namespace bsoil::bullet {

/// Faces of the points' hull, as half spaces that hold all of the points. bound_m: radius of the
/// hull about its middle. Faces in one plane are one.
std::vector<Plane> hull_faces(const std::vector<btVector3>& points, double bound_m);

/// Faces of a polyhedron whose surface is within gap_m / 2 of a convex solid's; exact where that
/// has faces of its own. `touch(n)`: the solid's farthest point along n; points: on its surface, in
/// many directions. Cost: some 0.1 s for 5000 faces, which it takes where gap_m is a thousandth of
/// a sphere's radius.
std::vector<Plane> faces_within(double gap_m, std::vector<btVector3> points, double bound_m,
                                const std::function<btVector3(Vec3)>& touch);

/// How far a point lies above the face of a convex polyhedron that it is farthest above: negative
/// inside; outside, off its edges, less than the distance.
class PolyhedronDistance {
  public:
    /// cell_m: of a grid in whose cells only the faces that may matter are looked at, a small part
    /// of the solid's size.
    PolyhedronDistance(std::vector<Plane> faces, double cell_m);
    double operator()(Vec3 point);

  private:
    std::vector<Plane> faces_;
    double cell_m_;
    std::map<std::array<int64_t, 3>, std::vector<Plane>> faces_near_;
};

}  // namespace bsoil::bullet
