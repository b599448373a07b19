/// Rows and mirror images of what a scene file says of a body's looks.
#include <cmath>

#include "scene.h"

namespace bsoil::scene {
namespace {

Quat turn_about(const std::string& axis, double angle_rad) {
    const double s = std::sin(angle_rad / 2), c = std::cos(angle_rad / 2);
    if (axis == "x") return {s, 0, 0, c};
    if (axis == "y") return {0, s, 0, c};
    return {0, 0, s, c};
}

/// The solid on the other side of the plane y = 0. All forms are alike on both sides of their own;
/// a hull is not, its points are reflected.
ShapeItem mirrored(ShapeItem solid) {
    solid.pose.position.y = -solid.pose.position.y;
    const Quat r = solid.pose.rotation;
    solid.pose.rotation = {-r.x, r.y, -r.z, r.w};
    for (Vec3& point : solid.points_m) point.y = -point.y;
    return solid;
}

}  // namespace

std::vector<DrawnItem> drawn_items(const VisualItem& visual, const std::string& mesh_file) {
    std::vector<DrawnItem> items;
    for (int i = 0; i < visual.repeat_count; ++i) {
        const Quat turn = turn_about(visual.repeat_axis, i * visual.repeat_turn_rad);
        const Vec3 center = visual.repeat_center_m;
        const Pose copy{visual.repeat_step_m * i + center - rotate(turn, center), turn};
        DrawnItem item;
        item.solid = visual.solid;
        item.solid.pose = copy * visual.solid.pose;
        item.mesh_file = mesh_file;
        item.mesh_scale = {visual.scale, visual.scale, visual.scale};
        item.bevel_m = visual.bevel_m;
        item.has_own_textures = !visual.solid.color;
        items.push_back(item);
        if (!visual.mirror) continue;
        item.solid = mirrored(item.solid);
        items.push_back(std::move(item));
    }
    return items;
}

}  // namespace bsoil::scene
