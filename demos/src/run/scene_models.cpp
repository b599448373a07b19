#include "scene_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "bsoil/render/primitives.h"
#include "files/data_files.h"
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

/// Adds a mesh to a look. places, file: of a texture; empty: colours alone.
void append(BodyLook& look, Mesh mesh, const Pose& pose, std::vector<float> places,
            const std::string& file) {
    render::transform_mesh(mesh, pose);
    if (!file.empty() && !mesh.indices.empty()) {
        look.places.resize(2 * look.mesh.vertex_count());
        look.places.insert(look.places.end(), places.begin(), places.end());
        look.parts.push_back({file, static_cast<uint32_t>(look.mesh.indices.size()),
                              static_cast<uint32_t>(mesh.indices.size())});
    }
    look.mesh.append(mesh);
}

/// Places in a texture for a solid about its z axis, centred: a box has the whole of it on each
/// face, a cylinder on each end, and round solids have it wrapped around them once.
std::vector<float> solid_places(const ShapeItem& s, const Mesh& mesh) {
    const double half_m = s.shape == "box"      ? s.size_m.z / 2
                          : s.shape == "sphere" ? s.radius_m
                                                : s.height_m / 2;
    std::vector<float> places;
    for (size_t v = 0; v < mesh.positions.size(); v += 3) {
        const double x = mesh.positions[v], y = mesh.positions[v + 1], z = mesh.positions[v + 2];
        double across = 0, up = z / half_m;
        const double nx = mesh.normals[v], ny = mesh.normals[v + 1], nz = mesh.normals[v + 2];
        if (s.shape == "box") {
            const double of_x = 2 * x / s.size_m.x, of_y = 2 * y / s.size_m.y;
            if (std::abs(nz) > 0.9) up = of_y * (nz > 0 ? 1 : -1);
            across = std::abs(nx) > 0.9   ? of_y * (nx > 0 ? 1 : -1)
                     : std::abs(ny) > 0.9 ? of_x * (ny > 0 ? -1 : 1)
                                          : of_x;
        } else if (s.shape == "cylinder" && std::abs(nz) > 0.9) {
            across = x / s.radius_m;
            up = y / s.radius_m * (nz > 0 ? 1 : -1);
        } else {
            // The last vertex of a ring lies a rounding below the first.
            const double angle = std::atan2(y, x);
            across = (angle < 0 ? angle + 2 * std::numbers::pi : angle) / std::numbers::pi - 1;
        }
        places.push_back(static_cast<float>((1 + across) / 2));
        places.push_back(static_cast<float>((1 + up) / 2));
    }
    return places;
}

/// The files of a skin's textures; empty where there is none, which is noted.
std::vector<std::string> texture_files(const DrawnItem& item, const MeshSkin& skin,
                                       std::vector<std::string>& notes) {
    std::vector<std::string> files;
    for (std::string name : skin.names) {
        std::replace(name.begin(), name.end(), '\\', '/');
        const auto file = find_robot_file("texture", name, item.mesh_file);
        if (!file) notes.push_back(item.mesh_file + ": " + file.error());
        files.push_back(file ? *file : std::string());
    }
    return files;
}

/// Adds a mesh file to a look: its triangles by their textures, one after another. False where it
/// cannot be read.
bool append_file(BodyLook& look, const DrawnItem& item, const render::Color& color) {
    const bool may_have_textures = item.has_own_textures || !item.texture_file.empty();
    MeshSkin skin;
    auto mesh =
        read_robot_mesh(item.mesh_file, item.mesh_scale, may_have_textures ? &skin : nullptr);
    if (!mesh) return false;
    std::vector<std::string> files;
    if (!item.texture_file.empty()) {
        files = {item.texture_file};
        std::fill(skin.textures.begin(), skin.textures.end(), skin.has_places ? 0 : -1);
        if (!skin.has_places) {
            look.notes.push_back(item.mesh_file + ": has no places for the texture " +
                                 item.texture_file);
        }
    } else {
        files = texture_files(item, skin, look.notes);
    }
    if (files.empty()) {
        append(look, render::triangle_mesh(*mesh, color), item.solid.pose, {}, {});
        return true;
    }
    std::map<std::string, TriangleMesh> runs;
    for (size_t t = 0; t < mesh->triangles.size(); ++t) {
        const int texture = skin.textures[t];
        runs[texture < 0 ? std::string() : files[static_cast<size_t>(texture)]].triangles.push_back(
            mesh->triangles[t]);
    }
    for (auto& [file, run] : runs) {
        run.vertices.swap(mesh->vertices);
        std::vector<float> places;
        for (const auto& triangle : run.triangles) {
            // triangle_mesh() leaves out those without an area.
            const Vec3 a = run.vertices[triangle[0]], b = run.vertices[triangle[1]],
                       c = run.vertices[triangle[2]];
            if (file.empty() || !(length(cross(b - a, c - a)) > 0)) continue;
            for (const int v : triangle) {
                const auto& place = skin.places[static_cast<size_t>(v)];
                places.insert(places.end(), place.begin(), place.end());
            }
        }
        append(look, render::triangle_mesh(run, color), item.solid.pose, std::move(places), file);
        run.vertices.swap(mesh->vertices);
    }
    return true;
}

