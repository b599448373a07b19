/// TriangleTree: which triangle of many is nearest to a point, and which ones a ray meets.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "bsoil/geometry.h"

namespace bsoil {

struct Triangle {
    Vec3 corners[3];
};

/// Point of a triangle nearest to another point (Ericson, Real-Time Collision Detection, 5.1.5).
struct TrianglePoint {
    Vec3 position;
    double weights[3] = {1, 0, 0};  ///< barycentric: of the corners
};
TrianglePoint nearest_on_triangle(const Triangle& triangle, Vec3 point);

/// A tree of boxes over triangles that do not change. Building costs n log n, a query log n.
class TriangleTree {
  public:
    TriangleTree() = default;
    explicit TriangleTree(std::vector<Triangle> triangles);

    const std::vector<Triangle>& triangles() const { return triangles_; }

    struct Nearest {
        int triangle = -1;  ///< -1: none within the limit
        double distance = std::numeric_limits<double>::infinity();
    };
    /// `prefers(a, b)`: whether, of two triangles that the point is equally near to (within 1e-9 of
    /// the distance: they share the nearest edge or corner), a counts before b.
    Nearest nearest(Vec3 point, const std::function<bool(int, int)>& prefers) const;

    struct Hit {
        double along = 0;
        int triangle = 0;
    };
    /// Appends every triangle that the ray meets within `reach` of its origin, in no order.
    /// direction: unit.
    void cast(Vec3 origin, Vec3 direction, double reach, std::vector<Hit>& hits) const;

  private:
    struct Node {
        Aabb box;
        int32_t first =
            0;  ///< leaf: of order_; else: index of the second child (the first follows)
        int32_t count = 0;  ///< of triangles; 0: an inner node
    };
    void build(int first, int count, std::vector<Vec3>& centers);

    std::vector<Triangle> triangles_;
    std::vector<int32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace bsoil
