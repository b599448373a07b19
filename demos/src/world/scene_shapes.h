/// Solids of a scene as Bullet shapes.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

#include "bsoil/result.h"
#include "robots/bullet_vectors.h"
#include "scene/scene.h"

namespace bsoil::scene {

/// Owns the shapes of a world.
class SceneShapes {
  public:
    /// The shape of a body: of mass `mass_kg`, and its centre of mass and principal axes in the
    /// body's frame.
    struct BodyShape {
        btCollisionShape* shape = nullptr;
        btTransform center = btTransform::getIdentity();
        btVector3 inertia{0, 0, 0};  ///< principal moments [kg m2]
    };
    /// A mesh becomes a btBvhTriangleMeshShape where the body never moves, else a
    /// btGImpactMeshShape. Error: a hull without volume, at its place in `scene`.
    Result<BodyShape> make(const Scene& scene, const BodyItem& item);
    /// An endless plane through `height_m`.
    btCollisionShape* make_plane(const btVector3& up, double height_m);
    /// Whether there is a shape for which the dispatcher needs the GImpact algorithm.
    bool has_gimpact() const { return has_gimpact_; }

  private:
    btCollisionShape* make_solid(const ShapeItem& solid, bool can_move);
    btCollisionShape* make_mesh(const TriangleMesh& mesh, bool can_move);
    template <typename T>
    T* keep(std::unique_ptr<T> shape) {
        T* kept = shape.get();
        shapes_.push_back(std::move(shape));
        return kept;
    }

    std::vector<std::unique_ptr<btTriangleMesh>> meshes_;
    std::vector<std::unique_ptr<btCollisionShape>> shapes_;
    bool has_gimpact_ = false;
};

}  // namespace bsoil::scene