/// Textures of a scene, each on the device once.
class SceneTextures {
  public:
    SceneTextures(render::Renderer& renderer, std::vector<std::string>& notes)
        : renderer_(renderer), notes_(notes) {}

    /// None where it cannot be shown, which is noted once.
    render::TextureId find(const std::string& file) {
        const auto [found, is_new] = ids_.try_emplace(file);
        if (!is_new) return found->second;
        auto picture = read_texture(file);
        if (!picture) {
            notes_.push_back(picture.error());
            return {};
        }
        if (picture->rgba.size() > kTextureBytesMost - bytes_) {
            notes_.push_back(fmt::format("{}: the scene's textures have more than {} MiB together",
                                         file, kTextureBytesMost >> 20));
            return {};
        }
        const size_t bytes = picture->rgba.size();
        const auto added =
            renderer_.add_texture({picture->width, picture->height, std::move(picture->rgba)});
        if (!added) {
            notes_.push_back(file + ": " + added.error());
            return {};
        }
        bytes_ += bytes;
        return found->second = *added;
    }

  private:
    render::Renderer& renderer_;
    std::vector<std::string>& notes_;
    std::map<std::string, render::TextureId> ids_;
    size_t bytes_ = 0;
};

}  // namespace

BodyLook body_look(const BodyItem& body) {
    BodyLook look;
    for (const DrawnItem& item : body.drawn) {
        const render::Color color = color_of(item.solid.color.value_or(body.color));
        if (item.mesh_file.empty()) {
            Mesh mesh = solid_mesh(item.solid, color, item.bevel_m);
            std::vector<float> places;
            if (!item.texture_file.empty()) places = solid_places(item.solid, mesh);
            append(look, std::move(mesh), item.solid.pose, std::move(places), item.texture_file);
        } else if (!append_file(look, item, color)) {
            look = {};  // a file that cannot be read after all
            break;
        }
    }
    if (look.mesh.indices.empty()) {
        for (const ShapeItem& solid : body.solids()) {
            const render::Color color = color_of(solid.color.value_or(body.color));
            append(look, solid_mesh(solid, color),
                   body.shape.shape == "compound" ? solid.pose : Pose{}, {}, {});
        }
    }
    if (!look.parts.empty()) look.places.resize(2 * look.mesh.vertex_count());
    return look;
}

Mesh body_mesh(const BodyItem& body) { return body_look(body).mesh; }

std::vector<render::MeshId> add_body_meshes(const Scene& scene, render::Renderer& renderer,
                                            std::vector<std::string>& notes) {
    SceneTextures textures(renderer, notes);
    std::vector<render::MeshId> meshes;
    for (const BodyItem& body : scene.bodies) {
        BodyLook look = body_look(body);
        notes.insert(notes.end(), look.notes.begin(), look.notes.end());
        render::Skin skin{std::move(look.places), {}};
        for (const BodyLook::Part& part : look.parts) {
            skin.parts.push_back(
                {textures.find(part.texture_file), part.index_begin, part.index_count});
        }
        meshes.push_back(renderer.add_mesh(look.mesh, skin));
    }
    return meshes;
}

Vec3 sun_beside(const render::Camera& camera) {
    constexpr double kBeside = 0.7, kBeyond = 0.4, kUp = 0.4;
    Vec3 back = camera.eye - camera.target;
    back = back - camera.up * dot(back, camera.up);
    if (length(back) < 1e-6) back = cross(camera.up, Vec3{0.6, 0.64, 0.48});  // looks straight down
    back = back * (1 / length(back));
    return cross(camera.up, back) * kBeside - back * kBeyond + camera.up * kUp;
}

void keep_off_vertical(render::Camera& camera) {
    constexpr double kAside = 1e-3, kInLine = 1e-6;
    const double sight_m = length(camera.target - camera.eye);
    if (length(cross(camera.target - camera.eye, camera.up)) > kInLine * sight_m) return;
    const Vec3 south = cross({1, 0, 0}, camera.up);
    camera.eye += south * (kAside * sight_m);
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
    keep_off_vertical(camera);
    return camera;
}

}  // namespace bsoil::scene
