#include "lowest_point.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>

#include <algorithm>
#include <cmath>

#include "bullet_types.h"

namespace bsoil::bullet {

btVector3 farthest_point(const btConvexShape& shape, const btVector3& direction) {
    if (shape.getShapeType() == UNIFORM_SCALING_SHAPE_PROXYTYPE) {
        const auto& scaled = static_cast<const btUniformScalingShape&>(shape);
        return farthest_point(*scaled.getChildShape(), direction) *
               scaled.getUniformScalingFactor();
    }
    if (shape.getShapeType() != CYLINDER_SHAPE_PROXYTYPE) {
        return shape.localGetSupportingVertex(direction);
    }
    const auto& cylinder = static_cast<const btCylinderShape&>(shape);
    const int axis = cylinder.getUpAxis();
    btVector3 point = direction;
    point[axis] = 0;
    const btScalar across = point.length();
    point *= across > SIMD_EPSILON ? cylinder.getRadius() / across : 0;
    point[axis] = std::copysign(cylinder.getHalfExtentsWithMargin()[axis], direction[axis]);
    return point;
}

std::optional<double> lowest_height_m(const btCollisionShape& shape, const btTransform& pose,
                                      Vec3 up) {
    if (shape.isCompound()) {
        const auto& compound = static_cast<const btCompoundShape&>(shape);
        std::optional<double> lowest;
        for (int i = 0; i < compound.getNumChildShapes(); ++i) {
            const std::optional<double> child = lowest_height_m(
                *compound.getChildShape(i), pose * compound.getChildTransform(i), up);
            if (!child) return {};
            lowest = lowest ? std::min(*lowest, *child) : child;
        }
        return lowest;
    }
    if (!shape.isConvex()) return {};
    const auto& convex = static_cast<const btConvexShape&>(shape);
    const btVector3 down = to_bullet(-up) * pose.getBasis();
    return dot(from_bullet(pose * farthest_point(convex, down)), up);
}

}  // namespace bsoil::bullet
