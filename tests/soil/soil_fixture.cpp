#include "soil_fixture.h"

#include <numbers>

#include "soil/soil_kernels.h"

namespace bsoil {

MaterialDef fixed_density(MaterialDef material) {
    material.loose_density_kg_m3 = material.compacted_density_kg_m3 = 0;
    return material;
}

SoilDef grid_def(int nx, int ny, int nz, double voxel_m) {
    SoilDef def;
    def.material = fixed_density(materials::dry_sand());
    def.up = UpAxis::z;
    def.voxel_m = voxel_m;
    def.size_m = {nx * voxel_m, ny * voxel_m, nz * voxel_m};
    def.floor_center_m = {nx * voxel_m / 2, ny * voxel_m / 2, 0};
    def.backend = Backend::cpu;
    def.thread_count = 1;
    return def;
}

MaterialDef sand(double friction_deg, double cohesion_pa) {
    MaterialDef material = fixed_density(materials::dry_sand());
    material.friction_angle_rad = friction_deg * std::numbers::pi / 180;
    material.cohesion_pa = cohesion_pa;
    return material;
}

std::unique_ptr<Soil> make_soil(const SoilDef& def) {
    auto soil = Soil::create(def);
    if (!soil) {
        ADD_FAILURE() << soil.error();
        return nullptr;
    }
    return std::move(*soil);
}

const std::string& gl_missing() {
    static const std::string reason = [] {
        const auto device = device::create_gl_device(soil_kernel_set(), true);
        // A kernel that does not compile is a failure, not a machine without GL.
        const bool is_absent =
            !device && device.error().find("does not compile") == std::string::npos;
        return is_absent ? device.error() : std::string();
    }();
    return reason;
}

BoxFill voxel_box(const Soil& soil, Vec3 low, Vec3 high, const std::string& material) {
    const double voxel = soil.frame().voxel_m;
    return {{low * voxel, high * voxel}, material};
}

Mover::Mover(int id, ConvexShape shape, Vec3 position, bool is_static) : shapes{std::move(shape)} {
    body.id = id;
    body.pose.position = position;
    body.center_of_mass_m = position;
    body.is_static = is_static;
    body.shapes = &shapes;
}

Mover::Mover(Mover&& other) noexcept : body(other.body), shapes(std::move(other.shapes)) {
    body.shapes = &shapes;
}

void Mover::set_velocity(Vec3 linear, Vec3 angular) {
    body.linear_velocity_m_s = linear;
    body.angular_velocity_rad_s = angular;
}

void Mover::advance(double dt) {
    body.pose.position += body.linear_velocity_m_s * dt;
    body.center_of_mass_m = body.pose.position;
    const double rate = length(body.angular_velocity_rad_s);
    if (rate > 0) {
        body.pose.rotation =
            turn(body.angular_velocity_rad_s * (1 / rate), rate * dt) * body.pose.rotation;
    }
}

ConvexShape box_shape(Vec3 half_extents_m) {
    ConvexShape shape;
    shape.kind = ConvexShape::Kind::box;
    shape.half_extents_m = half_extents_m;
    return shape;
}

ConvexShape sphere_shape(double radius_m) {
    return round_shape(ConvexShape::Kind::sphere, radius_m, 0);
}

ConvexShape round_shape(ConvexShape::Kind kind, double radius_m, double half_height_m) {
    ConvexShape shape;
    shape.kind = kind;
    shape.radius_m = radius_m;
    shape.half_height_m = half_height_m;
    return shape;
}

ConvexShape octahedron_shape(double radius_m) {
    ConvexShape shape;
    shape.kind = ConvexShape::Kind::hull;
    shape.bound_m = radius_m;
    const double n = 1 / std::numbers::sqrt3;
    for (int i = 0; i < 8; ++i) {
        shape.planes.push_back({{i & 1 ? n : -n, i & 2 ? n : -n, i & 4 ? n : -n}, radius_m * n});
    }
    return shape;
}

Quat turn(Vec3 axis, double angle_rad) {
    const double s = std::sin(angle_rad / 2);
    return {axis.x * s, axis.y * s, axis.z * s, std::cos(angle_rad / 2)};
}

std::vector<SoilBody> bodies_of(const std::vector<Mover>& movers) {
    std::vector<SoilBody> bodies;
    for (const Mover& mover : movers) bodies.push_back(mover.body);
    return bodies;
}

}  // namespace bsoil
