#include "scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace bsoil::scene {
namespace {

template <typename T>
const T* find_named(const std::vector<T>& items, const std::string& name) {
    const auto found =
        std::find_if(items.begin(), items.end(), [&](const T& item) { return item.name == name; });
    return found == items.end() ? nullptr : &*found;
}

/// A quarter turn about x, exact for vectors: z up becomes y up (sign -1) or the other way round
/// (+1).
struct QuarterTurn {
    double sign;
    Vec3 operator()(Vec3 v) const { return {v.x, -sign * v.z, sign * v.y}; }
    Quat operator()(Quat q) const {
        const double half = std::sqrt(0.5);
        return Quat{sign * half, 0, 0, half} * q;
    }
    Pose operator()(const Pose& p) const { return {(*this)(p.position), (*this)(p.rotation)}; }
    void apply(Vec3& v) const { v = (*this)(v); }
    void apply(std::optional<Vec3>& v) const {
        if (v) v = (*this)(*v);
    }
    void apply(Pose& p) const { p = (*this)(p); }
    /// Of a box: turned corners are no longer lowest and highest.
    void apply_box(Vec3& min, Vec3& max) const {
        const Vec3 a = (*this)(min), b = (*this)(max);
        min = {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
        max = {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
    }
};

/// Open sides of a soil whose scene is turned.
int turned_sides(int sides, const QuarterTurn& turn) {
    int out = 0;
    for (int bit = 1; bit <= kOpenSideLast; bit <<= 1) {
        if ((sides & bit) == 0) continue;
        const bool is_high = (bit & (kOpenHighX | kOpenHighY | kOpenHighZ)) != 0;
        const double s = is_high ? 1 : -1;
        const Vec3 to =
            turn(Vec3{bit <= kOpenHighX ? s : 0, bit > kOpenHighX && bit <= kOpenHighY ? s : 0,
                      bit > kOpenHighY ? s : 0});
        out |= to.x < 0 ? kOpenLowX : to.x > 0 ? kOpenHighX : 0;
        out |= to.y < 0 ? kOpenLowY : to.y > 0 ? kOpenHighY : 0;
        out |= to.z < 0 ? kOpenLowZ : to.z > 0 ? kOpenHighZ : 0;
    }
    return out;
}

}  // namespace

SinkDef SinkItem::def() const {
    SinkDef out;
    if (shape == "sphere") out.region.kind = ConvexShape::Kind::sphere;
    if (shape == "cylinder") out.region.kind = ConvexShape::Kind::cylinder;
    out.region.half_extents_m = 0.5 * size_m;
    out.region.radius_m = radius_m;
    out.region.half_height_m = height_m / 2;
    out.pose = pose;
    out.rate_kg_s = rate_kg_s;
    out.water_kg_s = water_kg_s;
    out.start_s = start_s;
    out.end_s = end_s;
    return out;
}

std::vector<ShapeItem> BodyItem::solids() const {
    return shape.shape == "compound" ? parts : std::vector<ShapeItem>{shape};
}

bool CheckItem::needs_soil() const {
    static constexpr std::string_view kOfBodies[] = {"body_at_rest", "distance_travelled",
                                                     "speed_steady", "body_rise",
                                                     "body_height",  "energy_not_rising"};
    return std::find(std::begin(kOfBodies), std::end(kOfBodies), kind) == std::end(kOfBodies);
}

std::optional<size_t> SoilItem::material_index(const std::string& name) const {
    for (size_t i = 0; i < def.materials.size(); ++i) {
        if (def.materials[i].name == name) return i;
    }
    return {};
}

const BodyItem* Scene::find_body(const std::string& name) const { return find_named(bodies, name); }
const JointItem* Scene::find_joint(const std::string& name) const {
    return find_named(joints, name);
}
const ProbeItem* Scene::find_probe(const std::string& name) const {
    return find_named(probes, name);
}

bool Scene::is_raycast_chassis(const std::string& body) const {
    return std::any_of(raycast_vehicles.begin(), raycast_vehicles.end(),
                       [&](const RaycastVehicleItem& vehicle) { return vehicle.chassis == body; });
}

std::string Scene::message(SourcePosition at, const std::string& text) const {
    return fmt::format("{}:{}:{}: {}", path, at.line, at.column, text);
}

FrameLength frame_length(const Scene& scene) {
    const double wanted_s = scene.soil ? scene.soil->def.step_s : scene.world.step_s;
    const int count = std::max(1, static_cast<int>(std::lround(wanted_s / scene.world.substep_s)));
    return {scene.soil ? wanted_s : count * scene.world.substep_s, count};
}

void set_up_axis(Scene& scene, UpAxis up) {
    const std::string wanted = up == UpAxis::y ? "y" : "z";
    if (scene.world.up == wanted) return;
    scene.world.up = wanted;
    const QuarterTurn turn{up == UpAxis::y ? -1.0 : 1.0};
    if (scene.soil) {
        turn.apply(scene.soil->def.floor_center_m);
        turn.apply(scene.soil->def.wind_m_s);
        std::swap(scene.soil->def.size_m.y, scene.soil->def.size_m.z);
        scene.soil->def.open_sides = turned_sides(scene.soil->def.open_sides, turn);
    }
    for (SourceItem& source : scene.sources) {
        turn.apply(source.def.center_m);
        turn.apply(source.def.direction);
    }
    for (SinkItem& sink : scene.sinks) turn.apply(sink.pose);
    for (FillItem& fill : scene.fills) {
        turn.apply_box(fill.min_m, fill.max_m);
        turn.apply(fill.base_center_m);
        // Its rows follow the second level axis, y or z, which look opposite ways.
        auto& heights_m = fill.height_map.heights_m;
        for (int row = 0; 2 * (row + 1) <= fill.height_map.height; ++row) {
            const auto at = heights_m.begin() + ptrdiff_t{row} * fill.height_map.width;
            const auto mirrored = heights_m.end() - ptrdiff_t{row + 1} * fill.height_map.width;
            std::swap_ranges(at, at + fill.height_map.width, mirrored);
        }
    }
    for (TerrainItem& terrain : scene.terrains) {
        turn.apply(terrain.pose);
        for (Vec3& vertex : terrain.mesh.vertices) turn.apply(vertex);
    }
    for (BodyItem& body : scene.bodies) {
        turn.apply(body.pose);
        turn.apply(body.velocity_m_s);
        turn.apply(body.angular_velocity_rad_s);
    }
    for (BulletFileItem& file : scene.bullet_files) turn.apply(file.pose);
    for (JointItem& joint : scene.joints) {
        turn.apply(joint.point_m);
        turn.apply(joint.axis);
        turn.apply(joint.spring_axis);
    }
    for (MotionItem& motion : scene.motions) {
        for (MotionKey& key : motion.motion_keys) {
            turn.apply(key.position_m);
            // A key that names none has the axes of the scene as it was written.
            if (!motion.body.empty()) key.rotation = turn(key.rotation.value_or(Quat{}));
        }
    }
    for (ProbeItem& probe : scene.probes) {
        turn.apply(probe.from_m);
        turn.apply(probe.to_m);
        if (probe.body.empty()) turn.apply(probe.region.pose);
    }
    turn.apply(scene.camera.eye_m);
    turn.apply(scene.camera.target_m);
    for (CheckItem& check : scene.checks) {
        turn.apply(check.center_m);
        turn.apply(check.at_m);
        turn.apply(check.direction);
    }
}

SoilDef soil_def(const Scene& scene) {
    SoilDef def = scene.soil->def;
    def.up = scene.world.up == "y" ? UpAxis::y : UpAxis::z;
    def.gravity_m_s2 = scene.world.gravity_m_s2;
    return def;
}

}  // namespace bsoil::scene
