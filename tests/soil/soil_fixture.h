/// What the soil's tests share: access to the inside of a soil, small soils, bodies.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "bsoil/soil.h"
#include "soil/soil_impl.h"

namespace bsoil {

/// The friend through which tests reach single stages.
struct SoilProbe {
    static Soil::Impl& impl(Soil& soil) { return *soil.impl_; }
};

/// A grid of whole voxels of `voxel_m`, Z up, lower corner at the world's origin: world metres /
/// voxel_m are grid voxels.
/// The material without its range of densities: it neither swells nor compacts.
MaterialDef fixed_density(MaterialDef material);

SoilDef grid_def(int nx, int ny, int nz, double voxel_m = 0.05);

/// Dry sand of a chosen angle of friction.
MaterialDef sand(double friction_deg, double cohesion_pa = 0);

/// The soil, or null and a test failure.
std::unique_ptr<Soil> make_soil(const SoilDef& def);

/// Why this machine has no OpenGL for the soil (software counts); empty when it has.
const std::string& gl_missing();

/// A box of soil, in grid voxels of a soil from grid_def.
BoxFill voxel_box(const Soil& soil, Vec3 low, Vec3 high, const std::string& material = {});

/// A body of one shape that moves steadily: advance() before each step. Metres and seconds.
struct Mover {
    SoilBody body;
    std::vector<ConvexShape> shapes;

    Mover(int id, ConvexShape shape, Vec3 position, bool is_static = false);
    Mover(const Mover&) = delete;
    Mover(Mover&& other) noexcept;
    void set_velocity(Vec3 linear, Vec3 angular = {});
    /// Moves the body by dt of its velocity, about its origin.
    void advance(double dt);
};

ConvexShape box_shape(Vec3 half_extents_m);
ConvexShape sphere_shape(double radius_m);
ConvexShape round_shape(ConvexShape::Kind kind, double radius_m, double half_height_m);
/// A regular octahedron of `radius_m` as a hull.
ConvexShape octahedron_shape(double radius_m);

/// Quaternion of a turn by `angle_rad` about a unit axis.
Quat turn(Vec3 axis, double angle_rad);

/// The bodies of movers, for Soil::step.
std::vector<SoilBody> bodies_of(const std::vector<Mover>& movers);

}  // namespace bsoil
