/// Bullet's shapes from their plans.
#pragma once

#include <btBulletCollisionCommon.h>

#include <memory>
#include <vector>

#include "world_plan.h"

class btTriangleMesh;

namespace bsoil::random_worlds {

inline btScalar scalar(double value) { return static_cast<btScalar>(value); }

/// Owns shapes, and the data that Bullet's shapes only point to.
class CollisionShapes {
  public:
    CollisionShapes();
    ~CollisionShapes();
    CollisionShapes(const CollisionShapes&) = delete;
    CollisionShapes& operator=(const CollisionShapes&) = delete;
    btCollisionShape& make(const ShapePlan& plan);

  private:
    template <typename Shape, typename... Arguments>
    Shape& keep(Arguments&&... arguments);
    btTriangleMesh& mesh_of(const ShapePlan& plan);
    btCollisionShape& round(const ShapePlan& plan);
    btCollisionShape& of_points(const ShapePlan& plan);
    btCollisionShape& of_children(const ShapePlan& plan);
    btCollisionShape& of_triangles(const ShapePlan& plan);

    struct Heights {
        std::vector<btScalar> values;
    };
    std::vector<std::unique_ptr<Heights>> heights_;
    std::vector<std::unique_ptr<btTriangleMesh>> meshes_;
    std::vector<std::unique_ptr<btCollisionShape>> shapes_;  ///< those of children come first
};

}  // namespace bsoil::random_worlds
