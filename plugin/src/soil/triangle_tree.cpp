#include "soil/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace bsoil {
namespace {

constexpr int kLeafTriangles = 4;
/// Deeper than any tree of 2^31 triangles split in halves.
constexpr int kStackDepth = 64;
/// Triangles within this share of the distance are equally near.
constexpr double kSameDistance = 1e-9;

void grow(Aabb& box, Vec3 p) {
    box.min = {std::min(box.min.x, p.x), std::min(box.min.y, p.y), std::min(box.min.z, p.z)};
    box.max = {std::max(box.max.x, p.x), std::max(box.max.y, p.y), std::max(box.max.z, p.z)};
}

double square_distance(const Aabb& box, Vec3 p) {
    const Vec3 off{std::max({box.min.x - p.x, 0.0, p.x - box.max.x}),
                   std::max({box.min.y - p.y, 0.0, p.y - box.max.y}),
                   std::max({box.min.z - p.z, 0.0, p.z - box.max.z})};
    return dot(off, off);
}

bool meets(const Aabb& box, Vec3 origin, Vec3 direction, double reach) {
    double from = 0, to = reach;
    const double lows[3] = {box.min.x, box.min.y, box.min.z},
                 highs[3] = {box.max.x, box.max.y, box.max.z},
                 o[3] = {origin.x, origin.y, origin.z},
                 d[3] = {direction.x, direction.y, direction.z};
    for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(d[axis]) < 1e-300) {
            if (o[axis] < lows[axis] || o[axis] > highs[axis]) return false;
            continue;
        }
        const double a = (lows[axis] - o[axis]) / d[axis], b = (highs[axis] - o[axis]) / d[axis];
        from = std::max(from, std::min(a, b));
        to = std::min(to, std::max(a, b));
    }
    return from <= to;
}

double component(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

}  // namespace

TrianglePoint nearest_on_triangle(const Triangle& triangle, Vec3 p) {
    const Vec3 a = triangle.corners[0], b = triangle.corners[1], c = triangle.corners[2];
    const Vec3 ab = b - a, ac = c - a, ap = p - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return {a, {1, 0, 0}};
    const Vec3 bp = p - b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return {b, {0, 1, 0}};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        const double v = d1 / (d1 - d3);
        return {a + v * ab, {1 - v, v, 0}};
    }
    const Vec3 cp = p - c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return {c, {0, 0, 1}};
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        const double w = d2 / (d2 - d6);
        return {a + w * ac, {1 - w, 0, w}};
    }
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {b + w * (c - b), {0, 1 - w, w}};
    }
    const double v = vb / (va + vb + vc), w = vc / (va + vb + vc);
    return {a + v * ab + w * ac, {1 - v - w, v, w}};
}

TriangleTree::TriangleTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
    order_.resize(triangles_.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::vector<Vec3> centers;
    centers.reserve(triangles_.size());
    for (const Triangle& t : triangles_) {
        centers.push_back((t.corners[0] + t.corners[1] + t.corners[2]) * (1.0 / 3));
    }
    nodes_.reserve(triangles_.size());
    if (!triangles_.empty()) build(0, static_cast<int>(triangles_.size()), centers);
}

void TriangleTree::build(int first, int count, std::vector<Vec3>& centers) {
    const size_t index = nodes_.size();
    nodes_.emplace_back();
    const auto corner = [&](int i) {
        return triangles_[static_cast<size_t>(order_[static_cast<size_t>(i)])].corners;
    };
    Aabb box{corner(first)[0], corner(first)[0]};
    Aabb center_box{centers[static_cast<size_t>(order_[static_cast<size_t>(first)])],
                    centers[static_cast<size_t>(order_[static_cast<size_t>(first)])]};
    for (int i = first; i < first + count; ++i) {
        for (int k = 0; k < 3; ++k) grow(box, corner(i)[k]);
        grow(center_box, centers[static_cast<size_t>(order_[static_cast<size_t>(i)])]);
    }
    nodes_[index].box = box;
    if (count <= kLeafTriangles) {
        nodes_[index].first = first;
        nodes_[index].count = count;
        return;
    }
    const Vec3 size = center_box.max - center_box.min;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const int half = count / 2;
    // Ties by index, so that the tree is the same everywhere.
    std::nth_element(order_.begin() + first, order_.begin() + first + half,
                     order_.begin() + first + count, [&](int32_t a, int32_t b) {
                         const double ca = component(centers[static_cast<size_t>(a)], axis),
                                      cb = component(centers[static_cast<size_t>(b)], axis);
                         return ca != cb ? ca < cb : a < b;
                     });
    build(first, half, centers);
    nodes_[index].first = static_cast<int32_t>(nodes_.size());
    build(first + half, count - half, centers);
}

TriangleTree::Nearest TriangleTree::nearest(Vec3 point,
                                            const std::function<bool(int, int)>& prefers) const {
    Nearest best;
    if (nodes_.empty()) return best;
    int stack[kStackDepth];
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const int index = stack[--depth];
        const Node& node = nodes_[static_cast<size_t>(index)];
        const double reach = best.distance * (1 + kSameDistance);
        if (square_distance(node.box, point) > reach * reach) continue;
        if (node.count == 0) {
            const int near = index + 1, far = node.first;
            const bool swap = square_distance(nodes_[static_cast<size_t>(far)].box, point) <
                              square_distance(nodes_[static_cast<size_t>(near)].box, point);
            stack[depth++] = swap ? near : far;
            stack[depth++] = swap ? far : near;
            continue;
        }
        for (int i = node.first; i < node.first + node.count; ++i) {
            const int t = order_[static_cast<size_t>(i)];
            const double d = length(
                point - nearest_on_triangle(triangles_[static_cast<size_t>(t)], point).position);
            const double slack = kSameDistance * best.distance;
            if (best.triangle < 0 || d < best.distance - slack) {
                best = {t, d};
            } else if (d <= best.distance + slack && prefers(t, best.triangle)) {
                best = {t, std::min(d, best.distance)};
            }
        }
    }
    return best;
}

void TriangleTree::cast(Vec3 origin, Vec3 direction, double reach, std::vector<Hit>& hits) const {
    if (nodes_.empty()) return;
    int stack[kStackDepth];
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const int index = stack[--depth];
        const Node& node = nodes_[static_cast<size_t>(index)];
        if (!meets(node.box, origin, direction, reach)) continue;
        if (node.count == 0) {
            stack[depth++] = index + 1;
            stack[depth++] = node.first;
            continue;
        }
        for (int i = node.first; i < node.first + node.count; ++i) {
            const int t = order_[static_cast<size_t>(i)];
            const Vec3* c = triangles_[static_cast<size_t>(t)].corners;
            // Moeller and Trumbore
            const Vec3 e1 = c[1] - c[0], e2 = c[2] - c[0];
            const Vec3 h = cross(direction, e2);
            const double det = dot(e1, h);
            if (det == 0) continue;
            const Vec3 s = origin - c[0];
            const double u = dot(s, h) / det;
            const Vec3 q = cross(s, e1);
            const double v = dot(direction, q) / det;
            const double along = dot(e2, q) / det;
            if (u >= 0 && v >= 0 && u + v <= 1 && along >= -1e-9 * reach && along <= reach) {
                hits.push_back({along, t});
            }
        }
    }
}

}  // namespace bsoil
