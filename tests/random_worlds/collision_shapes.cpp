#include "collision_shapes.h"

#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btMinkowskiSumShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>

namespace bsoil::random_worlds {
namespace {

btVector3 bullet(Vec3 v) {
    return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}
/// Half extents with the shape's own axis where Bullet has it.
btVector3 along(int axis, Vec3 half) {
    btVector3 out(scalar(half.x), scalar(half.x), scalar(half.x));
    out[axis] = scalar(half.z);
    return out;
}

}  // namespace

CollisionShapes::CollisionShapes() = default;
CollisionShapes::~CollisionShapes() {
    while (!shapes_.empty()) shapes_.pop_back();  // a parent before its children
}

template <typename Shape, typename... Arguments>
Shape& CollisionShapes::keep(Arguments&&... arguments) {
    auto made = std::make_unique<Shape>(std::forward<Arguments>(arguments)...);
    Shape& out = *made;
    shapes_.push_back(std::move(made));
    return out;
}

btCollisionShape& CollisionShapes::make(const ShapePlan& plan) {
    using Kind = ShapePlan::Kind;
    switch (plan.kind) {
        case Kind::box:
            return keep<btBoxShape>(bullet(plan.half_m));
        case Kind::sphere:
            return keep<btSphereShape>(scalar(plan.half_m.x));
        case Kind::capsule:
        case Kind::cylinder:
        case Kind::cone:
            return round(plan);
        case Kind::scaled:
        case Kind::minkowski_sum:
        case Kind::compound:
            return of_children(plan);
        case Kind::triangle_mesh:
        case Kind::scaled_triangle_mesh:
        case Kind::open_mesh:
        case Kind::moving_mesh:
        case Kind::heightfield:
            return of_triangles(plan);
        case Kind::plane:
            return keep<btStaticPlaneShape>(bullet(plan.half_m), scalar(0));
        case Kind::none:
            return keep<btEmptyShape>();
        default:
            return of_points(plan);
    }
}

btCollisionShape& CollisionShapes::round(const ShapePlan& plan) {
    const btScalar radius = scalar(plan.half_m.x), length = scalar(2 * plan.half_m.z);
    if (plan.kind == ShapePlan::Kind::cylinder) {
        const btVector3 half = along(plan.axis, plan.half_m);
        if (plan.axis == 0) return keep<btCylinderShapeX>(half);
        if (plan.axis == 1) return keep<btCylinderShape>(half);
        return keep<btCylinderShapeZ>(half);
    }
    if (plan.kind == ShapePlan::Kind::capsule) {
        if (plan.axis == 0) return keep<btCapsuleShapeX>(radius, length);
        if (plan.axis == 1) return keep<btCapsuleShape>(radius, length);
        return keep<btCapsuleShapeZ>(radius, length);
    }
    // Bullet adds the margin outside of a cone.
    btCollisionShape* cone = nullptr;
    if (plan.axis == 0) {
        cone = &keep<btConeShapeX>(radius, length);
    } else if (plan.axis == 1) {
        cone = &keep<btConeShape>(radius, length);
    } else {
        cone = &keep<btConeShapeZ>(radius, length);
    }
    cone->setMargin(scalar(0.05) * std::min(radius, length));
    return *cone;
}

btCollisionShape& CollisionShapes::of_points(const ShapePlan& plan) {
    std::vector<btVector3> points;
    for (const Vec3 p : plan.points_m) points.push_back(bullet(p));
    const int count = static_cast<int>(points.size());
    switch (plan.kind) {
        case ShapePlan::Kind::multi_sphere: {
            std::vector<btScalar> radii;
            for (const double r : plan.numbers_m) radii.push_back(scalar(r));
            return keep<btMultiSphereShape>(points.data(), radii.data(), count);
        }
        case ShapePlan::Kind::triangle: {
            auto& triangle = keep<btTriangleShape>(points[0], points[1], points[2]);
            triangle.setMargin(scalar(plan.margin_m));
            return triangle;
        }
        case ShapePlan::Kind::point_cloud: {
            heights_.push_back(std::make_unique<Heights>());  // the cloud points to its points
            std::vector<btScalar>& kept = heights_.back()->values;
            kept.resize(points.size() * 4 + 4);
            auto* first = reinterpret_cast<btVector3*>(
                (reinterpret_cast<uintptr_t>(kept.data()) + 15) & ~uintptr_t{15});
            std::copy(points.begin(), points.end(), first);
            auto& cloud = keep<btConvexPointCloudShape>(first, count, btVector3(1, 1, 1));
            cloud.setMargin(scalar(plan.margin_m));
            cloud.recalcLocalAabb();
            return cloud;
        }
        default: {
            auto& hull = keep<btConvexHullShape>();
            hull.setMargin(scalar(plan.margin_m));
            for (const btVector3& p : points) hull.addPoint(p, false);
            hull.recalcLocalAabb();
            return hull;
        }
    }
}

btCollisionShape& CollisionShapes::of_children(const ShapePlan& plan) {
    std::vector<btCollisionShape*> made;
    for (const ShapePlan& child : plan.children) made.push_back(&make(child));
    if (plan.kind == ShapePlan::Kind::scaled) {
        return keep<btUniformScalingShape>(static_cast<btConvexShape*>(made[0]),
                                           scalar(plan.half_m.x));
    }
    if (plan.kind == ShapePlan::Kind::minkowski_sum) {
        return keep<btMinkowskiSumShape>(static_cast<btConvexShape*>(made[0]),
                                         static_cast<btConvexShape*>(made[1]));
    }
    auto& compound = keep<btCompoundShape>();
    for (size_t i = 0; i < made.size(); ++i) {
        const Pose& pose = plan.child_poses[i];
        compound.addChildShape(
            btTransform(btQuaternion(scalar(pose.rotation.x), scalar(pose.rotation.y),
                                     scalar(pose.rotation.z), scalar(pose.rotation.w)),
                        bullet(pose.position)),
            made[i]);
    }
    return compound;
}

btTriangleMesh& CollisionShapes::mesh_of(const ShapePlan& plan) {
    meshes_.push_back(std::make_unique<btTriangleMesh>());
    for (size_t i = 0; i + 2 < plan.indices.size(); i += 3) {
        meshes_.back()->addTriangle(
            bullet(plan.points_m[static_cast<size_t>(plan.indices[i])]),
            bullet(plan.points_m[static_cast<size_t>(plan.indices[i + 1])]),
            bullet(plan.points_m[static_cast<size_t>(plan.indices[i + 2])]));
    }
    return *meshes_.back();
}

btCollisionShape& CollisionShapes::of_triangles(const ShapePlan& plan) {
    switch (plan.kind) {
        case ShapePlan::Kind::heightfield: {
            heights_.push_back(std::make_unique<Heights>());
            std::vector<btScalar>& values = heights_.back()->values;
            for (const double h : plan.numbers_m) values.push_back(scalar(h));
            // Bullet puts the middle of the range into the origin.
            btScalar most = 0;
            for (const btScalar h : values) most = std::max(most, std::abs(h));
            auto& field = keep<btHeightfieldTerrainShape>(plan.side_count, plan.side_count,
                                                          values.data(), -most, most, 2, false);
            field.setLocalScaling(bullet(plan.half_m));
            return field;
        }
        case ShapePlan::Kind::moving_mesh: {
            auto& mesh = keep<btGImpactMeshShape>(&mesh_of(plan));
            mesh.setMargin(scalar(plan.margin_m));
            mesh.updateBound();
            return mesh;
        }
        case ShapePlan::Kind::scaled_triangle_mesh: {
            auto& mesh = keep<btBvhTriangleMeshShape>(&mesh_of(plan), true);
            return keep<btScaledBvhTriangleMeshShape>(&mesh, bullet(plan.half_m));
        }
        default:
            return keep<btBvhTriangleMeshShape>(&mesh_of(plan), true);
    }
}

}  // namespace bsoil::random_worlds
