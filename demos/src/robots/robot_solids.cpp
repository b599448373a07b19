#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "convex_parts.h"
#include "mesh_file.h"
#include "robot_builder.h"
#include "scene/rotations.h"

namespace bsoil::scene {

namespace {

/// A URDF's colours are those of the screen.
Vec3 linear_color(const urdf::Color& c) {
    constexpr double kScreenGamma = 2.2;
    const auto linear = [](float v) { return std::pow(std::clamp<double>(v, 0, 1), kScreenGamma); };
    return {linear(c.r), linear(c.g), linear(c.b)};
}

}  // namespace

Status RobotBuilder::add_solids(const urdf::Collision& collision, const std::string& link,
                                const RobotLinkItem* item, std::vector<ShapeItem>& solids) const {
    const std::string& mode = item && item->has("collision") ? item->collision : robot_.collision;
    if (!collision.geometry || mode == "none") return Done{};
    ShapeItem solid;
    if (collision.geometry->type == urdf::Geometry::MESH) {
        const Status placed = place(collision.origin, link, "collision", solid);
        if (!placed) return placed;
        return add_mesh(static_cast<const urdf::Mesh&>(*collision.geometry), solid, mode, link,
                        item, solids);
    }
    const Status made = make_primitive(*collision.geometry, collision.origin, link, solid);
    if (!made) return made;
    solids.push_back(std::move(solid));
    return Done{};
}

Status RobotBuilder::place(const urdf::Pose& origin, const std::string& link, const char* what,
                           ShapeItem& solid) const {
    solid.at = robot_.at;
    solid.pose = to_pose(origin);
    if (!is_rigid(solid.pose) || length(solid.pose.position) > kLargestLength) {
        return error("link \"{}\": its {} must have a finite origin", link, what);
    }
    return Done{};
}

Status RobotBuilder::make_primitive(const urdf::Geometry& geometry, const urdf::Pose& origin,
                                    const std::string& link, ShapeItem& solid) const {
    const Status placed = place(origin, link, "collision", solid);
    if (!placed) return placed;
    const auto size_is_wrong = [](double x) { return !(x >= 1e-5 && x <= kLargestLength); };
    switch (geometry.type) {
        case urdf::Geometry::BOX: {
            solid.shape = "box";
            solid.size_m = to_vec3(static_cast<const urdf::Box&>(geometry).dim);
            const Vec3 s = solid.size_m;
            if (size_is_wrong(s.x) || size_is_wrong(s.y) || size_is_wrong(s.z)) {
                return error("link \"{}\": the box {} x {} x {} m must have finite sizes above 0",
                             link, s.x, s.y, s.z);
            }
            break;
        }
        case urdf::Geometry::SPHERE:
            solid.shape = "sphere";
            solid.radius_m = static_cast<const urdf::Sphere&>(geometry).radius;
            if (size_is_wrong(solid.radius_m)) {
                return error("link \"{}\": the radius {} m must be finite and above 0", link,
                             solid.radius_m);
            }
            break;
        case urdf::Geometry::CYLINDER: {
            const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
            solid.shape = "cylinder";
            solid.radius_m = cylinder.radius;
            solid.height_m = cylinder.length;
            if (size_is_wrong(solid.radius_m) || size_is_wrong(solid.height_m)) {
                return error(
                    "link \"{}\": the cylinder of radius {} m and length {} m must "
                    "have finite sizes above 0",
                    link, solid.radius_m, solid.height_m);
            }
            break;
        }
        default:
            return error("link \"{}\": a solid must be a box, sphere, cylinder or mesh", link);
    }
    return Done{};
}

std::vector<DrawnItem> RobotBuilder::visuals_of(const urdf::Link& link) {
    std::vector<DrawnItem> drawn;
    for (const auto& visual : link.visual_array) {
        if (!visual || !visual->geometry) continue;
        DrawnItem& item = drawn.emplace_back();
        Status made = Done{};
        if (visual->geometry->type == urdf::Geometry::MESH) {
            const auto& mesh = static_cast<const urdf::Mesh&>(*visual->geometry);
            made = place(visual->origin, link.name, "visual", item.solid);
            const auto path = find_robot_file("mesh", mesh.filename, path_);
            if (made && !path) made = Error{path.error()};
            if (path) item.mesh_file = *path;
            item.mesh_scale = to_vec3(mesh.scale);
        } else {
            made = make_primitive(*visual->geometry, visual->origin, link.name, item.solid);
        }
        if (!made) {
            warn("link \"{}\": a visual is not drawn: {}", link.name, made.error());
            drawn.pop_back();
            continue;
        }
        if (visual->material) use_material(*visual->material, link.name, item);
    }
    return drawn;
}

void RobotBuilder::use_material(const urdf::Material& material, const std::string& link,
                                DrawnItem& item) {
    item.has_own_textures = false;
    const urdf::Color& color = material.color;
    if (material.texture_filename.empty()) {
        item.solid.color = linear_color(color);
        return;
    }
    // Without a colour beside the texture urdfdom has black.
    if (color.r > 0 || color.g > 0 || color.b > 0) item.solid.color = linear_color(color);
    const auto texture = find_robot_file("texture", material.texture_filename, path_);
    if (texture) {
        item.texture_file = *texture;
    } else {
        warn("link \"{}\": {}", link, texture.error());
    }
}

Status RobotBuilder::add_mesh(const urdf::Mesh& mesh, ShapeItem solid, const std::string& mode,
                              const std::string& link, const RobotLinkItem* item,
                              std::vector<ShapeItem>& solids) const {
    const auto path = find_robot_file("mesh", mesh.filename, path_);
    if (!path) return error("link \"{}\": {}", link, path.error());
    auto triangles = read_robot_mesh(*path, to_vec3(mesh.scale));
    if (!triangles) return error("link \"{}\": {}", link, triangles.error());
    for (const Vec3 p : triangles->vertices) {
        if (length(p) > kLargestLength) {
            return error(
                "link \"{}\": {}: a vertex lies {:g} m out, must be at most {:g} m; check its "
                "scale",
                link, *path, length(p), kLargestLength);
        }
    }
    if (mode == "mesh") {
        solid.shape = "mesh";
        solid.mesh = std::make_shared<const TriangleMesh>(std::move(*triangles));
        solids.push_back(std::move(solid));
        return Done{};
    }
    const ConvexHull whole = convex_hull(triangles->vertices);
    const int capacity = item ? item->part_capacity : RobotLinkItem{}.part_capacity;
    std::vector<ConvexHull> hulls{whole};
    if (mode == "components") {
        hulls = component_hulls(*triangles);
        if (hulls.size() > static_cast<size_t>(capacity)) {
            hulls.resize(static_cast<size_t>(capacity));
        }
    }
    if (mode == "decompose") hulls = convex_parts(*triangles, capacity);
    if (whole.volume_m3 <= 0 || hulls.empty()) {
        return error("link \"{}\": {}: its hull has no volume; make it a thin box", link, *path);
    }
    Vec3 middle;
    for (const Vec3 p : whole.surface.vertices) {
        middle += p * (1.0 / static_cast<double>(whole.surface.vertices.size()));
    }
    solid.shape = "hull";
    for (const ConvexHull& hull : hulls) {
        solid.points_m = thickened(hull, item ? item->thickness_m : 0, middle).surface.vertices;
        solids.push_back(solid);
    }
    return Done{};
}

}  // namespace bsoil::scene
