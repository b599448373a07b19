// What a converted shape depends on, as one number.
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>

#include <bit>

#include "fingerprint.h"
#include "hull_conversion.h"
#include "mesh_conversion.h"
#include "shape_conversion.h"

namespace bsoil::bullet {
namespace {

/// A number that changes with any of its coordinates: the factors are odd. Their products do not
/// wait for each other, as the steps of the hash do.
uint64_t word_of(const btVector3& point) {
    const auto bits = [&point](int i) {
        return std::bit_cast<uint64_t>(static_cast<double>(point[i]));
    };
    const uint64_t word = bits(0) * 0x9e3779b97f4a7c15ull + bits(1) * 0xc2b2ae3d27d4eb4full +
                          bits(2) * 0x165667b19e3779f9ull;
    return word ^ word >> 32;
}

/// All of them: a host may edit any in place. Their scaling is a word of its own.
template <typename PointShape>
void add_points(Fingerprint& print, const PointShape& shape) {
    const int count = shape.getNumPoints();
    print.add(static_cast<uint64_t>(count));
    const btVector3* points = shape.getUnscaledPoints();
    for (int i = 0; i < count; ++i) print.add(word_of(points[i]));
}

void add_shape(Fingerprint& print, const btCollisionShape& shape, const GridBall& grid) {
    const int type = shape.getShapeType();
    print.add(static_cast<uint64_t>(type));
    if (type == STATIC_PLANE_PROXYTYPE) {
        const auto& plane = static_cast<const btStaticPlaneShape&>(shape);
        print.add(plane.getPlaneNormal());
        print.add(static_cast<double>(plane.getPlaneConstant()));
        print.add(grid.center_m);
        print.add(grid.radius_m);
        return;
    }
    if (type == COMPOUND_SHAPE_PROXYTYPE) {
        const auto& compound = static_cast<const btCompoundShape&>(shape);
        for (int i = 0; i < compound.getNumChildShapes(); ++i) {
            const btTransform& local = compound.getChildTransform(i);
            print.add(local.getOrigin());
            for (int row = 0; row < 3; ++row) print.add(local.getBasis()[row]);
            const Vec3 center = transform(inverse(from_bullet(local)), grid.center_m);
            const btCollisionShape& child = *compound.getChildShape(i);
            add_shape(print, child, {center, grid.radius_m, grid.voxel_m});
            // Where its children end: what follows is a child of this one.
            if (child.isCompound()) {
                const auto& nested = static_cast<const btCompoundShape&>(child);
                print.add(static_cast<uint64_t>(nested.getNumChildShapes()));
            }
        }
        return;
    }
    if (type == UNIFORM_SCALING_SHAPE_PROXYTYPE) {
        const auto& scaled = static_cast<const btUniformScalingShape&>(shape);
        print.add(static_cast<double>(scaled.getUniformScalingFactor()));
        add_shape(print, *scaled.getChildShape(), grid);
        if (has_support_solid(shape)) add_grid(print, shape, grid);
        return;
    }
    if (is_mesh(shape)) {
        add_mesh(print, shape, grid);
        return;
    }
    if (is_gimpact_compound(shape)) {
        const auto& compound = static_cast<const btGImpactCompoundShape&>(shape);
        for (int i = 0; i < compound.getNumChildShapes(); ++i) {
            const Pose local = child_pose(compound, i);
            print.add(local.position);
            print.add(local.rotation.x);
            print.add(local.rotation.y);
            print.add(local.rotation.z);
            print.add(local.rotation.w);
            add_shape(print, *compound.getChildShape(i), grid);
        }
        return;
    }
    if (!shape.isConvex()) return;  // refused whatever its dimensions are
    if (type == TRIANGLE_SHAPE_PROXYTYPE || type == TETRAHEDRAL_SHAPE_PROXYTYPE ||
        type == CUSTOM_POLYHEDRAL_SHAPE_TYPE) {
        const auto& polyhedron = static_cast<const btPolyhedralConvexShape&>(shape);
        for (int i = 0; i < polyhedron.getNumVertices(); ++i) {
            btVector3 vertex;
            polyhedron.getVertex(i, vertex);
            print.add(vertex);
        }
        print.add(grid.voxel_m);
    }
    if (type == CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE) {
        add_mesh(print, *static_cast<const btConvexTriangleMeshShape&>(shape).getMeshInterface());
    }
    if (has_support_solid(shape)) add_grid(print, shape, grid);
    if (is_support_shape(shape)) {
        const auto& convex = static_cast<const btConvexShape&>(shape);
        for (int i = 0; i < kSphereDirectionCount; i += kSphereDirectionCount / 50) {
            print.add(convex.localGetSupportingVertex(to_bullet(sphere_direction(i))));
        }
    }
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    print.add(low);
    print.add(high);
    print.add(shape.getLocalScaling());
    print.add(static_cast<double>(shape.getMargin()));
    if (type == CONVEX_HULL_SHAPE_PROXYTYPE) {
        add_points(print, static_cast<const btConvexHullShape&>(shape));
    }
    if (type == CONVEX_POINT_CLOUD_SHAPE_PROXYTYPE) {
        add_points(print, static_cast<const btConvexPointCloudShape&>(shape));
    }
}

}  // namespace

uint64_t shape_fingerprint(const btCollisionShape& shape, const GridBall& grid) {
    Fingerprint print;
    add_shape(print, shape, grid);
    return print.value;
}

}  // namespace bsoil::bullet
