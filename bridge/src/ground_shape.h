/// GroundShape: the soil's surface as a Bullet shape.
#pragma once

#include <BulletCollision/CollisionShapes/btConcaveShape.h>

#include <span>

#include "bsoil/host/ground_surface.h"

class btTriangleRaycastCallback;

namespace bsoil::bullet {

/// Its frame is the grid's: x and y level, z up, origin at the box's lower corner. Its box is the
/// whole grid, so a surface that moves never leaves it. Rays ask only the cells they pass over.
class GroundShape final : public btConcaveShape {
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();
    /// height_m: of the grid's box.
    GroundShape(GroundSurface& surface, double height_m);

    void processAllTriangles(btTriangleCallback* callback, const btVector3& low,
                             const btVector3& high) const override;
    void getAabb(const btTransform& pose, btVector3& low, btVector3& high) const override;
    /// It cannot be scaled.
    void setLocalScaling(const btVector3&) override {}
    const btVector3& getLocalScaling() const override { return scaling_; }
    /// Static.
    void calculateLocalInertia(btScalar, btVector3& inertia) const override {
        inertia.setValue(0, 0, 0);
    }
    const char* getName() const override { return "Soil"; }

  private:
    /// The surface of all cells from first to last (inclusive), plane parts of it as a whole.
    void process_cells(GroundSurface::Cell first, GroundSurface::Cell last, double z_low_m,
                       double z_high_m, btTriangleCallback& callback) const;
    void process_cell(GroundSurface::Cell cell, double z_low_m, double z_high_m,
                      btTriangleCallback& callback) const;
    void process(std::span<const GroundSurface::Triangle> triangles, GroundSurface::Cell cell,
                 btTriangleCallback& callback) const;
    void process_ray(btTriangleRaycastCallback& ray) const;

    GroundSurface& surface_;
    btVector3 size_m_;
    btVector3 scaling_{1, 1, 1};
};

}  // namespace bsoil::bullet
