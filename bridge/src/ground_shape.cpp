#include "ground_shape.h"

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionDispatch/btConvexConcaveCollisionAlgorithm.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bullet_types.h"

namespace bsoil::bullet {
namespace {

/// A triangle has two sides, and soil one: contacts with this one that push into the soil go.
void drop_contacts_from_below(btPersistentManifold& manifold, const btCollisionShape& ground,
                              int index, const btVector3& normal) {
    const bool is_first = manifold.getBody0()->getCollisionShape() == &ground;
    const btCollisionObject& object = is_first ? *manifold.getBody0() : *manifold.getBody1();
    for (int i = manifold.getNumContacts() - 1; i >= 0; --i) {
        const btManifoldPoint& point = manifold.getContactPoint(i);
        if ((is_first ? point.m_index0 : point.m_index1) != index) continue;
        const btVector3 along = point.m_normalWorldOnB * object.getWorldTransform().getBasis();
        const btVector3 outward = is_first ? -along : along;
        if (outward.z() < 0 || outward.dot(normal) <= 0) manifold.removeContactPoint(i);
    }
}

}  // namespace

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
    const auto* of_convex = dynamic_cast<btConvexTriangleCallback*>(&callback);
    for (const GroundSurface::Triangle& triangle : triangles) {
        btVector3 corners[3];
        for (int k = 0; k < 3; ++k) corners[k] = to_bullet(triangle.corners_m[k]);
        const btVector3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        callback.processTriangle(corners, 0, index);
        if (of_convex) drop_contacts_from_below(*of_convex->m_manifoldPtr, *this, index, normal);
        ++index;
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
    process_cells(first, last, from.z, to.z, *callback);
}

// Where the surface is plane, a body rests on corners of its own, not on a pick of them out of
// every triangle below it, which changes from step to step.
void GroundShape::process_cells(GroundSurface::Cell first, GroundSurface::Cell last, double z_low_m,
                                double z_high_m, btTriangleCallback& callback) const {
    if (first.x == last.x && first.y == last.y) {
        return process_cell(first, z_low_m, z_high_m, callback);
    }
    std::array<GroundSurface::Triangle, 2> plane;
    if (surface_.plane_triangles(first, last, plane)) return process(plane, first, callback);
    GroundSurface::Cell low_end = last, high_start = first;
    if (last.x - first.x >= last.y - first.y) {
        low_end.x = (first.x + last.x) / 2;
        high_start.x = low_end.x + 1;
    } else {
        low_end.y = (first.y + last.y) / 2;
        high_start.y = low_end.y + 1;
    }
    process_cells(first, low_end, z_low_m, z_high_m, callback);
    process_cells(high_start, last, z_low_m, z_high_m, callback);
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
