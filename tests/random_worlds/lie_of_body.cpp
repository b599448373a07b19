#include "lie_of_body.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "bsoil/contact/contact_law.h"
#include "bullet_types.h"
#include "lowest_point.h"

namespace bsoil::random_worlds {

using bullet::from_bullet;
using bullet::to_bullet;

namespace {

/// Means of two columns' heights on a plane differ by no more: each height is known to a voxel.
constexpr double kPlaneVoxels = 2;

/// The lowest corner of a mesh.
struct LowestCorner final : btTriangleCallback {
    LowestCorner(const btTransform& pose_of, Vec3 up_axis) : pose(pose_of), up(up_axis) {}
    void processTriangle(btVector3* corners, int, int) override {
        for (int i = 0; i < 3; ++i) {
            const Vec3 corner = from_bullet(pose * corners[i]);
            if (is_empty || dot(corner, up) < dot(point, up)) point = corner;
            is_empty = false;
        }
    }
    btTransform pose;
    Vec3 up, point;
    bool is_empty = true;
};

}  // namespace

Vec3 lowest_point(const btCollisionShape& shape, const btTransform& pose, Vec3 up) {
    if (shape.isConvex()) {
        const btVector3 down = to_bullet(-up) * pose.getBasis();
        return from_bullet(pose *
                           bullet::farthest_point(static_cast<const btConvexShape&>(shape), down));
    }
    Vec3 lowest = from_bullet(pose.getOrigin());
    if (shape.isCompound()) {
        const auto& compound = static_cast<const btCompoundShape&>(shape);
        for (int i = 0; i < compound.getNumChildShapes(); ++i) {
            const Vec3 of_child =
                lowest_point(*compound.getChildShape(i), pose * compound.getChildTransform(i), up);
            if (i == 0 || dot(of_child, up) < dot(lowest, up)) lowest = of_child;
        }
    } else if (shape.isConcave()) {
        LowestCorner corner(pose, up);
        btVector3 low, high;
        shape.getAabb(btTransform::getIdentity(), low, high);
        static_cast<const btConcaveShape&>(shape).processAllTriangles(&corner, low, high);
        if (!corner.is_empty) lowest = corner.point;
    }
    return lowest;
}

std::optional<double> surface_beside_m(const BuiltWorld& world, const bullet::SoilAction& soil,
                                       Vec3 at, double radius_m) {
    constexpr int kPoints = 24;
    const Quat axes = soil.soil().frame().grid_to_world.rotation;
    // Points of a circle lie evenly, so the plane's height in its middle is their mean: of pairs
    // across it, since one may lie beside the soil. On a plane all pairs have the same mean, but
    // for what a column's height is known to. Where they have not, banks of soil stand beside the
    // body, and their tops are not what it has sunk from: the level is what a third of the points
    // do not reach. The body's own hole is narrower than that.
    std::vector<double> heights_m;
    double sum_m = 0, lowest_m = std::numeric_limits<double>::infinity(), highest_m = -lowest_m;
    for (int i = 0; i < kPoints / 2; ++i) {
        const double angle = 2 * std::numbers::pi * i / kPoints;
        const Vec3 aside = rotate(axes, radius_m * Vec3{std::cos(angle), std::sin(angle), 0});
        const auto a = soil.surface_at(at + aside), b = soil.surface_at(at - aside);
        if (!a || !b) continue;
        for (const auto& point : {*a, *b}) heights_m.push_back(height_m(world, point.position_m));
        const double pair_m = heights_m.end()[-1] + heights_m.end()[-2];
        sum_m += pair_m;
        lowest_m = std::min(lowest_m, pair_m / 2);
        highest_m = std::max(highest_m, pair_m / 2);
    }
    if (heights_m.size() < kPoints / 2) return {};
    if (highest_m - lowest_m <= kPlaneVoxels * soil.soil().frame().voxel_m) {
        return sum_m / static_cast<double>(heights_m.size());
    }
    std::sort(heights_m.begin(), heights_m.end());
    return heights_m[heights_m.size() / 3];
}

Underside disc(double radius_m) { return {std::numbers::pi * radius_m * radius_m, {0}}; }

Underside underside_of(const btCollisionObject& object, Vec3 up, double radius_m) {
    constexpr int kRays = 40;  // across
    const double apart_m = 2 * radius_m / kRays;
    const btTransform& pose = object.getWorldTransform();
    const Vec3 middle = from_bullet(pose.getOrigin());
    const double lowest_m = dot(lowest_point(*object.getCollisionShape(), pose, up), up);
    // Two directions of the ground: up is an axis of the world.
    const Vec3 east{up.y, up.z, up.x}, north = cross(up, east);
    Underside under{apart_m * apart_m, {}};
    for (int i = 0; i < kRays * kRays; ++i) {
        const Vec3 below = middle + (i % kRays - (kRays - 1) / 2.0) * apart_m * east +
                           (i / kRays - (kRays - 1) / 2.0) * apart_m * north - 2 * radius_m * up;
        const btVector3 from = to_bullet(below), to = to_bullet(below + 4 * radius_m * up);
        btCollisionWorld::ClosestRayResultCallback hit(from, to);
        btCollisionWorld::rayTestSingle(
            btTransform({0, 0, 0, 1}, from), btTransform({0, 0, 0, 1}, to),
            const_cast<btCollisionObject*>(&object), object.getCollisionShape(), pose, hit);
        if (!hit.hasHit()) continue;
        under.heights_m.push_back(dot(from_bullet(hit.m_hitPointWorld), up) - lowest_m);
    }
    std::sort(under.heights_m.begin(), under.heights_m.end());
    return under;
}

double sinkage_after_fall_m(const Soil& soil, const Underside& underside, double weight_n,
                            double fall_m) {
    const auto contact_soil = std::make_shared<const ContactSoil>(soil.contact_soil());
    const auto law = ContactLaw::make(contact_soil);
    const double most_m = soil.frame().size[2] * soil.frame().voxel_m;
    ContactVoxel under;
    under.normal = -law->up();
    constexpr int kSteps = 1000;
    double worst_m = 0;
    for (size_t m = 0; m < contact_soil->materials.size(); ++m) {
        const MaterialDef& material = contact_soil->materials[m];
        under.material = static_cast<int>(m);
        FaceExtent plate{};
        if (material.has_density_range()) {
            plate.relative_density = material.relative_density(material.density_kg_m3);
        }
        double work_j = 0, at_m = 0, sum_m = 0;
        size_t below = 0;  // of the underside
        for (int i = 1; i <= kSteps && work_j <= weight_n * (fall_m + at_m); ++i) {
            // The first steps are fine: a light body rests in them.
            const double part = static_cast<double>(i) / kSteps;
            const double next_m = most_m * part * part;
            while (below < underside.heights_m.size() && underside.heights_m[below] < next_m) {
                sum_m += underside.heights_m[below++];
            }
            if (below > 0) {
                const auto count = static_cast<double>(below);
                const double area_m2 = count * underside.each_m2;
                // A disc has the second moments of area of a square of this side.
                plate.length_m = plate.width_m = std::sqrt(3 * area_m2 / std::numbers::pi);
                under.depth_m = under.bearing_depth_m = plate.depth_m = next_m - sum_m / count;
                work_j +=
                    area_m2 * (next_m - at_m) * law->yield({under, plate}, {}, {}).normal_limit_pa;
            }
            at_m = next_m;
        }
        worst_m = std::max(worst_m, at_m);
    }
    return worst_m;
}

double ground_height_m(const BuiltWorld& world, int soil, Vec3 at) {
    const SoilPlan& plan = world.plan().soils[static_cast<size_t>(soil)];
    const GridFrame& frame = world.soil(soil).soil().frame();
    Vec3 here = frame.to_grid(at);
    const double aside_m = here.x * frame.voxel_m - plan.def.size_m.x / 2;
    const bool has_terrain = plan.terrain_m > 0;
    here.z = has_terrain ? (plan.terrain_m + plan.terrain_slope * aside_m) / frame.voxel_m : 0;
    return height_m(world, frame.to_world(here));
}

void Turns::note(const btCollisionObject& object, Vec3 up, bool is_borne) {
    const btTransform& now = object.getWorldTransform();
    const auto before = poses_.find(&object);
    if (is_borne && before != poses_.end()) {
        const Vec3 lowest = lowest_point(*object.getCollisionShape(), now, up);
        const btVector3 of_body = now.inverse() * to_bullet(lowest);
        const btVector3 turned = before->second.getBasis() * of_body - now.getBasis() * of_body;
        double& most = most_m_[&object];
        most = std::max(most, dot(from_bullet(turned), up));
    }
    poses_[&object] = now;
}

double Turns::most_m(const btCollisionObject* object) const {
    const auto known = most_m_.find(object);
    return known == most_m_.end() ? 0 : known->second;
}

}  // namespace bsoil::random_worlds
