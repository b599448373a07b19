#include "convex_hull.h"

#include <LinearMath/btConvexHullComputer.h>

namespace bsoil::scene {

ConvexHull convex_hull(const std::vector<Vec3>& points) {
    if (points.size() < 4) return {};
    std::vector<double> coordinates;
    for (const Vec3 p : points) coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
    btConvexHullComputer computer;
    computer.compute(coordinates.data(), 3 * sizeof(double), static_cast<int>(points.size()), 0, 0);
    ConvexHull hull;
    std::vector<Vec3>& vertices = hull.surface.vertices;
    for (int i = 0; i < computer.vertices.size(); ++i) {
        const btVector3& v = computer.vertices[i];
        vertices.push_back({v.x(), v.y(), v.z()});
    }
    for (int f = 0; f < computer.faces.size(); ++f) {  // each face as a fan around its first vertex
        const btConvexHullComputer::Edge* first = &computer.edges[computer.faces[f]];
        const int a = first->getSourceVertex();
        for (const auto* edge = first->getNextEdgeOfFace(); edge->getTargetVertex() != a;
             edge = edge->getNextEdgeOfFace()) {
            hull.surface.triangles.push_back({a, edge->getSourceVertex(), edge->getTargetVertex()});
        }
    }
    for (const auto& [a, b, c] : hull.surface.triangles) {
        hull.volume_m3 += dot(vertices[a] - vertices[0],
                              cross(vertices[b] - vertices[0], vertices[c] - vertices[0])) /
                          6;
    }
    if (hull.volume_m3 < 0) {  // Bullet's faces may turn the other way
        hull.volume_m3 = -hull.volume_m3;
        for (auto& triangle : hull.surface.triangles) std::swap(triangle[1], triangle[2]);
    }
    constexpr double kFlat = 1e-9;  // [m3] thinner than that and it is a plane figure
    if (hull.volume_m3 < kFlat) return {};
    return hull;
}

}  // namespace bsoil::scene
