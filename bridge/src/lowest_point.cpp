#include "lowest_point.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <algorithm>

#include "bullet_types.h"

namespace bsoil::bullet {

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
    return dot(from_bullet(pose * convex.localGetSupportingVertex(down)), up);
}

}  // namespace bsoil::bullet
