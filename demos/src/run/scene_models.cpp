#include "scene_models.h"

#include <algorithm>
#include <cmath>

#include "bsoil/render/primitives.h"
#include "robots/convex_hull.h"
#include "robots/mesh_file.h"

namespace bsoil::scene {
namespace {

render::Color color_of(Vec3 c) {
    return {static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z)};
}

/// From the axis the renderer's solids have, z, to the one the scene gives.
Quat axis_turn(const std::string& axis) {
    const double half = std::sqrt(0.5);
    if (axis == "x") return {0, half, 0, half};
    if (axis == "y") return {-half, 0, 0, half};
    return {};
}

Mesh solid_mesh(const ShapeItem& s, const render::Color& color, double bevel_m = 0) {
    Mesh mesh;
    if (s.shape == "box") {
        mesh = render::box_mesh(s.size_m * 0.5, color, bevel_m);
    } else if (s.shape == "sphere") {
        mesh = render::sphere_mesh(s.radius_m, color);
    } else if (s.shape == "capsule") {
        mesh = render::capsule_mesh(s.radius_m, s.height_m / 2, color);
    } else if (s.shape == "cylinder") {
        mesh = render::cylinder_mesh(s.radius_m, s.height_m / 2, color, bevel_m);
    } else if (s.shape == "cone") {
        mesh = render::cone_mesh(s.radius_m, s.height_m / 2, color);
    } else {
        mesh = render::triangle_mesh(s.mesh ? *s.mesh : convex_hull(s.points_m).surface, color);
    }
    const bool has_axis = s.shape == "capsule" || s.shape == "cylinder" || s.shape == "cone";
    if (has_axis) render::transform_mesh(mesh, {{}, axis_turn(s.axis)});
    return mesh;
}

}  // namespace

Mesh body_mesh(const BodyItem& body) {
    Mesh all;
    const auto append = [&all](Mesh mesh, const Pose& pose) {
        render::transform_mesh(mesh, pose);
        all.append(mesh);
    };
    for (const DrawnItem& item : body.drawn) {
        const render::Color color = color_of(item.solid.color.value_or(body.color));
        if (item.mesh_file.empty()) {
            append(solid_mesh(item.solid, color, item.bevel_m), item.solid.pose);
        } else if (const auto triangles = read_robot_mesh(item.mesh_file, item.mesh_scale)) {
            append(render::triangle_mesh(*triangles, color), item.solid.pose);
        } else {
            all = {};  // a file that cannot be read after all
            break;
        }
    }
    if (!all.indices.empty()) return all;
    for (const ShapeItem& solid : body.solids()) {
        const render::Color color = color_of(solid.color.value_or(body.color));
        append(solid_mesh(solid, color), body.shape.shape == "compound" ? solid.pose : Pose{});
    }
    return all;
}

Vec3 sun_beside(const render::Camera& camera) {
    constexpr double kBeside = 0.7, kBeyond = 0.4, kUp = 0.4;
    Vec3 back = camera.eye - camera.target;
    back = back - camera.up * dot(back, camera.up);
    if (length(back) < 1e-6) back = cross(camera.up, Vec3{0.6, 0.64, 0.48});  // looks straight down
    back = back * (1 / length(back));
    return cross(camera.up, back) * kBeside - back * kBeyond + camera.up * kUp;
}

render::Camera scene_camera(const Scene& scene) {
    Vec3 center, size{4, 4, 4};
    if (scene.soil) {
        size = scene.soil->def.size_m;
        center = scene.soil->def.floor_center_m;
    }
    const double side = std::max({size.x, size.y, size.z});
    render::Camera camera;
    camera.up = scene.world.up == "y" ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
    camera.fov_rad = scene.camera.view_angle_rad;
    camera.target = scene.camera.target_m.value_or(center + camera.up * (0.2 * side));
    const Vec3 sideways = cross({1, 0, 0}, camera.up);
    camera.eye = scene.camera.eye_m.value_or(center + Vec3{0.9 * side, 0, 0} +
                                             sideways * (0.9 * side) + camera.up * (0.8 * side));
    return camera;
}

}  // namespace bsoil::scene
