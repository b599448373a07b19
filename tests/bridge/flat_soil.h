// A stand-in for the soil: flat, unyielding in shape, contacts from the depth of points on the
// bodies' surfaces.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "body_collector.h"
#include "contact_coupling.h"
#include "world_anchor.h"

namespace bsoil::bullet {

/// Points on the surface of a box or a cylinder, in the body's frame, with outward normals and
/// areas.
inline std::vector<ContactVoxel> surface_points(const ConvexShape& shape, int per_side) {
    std::vector<ContactVoxel> out;
    const auto add = [&](Vec3 p, Vec3 n, double area) {
        ContactVoxel v;
        v.position_m = transform(shape.local, p);
        v.normal = rotate(shape.local.rotation, n);
        v.area_m2 = area;
        out.push_back(v);
    };
    const auto at = [per_side](int i) { return (2.0 * i + 1) / per_side - 1; };
    if (shape.kind == ConvexShape::Kind::box) {
        const Vec3 h = shape.half_extents_m;
        for (int i = 0; i < per_side; ++i) {
            for (int j = 0; j < per_side; ++j) {
                for (const double s : {-1.0, 1.0}) {
                    const double u = at(i), v = at(j), cells = 0.25 * per_side * per_side;
                    add({s * h.x, u * h.y, v * h.z}, {s, 0, 0}, h.y * h.z / cells);
                    add({u * h.x, s * h.y, v * h.z}, {0, s, 0}, h.x * h.z / cells);
                    add({u * h.x, v * h.y, s * h.z}, {0, 0, s}, h.x * h.y / cells);
                }
            }
        }
    } else if (shape.kind == ConvexShape::Kind::cylinder) {
        const int around = 16 * per_side;
        const double r = shape.radius_m, h = shape.half_height_m;
        for (int i = 0; i < around; ++i) {
            const double angle = 2 * std::numbers::pi * i / around;
            const Vec3 n{std::cos(angle), std::sin(angle), 0};
            for (int j = 0; j < per_side; ++j) {
                add(r * n + Vec3{0, 0, at(j) * h}, n,
                    2 * std::numbers::pi * r / around * 2 * h / per_side);
                const double ring = (j + 0.5) / per_side * r;
                for (const double s : {-1.0, 1.0}) {
                    add(ring * n + Vec3{0, 0, s * h}, {0, 0, s},
                        2 * std::numbers::pi * ring / around * r / per_side);
                }
            }
        }
    }
    return out;
}

/// Soil fills everything below y = level_m.
class FlatSoil final : public btActionInterface {
  public:
    FlatSoil(btDiscreteDynamicsWorld& world, const MaterialDef& material, double step_s = 1.0 / 60)
        : world_(world),
          step_s_(step_s),
          collector({{-20, -2, -20}, {20, 2, 20}}),
          coupling(world, {{0, 1, 0}, 9.81, 0.1, {material}, {}}, known, SoilActionDef{}, threads),
          anchor(
              world, btVector3(0, 0, 0), [this] { coupling.open_substep(); }, [] {}) {
        world.addAction(this);
    }
    ~FlatSoil() override { world_.removeAction(this); }

    void updateAction(btCollisionWorld*, btScalar substep_s) override {
        coupling.close_substep(substep_s);
        unstepped_s_ += static_cast<double>(substep_s);
        if (unstepped_s_ < 0.999 * step_s_) return;
        unstepped_s_ -= step_s_;
        collector.collect(world_, step_s_);
        contacts.clear();
        for (const SoilBody& body : collector.soil_bodies(0)) {
            if (body.is_static) continue;
            for (const ConvexShape& shape : *body.shapes) {
                for (ContactVoxel v : surface_points(shape, points_per_side)) {
                    v.center_m = v.position_m = transform(body.pose, v.position_m);
                    v.normal = rotate(body.pose.rotation, v.normal);
                    v.body = body.id;
                    v.depth_m = v.bearing_depth_m = level_m - v.position_m.y;
                    if (v.depth_m > 0) contacts.push_back(v);
                }
            }
        }
        coupling.set_contacts(collector.bodies(), contacts, step_s_);
    }
    void debugDraw(btIDebugDraw*) override { coupling.take_rows_out(); }

    BodyReport report(const btCollisionObject& object) const {
        return coupling.report(collector.body_id(object));
    }

  private:
    btDiscreteDynamicsWorld& world_;
    double step_s_, unstepped_s_ = 0;

  public:
    double level_m = 0;
    int points_per_side = 12;
    std::vector<ContactVoxel> contacts;
    BodyCollector collector;
    WorkThreads threads{1};
    KnownContacts known;
    ContactCoupling coupling;
    WorldAnchor anchor;
};

}  // namespace bsoil::bullet
