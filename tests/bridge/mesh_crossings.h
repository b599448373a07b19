// What tests of converted meshes and fields share: the grid, and where segments cross triangles.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "bsoil/distance_lattice.h"
#include "shape_conversion.h"

namespace bsoil::bullet {

constexpr double kVoxel = 0.05;
inline const GridBall kGrid{{0, 0, 0}, 10, kVoxel};

/// To the nearest of the lattices.
inline double distance_to(const std::vector<ConvexShape>& shapes, Vec3 p) {
    double d = std::numeric_limits<double>::infinity();
    for (const ConvexShape& s : shapes) {
        d = std::min(d, s.lattice ? s.lattice->distance_m(transform(inverse(s.local), p)) : d);
    }
    return d;
}

/// Triangles of a shape that a segment crosses, as Bullet walks and intersects them.
class CrossingCounter : public btTriangleRaycastCallback {
  public:
    CrossingCounter(const btVector3& from, const btVector3& to)
        : btTriangleRaycastCallback(from, to, 0) {}
    btScalar reportHit(const btVector3&, btScalar fraction, int, int) override {
        // A segment through an edge hits both of its triangles.
        hits.insert(std::lround(static_cast<double>(fraction) * 1e5));
        fractions.push_back(static_cast<double>(fraction));
        return 1;  // go on to the end
    }
    std::set<long> hits;
    std::vector<double> fractions;
};

}  // namespace bsoil::bullet
