#include "scene_shapes.h"

#include <BulletCollision/CollisionShapes/btShapeHull.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <fmt/format.h>

#include <numbers>

#include "robots/bullet_vectors.h"
#include "robots/convex_hull.h"
#include "robots/convex_parts.h"

namespace bsoil::scene {
namespace {

/// Collision margin of hulls and cones [m], which Bullet adds on the outside.
constexpr double kMargin = 0.002;
/// Hulls with more points than this are replaced by Bullet's own simplification of them.
constexpr int kHullPointCapacity = 100;

double volume_m3(const ShapeItem& s) {
    if (s.shape == "box") return s.size_m.x * s.size_m.y * s.size_m.z;
    const double disc = std::numbers::pi * s.radius_m * s.radius_m;
    if (s.shape == "sphere") return disc * s.radius_m * 4 / 3;
    if (s.shape == "capsule") return disc * (s.height_m + s.radius_m * 4 / 3);
    if (s.shape == "cylinder") return disc * s.height_m;
    if (s.shape == "cone") return disc * s.height_m / 3;
    if (s.shape == "mesh") return mesh_volume_m3(*s.mesh);
    return convex_hull(s.points_m).volume_m3;
}

std::unique_ptr<btConvexShape> make_hull(const ShapeItem& s) {
    const ConvexHull hull = convex_hull(s.points_m);
    if (hull.surface.vertices.empty()) return nullptr;
    auto shape = std::make_unique<btConvexHullShape>();
    for (const Vec3 p : hull.surface.vertices) shape->addPoint(to_bullet(p), false);
    shape->recalcLocalAabb();
    shape->setMargin(scalar(kMargin));
    if (shape->getNumPoints() <= kHullPointCapacity) return shape;
    btShapeHull simple(shape.get());
    simple.buildHull(scalar(kMargin));
    auto smaller = std::make_unique<btConvexHullShape>(&simple.getVertexPointer()->x(),
                                                       simple.numVertices(), sizeof(btVector3));
    smaller->setMargin(scalar(kMargin));
    return smaller;
}

/// The Bullet shape of a convex solid; null where a hull has no volume.
std::unique_ptr<btConvexShape> make_convex(const ShapeItem& s) {
    const btScalar r = scalar(s.radius_m), h = scalar(s.height_m);
    if (s.shape == "box") return std::make_unique<btBoxShape>(to_bullet(s.size_m * 0.5));
    if (s.shape == "sphere") return std::make_unique<btSphereShape>(r);
    if (s.shape == "capsule") {
        if (s.axis == "x") return std::make_unique<btCapsuleShapeX>(r, h);
        if (s.axis == "y") return std::make_unique<btCapsuleShape>(r, h);
        return std::make_unique<btCapsuleShapeZ>(r, h);
    }
    if (s.shape == "cylinder") {
        if (s.axis == "x") return std::make_unique<btCylinderShapeX>(btVector3(h / 2, r, r));
        if (s.axis == "y") return std::make_unique<btCylinderShape>(btVector3(r, h / 2, r));
        return std::make_unique<btCylinderShapeZ>(btVector3(r, r, h / 2));
    }
    if (s.shape == "cone") {
        std::unique_ptr<btConvexShape> cone;
        if (s.axis == "x") {
            cone = std::make_unique<btConeShapeX>(r, h);
        } else if (s.axis == "y") {
            cone = std::make_unique<btConeShape>(r, h);
        } else {
            cone = std::make_unique<btConeShapeZ>(r, h);
        }
        cone->setMargin(scalar(kMargin));
        return cone;
    }
    return make_hull(s);
}

/// Has a body's own axes for its principal ones: what couples turns about them is left out.
void keep_axes(SceneShapes::BodyShape& shape) {
    const btMatrix3x3& axes = shape.center.getBasis();
    btVector3 moments;
    for (int i = 0; i < 3; ++i) moments[i] = (axes[i] * axes[i]).dot(shape.inertia);
    shape.inertia = moments;
    shape.center.setBasis(btMatrix3x3::getIdentity());
}

}  // namespace

btCollisionShape* SceneShapes::make_plane(const btVector3& up, double height_m) {
    return keep(std::make_unique<btStaticPlaneShape>(up, scalar(height_m)));
}

btCollisionShape* SceneShapes::make_mesh(const TriangleMesh& mesh, bool can_move) {
    auto triangles = std::make_unique<btTriangleMesh>();
    for (const auto& [a, b, c] : mesh.triangles) {
        triangles->addTriangle(to_bullet(mesh.vertices[static_cast<size_t>(a)]),
                               to_bullet(mesh.vertices[static_cast<size_t>(b)]),
                               to_bullet(mesh.vertices[static_cast<size_t>(c)]));
    }
    meshes_.push_back(std::move(triangles));
    if (!can_move) {
        return keep(std::make_unique<btBvhTriangleMeshShape>(meshes_.back().get(), true));
    }
    has_gimpact_ = true;
    auto* shape = keep(std::make_unique<btGImpactMeshShape>(meshes_.back().get()));
    shape->updateBound();
    return shape;
}

btCollisionShape* SceneShapes::make_solid(const ShapeItem& solid, bool can_move) {
    if (solid.shape == "mesh") return make_mesh(*solid.mesh, can_move);
    std::unique_ptr<btConvexShape> shape = make_convex(solid);
    return shape ? keep(std::move(shape)) : nullptr;
}

Result<SceneShapes::BodyShape> SceneShapes::make(const Scene& scene, const BodyItem& item) {
    const std::vector<ShapeItem> solids = item.solids();
    const bool moves = item.mass_kg > 0 && !item.kinematic;
    std::vector<btCollisionShape*> children;
    std::vector<btScalar> masses;
    for (const ShapeItem& solid : solids) {
        btCollisionShape* shape = make_solid(solid, moves || item.kinematic);
        if (!shape) {
            return Error{scene.message(
                solid.where("points_m"),
                fmt::format("the hull of body \"{}\" has no volume; make it a thin box",
                            item.name))};
        }
        children.push_back(shape);
        masses.push_back(scalar(solid.mass_kg.value_or(volume_m3(solid))));
    }
    BodyShape out;
    out.shape = children[0];
    if (item.shape.shape != "compound") {
        if (moves) out.shape->calculateLocalInertia(scalar(item.mass_kg), out.inertia);
        return out;
    }
    btCompoundShape unweighted;
    for (size_t i = 0; i < children.size(); ++i) {
        unweighted.addChildShape(to_bullet(solids[i].pose), children[i]);
    }
    if (item.inertial) {
        out.center = to_bullet(item.inertial->frame);
        out.inertia = to_bullet(item.inertial->moments_kg_m2);
    } else if (moves) {
        btScalar total = 0;
        for (const btScalar mass : masses) total += mass;
        for (btScalar& mass : masses) mass *= scalar(item.mass_kg) / total;
        unweighted.calculatePrincipalAxisTransform(masses.data(), out.center, out.inertia);
    }
    // Bullet's vehicle counts its wheels and the way it drives in the chassis' frame.
    if (scene.is_raycast_chassis(item.name)) keep_axes(out);
    auto* compound = keep(std::make_unique<btCompoundShape>());
    for (size_t i = 0; i < children.size(); ++i) {
        compound->addChildShape(out.center.inverse() * to_bullet(solids[i].pose), children[i]);
    }
    out.shape = compound;
    return out;
}

}  // namespace bsoil::scene
