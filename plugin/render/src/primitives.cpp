#include "bsoil/render/primitives.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bsoil/distance_lattice.h"

namespace bsoil::render {
namespace {

constexpr int kRoundSegments = 48;      ///< around an axis
constexpr double kBevelMost = 1.0 / 3;  ///< of the thinnest extent
constexpr int kArcSegments = 12;        ///< of a quarter circle

uint32_t add_vertex(Mesh& mesh, Vec3 position, Vec3 normal, Color color) {
    const auto index = static_cast<uint32_t>(mesh.vertex_count());
    for (const double v : {position.x, position.y, position.z}) {
        mesh.positions.push_back(static_cast<float>(v));
    }
    for (const double v : {normal.x, normal.y, normal.z}) {
        mesh.normals.push_back(static_cast<float>(v));
    }
    mesh.colors.insert(mesh.colors.end(), color.begin(), color.end());
    return index;
}

/// A flat convex polygon, counter-clockwise seen from its normal's side.
void add_polygon(Mesh& mesh, std::span<const Vec3> corners, Vec3 normal, Color color) {
    const auto base = static_cast<uint32_t>(mesh.vertex_count());
    for (const Vec3& corner : corners) add_vertex(mesh, corner, normal, color);
    for (uint32_t i = 2; i < corners.size(); ++i) {
        mesh.indices.insert(mesh.indices.end(), {base, base + i - 1, base + i});
    }
}

/// A point of the outline of a solid of revolution about z, with the outline's normal there.
struct OutlinePoint {
    double radius, z;
    double normal_radial, normal_z;
};

/// Turns an outline, given from top to bottom, about z. Two points in the same place make an edge.
Mesh revolved_mesh(std::span<const OutlinePoint> outline, Color color) {
    Mesh mesh;
    for (const OutlinePoint& point : outline) {
        for (int s = 0; s <= kRoundSegments; ++s) {
            const double angle = 2 * std::numbers::pi * s / kRoundSegments;
            const double c = std::cos(angle), d = std::sin(angle);
            add_vertex(mesh, {point.radius * c, point.radius * d, point.z},
                       {point.normal_radial * c, point.normal_radial * d, point.normal_z}, color);
        }
    }
    constexpr uint32_t kRing = kRoundSegments + 1;
    for (uint32_t p = 0; p + 1 < outline.size(); ++p) {
        for (uint32_t s = 0; s < kRoundSegments; ++s) {
            const uint32_t upper = p * kRing + s, lower = upper + kRing;
            if (outline[p].radius > 0) {
                mesh.indices.insert(mesh.indices.end(), {upper, lower, upper + 1});
            }
            if (outline[p + 1].radius > 0) {
                mesh.indices.insert(mesh.indices.end(), {upper + 1, lower, lower + 1});
            }
        }
    }
    return mesh;
}

/// The part of a convex polygon in the half space.
std::vector<Vec3> clipped(const std::vector<Vec3>& polygon, const Plane& plane) {
    std::vector<Vec3> result;
    for (size_t i = 0; i < polygon.size(); ++i) {
        const Vec3 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        const double over_a = dot(plane.normal, a) - plane.offset;
        const double over_b = dot(plane.normal, b) - plane.offset;
        if (over_a <= 0) result.push_back(a);
        if ((over_a < 0 && over_b > 0) || (over_a > 0 && over_b < 0)) {
            result.push_back(a + over_a / (over_a - over_b) * (b - a));
        }
    }
    return result;
}

}  // namespace

Mesh box_mesh(Vec3 half, Color color, double bevel_m) {
    std::vector<Plane> planes = {{{1, 0, 0}, half.x},  {{-1, 0, 0}, half.x}, {{0, 1, 0}, half.y},
                                 {{0, -1, 0}, half.y}, {{0, 0, 1}, half.z},  {{0, 0, -1}, half.z}};
    const double cut = std::min(bevel_m, kBevelMost * 2 * std::min({half.x, half.y, half.z}));
    const double s = std::sqrt(0.5);
    for (const double a : {-s, s}) {
        for (const double b : {-s, s}) {
            if (cut <= 0) continue;
            planes.push_back({{a, b, 0}, s * (half.x + half.y - cut)});
            planes.push_back({{a, 0, b}, s * (half.x + half.z - cut)});
            planes.push_back({{0, a, b}, s * (half.y + half.z - cut)});
        }
    }
    return hull_mesh(planes, 2 * std::max({half.x, half.y, half.z}), color);
}

Mesh sphere_mesh(double radius_m, Color color) { return capsule_mesh(radius_m, 0, color); }

Mesh capsule_mesh(double radius_m, double half_height_m, Color color) {
    std::vector<OutlinePoint> outline;
    for (const double end : {1.0, -1.0}) {
        for (int i = 0; i <= kArcSegments; ++i) {
            const double along = static_cast<double>(end > 0 ? i : kArcSegments - i) / kArcSegments;
            const double angle = along * std::numbers::pi / 2;  // from the pole
            const double radial = i == (end > 0 ? 0 : kArcSegments) ? 0 : std::sin(angle);
            const double up = end * std::cos(angle);
            outline.push_back({radius_m * radial, end * half_height_m + radius_m * up, radial, up});
        }
    }
    return revolved_mesh(outline, color);
}

Mesh cylinder_mesh(double radius_m, double half_height_m, Color color, double bevel_m) {
    const double r = radius_m, h = half_height_m;
    const double cut = std::min(bevel_m, kBevelMost * 2 * std::min(r, h));
    if (cut > 0) {
        const double in = r - cut, low = h - cut, s = std::sqrt(0.5);
        const OutlinePoint bevelled[] = {
            {0, h, 0, 1},    {in, h, 0, 1},    {in, h, s, s},   {r, low, s, s},  {r, low, 1, 0},
            {r, -low, 1, 0}, {r, -low, s, -s}, {in, -h, s, -s}, {in, -h, 0, -1}, {0, -h, 0, -1}};
        return revolved_mesh(bevelled, color);
    }
    const OutlinePoint outline[] = {{0, h, 0, 1},  {r, h, 0, 1},   {r, h, 1, 0},
                                    {r, -h, 1, 0}, {r, -h, 0, -1}, {0, -h, 0, -1}};
    return revolved_mesh(outline, color);
}

Mesh cone_mesh(double radius_m, double half_height_m, Color color) {
    const double r = radius_m, h = half_height_m, side = std::hypot(r, 2 * h);
    const double radial = 2 * h / side, up = r / side;
    const OutlinePoint outline[] = {
        {0, h, radial, up}, {r, -h, radial, up}, {r, -h, 0, -1}, {0, -h, 0, -1}};
    return revolved_mesh(outline, color);
}

Mesh hull_mesh(std::span<const Plane> planes, double bound_m, Color color) {
    Mesh mesh;
    for (const Plane& plane : planes) {
        const Vec3 n = plane.normal;
        const Vec3 aside = std::abs(n.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
        Vec3 u = cross(aside, n);
        u = (1 / length(u)) * u;
        const Vec3 v = cross(n, u), center = plane.offset * n;
        const double reach = 2 * bound_m;
        std::vector<Vec3> face = {center - reach * u - reach * v, center + reach * u - reach * v,
                                  center + reach * u + reach * v, center - reach * u + reach * v};
        for (const Plane& other : planes) {
            if (&other != &plane && !face.empty()) face = clipped(face, other);
        }
        if (face.size() >= 3) add_polygon(mesh, face, n, color);
    }
    return mesh;
}

Mesh triangle_mesh(const TriangleMesh& triangles, Color color) {
    Mesh mesh;
    for (const auto& triangle : triangles.triangles) {
        const Vec3 corners[3] = {triangles.vertices[triangle[0]], triangles.vertices[triangle[1]],
                                 triangles.vertices[triangle[2]]};
        const Vec3 n = cross(corners[1] - corners[0], corners[2] - corners[0]);
        if (length(n) > 0) add_polygon(mesh, corners, (1 / length(n)) * n, color);
    }
    return mesh;
}

Mesh convex_mesh(const ConvexShape& shape, Color color) {
    const double more = shape.rounding_m;
    const double radius = shape.radius_m + more, half = shape.half_height_m + more;
    Mesh mesh;
    switch (shape.kind) {
        case ConvexShape::Kind::box:
            mesh = box_mesh(shape.half_extents_m + Vec3{more, more, more}, color);
            break;
        case ConvexShape::Kind::sphere:
            mesh = sphere_mesh(radius, color);
            break;
        case ConvexShape::Kind::capsule:
            mesh = capsule_mesh(radius, shape.half_height_m, color);
            break;
        case ConvexShape::Kind::cylinder:
            mesh = cylinder_mesh(radius, half, color);
            break;
        case ConvexShape::Kind::cone:
            mesh = cone_mesh(radius, half, color);
            break;
        case ConvexShape::Kind::hull: {
            std::vector<Plane> planes = shape.planes;
            for (Plane& plane : planes) plane.offset += more;
            mesh = hull_mesh(planes, shape.bound_m + more, color);
            break;
        }
        case ConvexShape::Kind::lattice:
            mesh = triangle_mesh(shape.lattice->mesh(), color);
            break;
    }
    transform_mesh(mesh, shape.local);
    return mesh;
}

void transform_mesh(Mesh& mesh, const Pose& pose) {
    const auto replace = [](float* v, Vec3 value) {
        v[0] = static_cast<float>(value.x);
        v[1] = static_cast<float>(value.y);
        v[2] = static_cast<float>(value.z);
    };
    for (size_t i = 0; i + 2 < mesh.positions.size(); i += 3) {
        float* p = &mesh.positions[i];
        replace(p, transform(pose, {p[0], p[1], p[2]}));
    }
    for (size_t i = 0; i + 2 < mesh.normals.size(); i += 3) {
        float* n = &mesh.normals[i];
        replace(n, rotate(pose.rotation, {n[0], n[1], n[2]}));
    }
}

}  // namespace bsoil::render
