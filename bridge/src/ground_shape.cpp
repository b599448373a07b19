#include "ground_shape.h"

#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bullet_types.h"

namespace bsoil::bullet {

GroundShape::GroundShape(GroundSurface& surface, double height_m)
    : surface_(surface),
      size_m_(to_bullet(Vec3{surface.size(0) * surface.voxel_m(),
                             surface.size(1) * surface.voxel_m(), height_m})) {
    // Of the concave types, the one for hosts' own that no algorithm of Bullet's takes for another
    // class.
    m_shapeType = FAST_CONCAVE_MESH_PROXYTYPE;
}

void GroundShape::getAabb(const btTransform& pose, btVector3& low, btVector3& high) const {
    btTransformAabb(btVector3(0, 0, 0), size_m_, getMargin(), pose, low, high);
}

void GroundShape::process_cell(GroundSurface::Cell cell, double z_low_m, double z_high_m,
                               btTriangleCallback& callback) const {
    std::array<GroundSurface::Triangle, 2> triangles;
    const int count = surface_.triangles(cell, z_low_m, z_high_m, triangles);
    process(std::span(triangles).first(count), cell, callback);
}

void GroundShape::process(std::span<const GroundSurface::Triangle> triangles,
                          GroundSurface::Cell cell, btTriangleCallback& callback) const {
    int index = 2 * (cell.y * surface_.cell_count(0) + cell.x);
    for (const GroundSurface::Triangle& triangle : triangles) {
        btVector3 corners[3];
        for (int k = 0; k < 3; ++k) corners[k] = to_bullet(triangle.corners_m[k]);
        callback.processTriangle(corners, 0, index++);
    }
}

void GroundShape::processAllTriangles(btTriangleCallback* callback, const btVector3& low,
                                      const btVector3& high) const {
    if (auto* ray = dynamic_cast<btTriangleRaycastCallback*>(callback)) return process_ray(*ray);
    const Vec3 from = from_bullet(low), to = from_bullet(high), size = from_bullet(size_m_);
    if (!(to.x >= 0 && to.y >= 0 && from.x <= size.x && from.y <= size.y)) return;
    const GroundSurface::Cell first = surface_.cell_at(from.x, from.y);
    const GroundSurface::Cell last = surface_.cell_at(to.x, to.y);
    // Sweeps ask and go; what is left makes contacts.
    if (!dynamic_cast<btTriangleConvexcastCallback*>(callback)) surface_.meet(first, last);
    // Where it is plane, a body rests on four corners of its own, not on a pick of them out of
    // every triangle below it, which changes from step to step.
    std::array<GroundSurface::Triangle, 2> plane;
    if (surface_.plane_triangles(first, last, plane)) return process(plane, first, *callback);
    for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) process_cell({x, y}, from.z, to.z, *callback);
    }
}

// From cell to cell along the ray (Amanatides and Woo 1987), until a triangle nearer than the next
// cell has been hit.
void GroundShape::process_ray(btTriangleRaycastCallback& ray) const {
    const Vec3 from = from_bullet(ray.m_from), along = from_bullet(ray.m_to) - from;
    const double start[2] = {from.x, from.y}, step[2] = {along.x, along.y};
    const Vec3 size = from_bullet(size_m_);
    const double extent[2] = {size.x, size.y};
    if (!is_finite(from) || !is_finite(along)) return;
    double enter = 0, leave = 1;
    for (int axis = 0; axis < 2; ++axis) {
        if (step[axis] == 0) {
            if (start[axis] < 0 || start[axis] > extent[axis]) return;
            continue;
        }
        const double t0 = -start[axis] / step[axis], t1 = (extent[axis] - start[axis]) / step[axis];
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1));
    }
    if (!(enter <= leave)) return;
    const auto at = [&](int axis, double t) { return start[axis] + t * step[axis]; };
    const GroundSurface::Cell first = surface_.cell_at(at(0, enter), at(1, enter));
    int cell[2] = {first.x, first.y};
    const auto leaves_cell = [&](int axis) {
        if (step[axis] == 0) return std::numeric_limits<double>::infinity();
        const double border_m = surface_.vertex_m(axis, cell[axis] + (step[axis] > 0 ? 1 : 0));
        return (border_m - start[axis]) / step[axis];
    };
    // A little room above and below: the triangles must not be lost to rounding.
    const double room_m = 0.01 * surface_.voxel_m();
    while (enter <= leave && enter <= static_cast<double>(ray.m_hitFraction)) {
        const double next[2] = {leaves_cell(0), leaves_cell(1)};
        const int axis = next[0] <= next[1] ? 0 : 1;
        const double z0 = from.z + enter * along.z;
        const double z1 = from.z + std::min(next[axis], leave) * along.z;
        process_cell({cell[0], cell[1]}, std::min(z0, z1) - room_m, std::max(z0, z1) + room_m, ray);
        enter = next[axis];
        cell[axis] += step[axis] > 0 ? 1 : -1;
        if (cell[axis] < 0 || cell[axis] >= surface_.cell_count(axis)) return;
    }
}

}  // namespace bsoil::bullet
