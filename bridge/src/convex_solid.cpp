#include "convex_solid.h"

#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <cmath>

#include "bullet_types.h"

namespace bsoil::bullet {
namespace {

/// A face smaller than this fraction of the square of a hull's radius is a splinter without a sure
/// normal.
constexpr double kNoFaceFraction = 1e-12;
/// Neighbouring faces of a hull with normals this close are one: the hull computer works on a grid
/// of integers and can split a plane in two.
constexpr double kSameNormalCosine = 1 - 1e-7;
/// Rounds of refinement: each may treble the points, and the hull computer's grid ends it.
constexpr int kRounds = 12;
/// Points of a polyhedron; its faces are twice as many.
constexpr size_t kPointsMost = 6000;

/// Normal of a face by Newell's method, which a short edge cannot spoil; not normalized.
Vec3 face_normal(const btConvexHullComputer& hull, int face) {
    const btConvexHullComputer::Edge* first = &hull.edges[hull.faces[face]];
    const Vec3 origin = from_bullet(hull.vertices[first->getSourceVertex()]);
    Vec3 normal;
    for (const btConvexHullComputer::Edge* edge = first;;) {
        normal += cross(from_bullet(hull.vertices[edge->getSourceVertex()]) - origin,
                        from_bullet(hull.vertices[edge->getTargetVertex()]) - origin);
        edge = edge->getNextEdgeOfFace();
        if (edge == first) return normal;
    }
}

}  // namespace

std::vector<Plane> hull_faces(const std::vector<btVector3>& points, double bound_m) {
    btConvexHullComputer computer;
    computer.compute(&points[0][0], static_cast<int>(sizeof(btVector3)),
                     static_cast<int>(points.size()), 0, 0);
    std::vector<Plane> faces;
    for (int f = 0; f < computer.faces.size(); ++f) {
        const Vec3 area_vector = face_normal(computer, f);
        const double size = length(area_vector);
        if (size <= bound_m * bound_m * kNoFaceFraction) continue;
        const Vec3 n = area_vector * (1 / size);
        const bool known = std::any_of(faces.begin(), faces.end(), [n](const Plane& other) {
            return dot(other.normal, n) > kSameNormalCosine;
        });
        if (!known) faces.push_back({n, -std::numeric_limits<double>::infinity()});
    }
    for (Plane& face : faces) {
        for (const btVector3& p : points) {
            face.offset = std::max(face.offset, dot(face.normal, from_bullet(p)));
        }
    }
    return faces;
}

std::vector<Plane> faces_within(double gap_m, std::vector<btVector3> points, double bound_m,
                                const std::function<btVector3(Vec3)>& touch) {
    for (int round = 0;; ++round) {
        std::vector<Plane> faces = hull_faces(points, bound_m);
        const bool is_last = round == kRounds || points.size() >= kPointsMost;
        bool is_off = false;
        for (Plane& face : faces) {
            const btVector3 point = touch(face.normal);
            const double gap = dot(face.normal, from_bullet(point)) - face.offset;
            // Between the points' hull and what touches the solid.
            face.offset += std::max(0.0, gap) / 2;
            if (gap <= gap_m) continue;
            is_off = true;
            points.push_back(point);
        }
        if (!is_off || is_last) return faces;
    }
}

PolyhedronDistance::PolyhedronDistance(std::vector<Plane> faces, double cell_m)
    : faces_(std::move(faces)), cell_m_(cell_m) {}

double PolyhedronDistance::operator()(Vec3 point) {
    const auto cell = [this](double x) { return static_cast<int64_t>(std::floor(x / cell_m_)); };
    const auto highest = [](const std::vector<Plane>& faces, Vec3 p) {
        double most = -std::numeric_limits<double>::infinity();
        for (const Plane& face : faces) most = std::max(most, dot(face.normal, p) - face.offset);
        return most;
    };
    const std::array<int64_t, 3> key{cell(point.x), cell(point.y), cell(point.z)};
    std::vector<Plane>& near = faces_near_[key];
    if (near.empty()) {
        const auto middle_of = [this](int64_t i) {
            return (static_cast<double>(i) + 0.5) * cell_m_;
        };
        const Vec3 middle{middle_of(key[0]), middle_of(key[1]), middle_of(key[2])};
        // Within the cell a face's height changes by half of its diagonal at most.
        const double least = highest(faces_, middle) - std::sqrt(3.0) * cell_m_;
        for (const Plane& face : faces_) {
            if (dot(face.normal, middle) - face.offset >= least) near.push_back(face);
        }
    }
    return highest(near, point);
}

}  // namespace bsoil::bullet
