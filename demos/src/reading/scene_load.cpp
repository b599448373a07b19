#include "scene_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bsoil/contact/bekker_soil.h"
#include "files/data_files.h"
#include "files/text_file.h"
#include "measure_rules.h"
#include "motion_keys.h"
#include "robots/bullet_bodies.h"
#include "robots/raycast_wheels.h"
#include "robots/track_vehicle.h"
#include "robots/urdf_robot.h"
#include "scene/terrain_noise.h"
#include "schema_table.h"
#include "toml_file.h"

namespace bsoil::scene {
namespace {

/// The rules the schema's table cannot say: names, references between tables, files.
class SceneChecker {
  public:
    SceneChecker(Scene& scene, std::vector<SchemaError>& errors) : scene_(scene), errors_(errors) {}

    void run() {
        check_soil();
        for (FillItem& fill : scene_.fills) check_fill(fill);
        for (TerrainItem& terrain : scene_.terrains) check_terrain(terrain);
        add_robots();
        add_bullet_files();
        add_tracks();
        add_raycast_vehicles();
        check_bodies();
        check_joints();
        for (const MotionItem& motion : scene_.motions) check_motion(motion);
        check_probes();
        for (const std::string& body : scene_.record.bodies) {
            need_body(body, scene_.record.where("bodies"));
        }
        if (!scene_.camera.follow.empty()) {
            need_body(scene_.camera.follow, scene_.camera.where("follow"));
        }
        for (const CheckItem& check : scene_.checks) check_check(check);
        for (SchemaError& found : measure_errors(scene_)) errors_.push_back(std::move(found));
    }

    void check_soil();

  private:
    template <typename... Args>
    void error(SourcePosition at, fmt::format_string<Args...> text, Args&&... args) {
        errors_.push_back({at, fmt::format(text, std::forward<Args>(args)...)});
    }

    template <typename T>
    void unique_names(const std::vector<T>& items, const char* table) {
        std::map<std::string, int> first_line;
        for (const T& item : items) {
            const auto [first, inserted] = first_line.emplace(item.name, item.where("name").line);
            if (!inserted) {
                error(item.where("name"),
                      "a [[{}]] named \"{}\" stands in line {} already; rename one", table,
                      item.name, first->second);
            }
        }
    }

    void need_body(const std::string& name, SourcePosition at) {
        if (!robots_incomplete_ && !scene_.find_body(name)) {
            error(at, "no [[body]] is named \"{}\"; check the name, or add one", name);
        }
    }

    Result<MaterialDef> material_named(const std::string& name) {
        for (const MaterialItem& item : scene_.materials) {
            if (item.name != name) continue;
            auto base = materials::find(item.base);
            if (!base) return base;
            MaterialDef def = *base;
            def.name = name;
            if (item.density_kg_m3) {  // the base's range is that of its own density
                def.density_kg_m3 = *item.density_kg_m3;
                set_range_of_loose_bed(def);
            }
#define BSOIL_REPLACE(field, ...) def.field = item.field.value_or(def.field);
            BSOIL_MATERIAL_FIELDS(BSOIL_REPLACE)
#undef BSOIL_REPLACE
            if (item.color) {
                def.color = {static_cast<float>(item.color->x), static_cast<float>(item.color->y),
                             static_cast<float>(item.color->z)};
            }
            return def;
        }
        auto built_in = materials::find(name);
        if (!built_in) {
            return Error{fmt::format("no [[material]] is named \"{}\", and no built-in: {}", name,
                                     built_in.error())};
        }
        return built_in;
    }

    /// Sets the densities of a material that is given by Bekker's parameters.
    void translate_bekker(MaterialItem& item) {
        for (const char* key : {"cohesion_pa", "friction_angle_deg"}) {
            if (!item.has(key)) return error(item.where("bekker"), "`bekker` needs `{}`", key);
        }
        for (const char* key : {"loose_density_kg_m3", "compacted_density_kg_m3"}) {
            if (item.has(key)) {
                return error(item.where(key), "`{}` is what `bekker` is turned into; leave it out",
                             key);
            }
        }
        BekkerSoil soil;
        soil.kphi_pa_m_n = item.bekker->kphi;
        soil.kc_pa_m_n1 = item.bekker->kc;
        soil.n = item.bekker->n;
        soil.cohesion_pa = *item.cohesion_pa;
        soil.friction_angle_rad = *item.friction_angle_rad;
        soil.shear_displacement_m = item.shear_displacement_m.value_or(0);
        soil.density_kg_m3 = item.density_kg_m3;
        BekkerOptions options;
        options.gravity_m_s2 = item.bekker->gravity_m_s2;
        item.bekker_soil = soil;
        const auto found = translate(soil, options);
        if (!found) return error(item.where("bekker"), "`bekker`: {}", found.error());
        item.density_kg_m3 = found->material.density_kg_m3;
        item.loose_density_kg_m3 = found->material.loose_density_kg_m3;
        item.compacted_density_kg_m3 = found->material.compacted_density_kg_m3;
        scene_.warnings.push_back(scene_.message(
            item.where("bekker"),
            fmt::format("the bearing of \"{}\" differs from Bekker's by {:.0f} % (median; at most "
                        "{:.0f} %): `bsoil import-bekker` prints where",
                        item.name, 100 * found->median_error, 100 * found->largest_error)));
    }

    /// Of a soil whose law takes a material's own Bekker parameters.
    void add_bekker(SoilItem& soil, const std::string& name) {
        const auto item = std::find_if(scene_.materials.begin(), scene_.materials.end(),
                                       [&name](const MaterialItem& m) { return m.name == name; });
        if (item == scene_.materials.end() || !item->bekker_soil) {
            return error(soil.where("contact_law"),
                         "`contact_law` \"bekker\" needs [material.bekker] of \"{}\"", name);
        }
        soil.def.contact_law.bekker.push_back(*item->bekker_soil);
    }

    void need_soil_material(const std::string& name, SourcePosition at) {
        if (scene_.soil && !name.empty() && !scene_.soil->material_index(name)) {
            error(at, "\"{}\" is none of the soil's materials; add it to `materials` of [soil]",
                  name);
        }
    }

    void check_fill(FillItem& fill) {
        need_soil_material(fill.material, fill.where("material"));
        if (fill.kind == "box" && !(fill.min_m.x < fill.max_m.x && fill.min_m.y < fill.max_m.y &&
                                    fill.min_m.z < fill.max_m.z)) {
            error(fill.where("max_m"), "`max_m` must exceed `min_m` along every axis");
        }
        if (fill.kind == "height_map") {
            const std::string path = existing(fill.file, fill.where("file"));
            if (path.empty()) return;
            auto map = read_height_map(path, fill.min_height_m, fill.max_height_m);
            if (map) {
                fill.height_map = std::move(*map);
            } else {
                error(fill.where("file"), "{}", map.error());
            }
        }
    }

    void check_terrain(TerrainItem& terrain) {
        if (terrain.kind != "mesh") {
            const Status cheap =
                scene_.soil ? check_terrain_cost(terrain, soil_def(scene_)) : Done{};
            if (!cheap) error(terrain.at, "{}", cheap.error());
            return;
        }
        const std::string path = existing(terrain.file, terrain.where("file"));
        if (path.empty()) return;
        auto mesh = read_mesh(path);
        if (!mesh) return error(terrain.where("file"), "{}", mesh.error());
        for (Vec3& vertex : mesh->vertices) {
            vertex = transform(terrain.pose, vertex * terrain.scale);
        }
        terrain.mesh = std::move(*mesh);
    }

    /// The path of a file, or empty with an error (or a note, where it is data that may be absent).
    std::string existing(const std::string& name, SourcePosition at) {
        const std::string path = find_file(name, scene_.path);
        if (!path.empty()) return path;
        if (name.starts_with("data:")) {
            scene_.missing_data.push_back(name);
        } else {
            error(at, "there is no file \"{}\" beside the scene; check its name", name);
        }
        return {};
    }

    void add_robots() {
        unique_names(scene_.robots, "robot");
        for (const RobotItem& robot : scene_.robots) {
            const std::string path = existing(robot.file, robot.where("file"));
            robots_incomplete_ |= path.empty();
            if (path.empty()) continue;
            const Status added = add_robot(scene_, robot, path);
            robots_incomplete_ |= !added;
            if (!added) error(robot.where("file"), "{}", added.error());
        }
    }

    void add_bullet_files() {
        unique_names(scene_.bullet_files, "bullet_file");
        for (BulletFileItem& item : scene_.bullet_files) {
            item.path = existing(item.file, item.where("file"));
            robots_incomplete_ |= item.path.empty();
            if (item.path.empty()) continue;
            auto survey = survey_bullet_file(item.path);
            robots_incomplete_ |= !survey;
            if (!survey) {
                error(item.where("file"), "{}", survey.error());
                continue;
            }
            add_bullet_bodies(scene_, item, std::move(*survey));
        }
    }

    void add_tracks() {
        unique_names(scene_.tracks, "track");
        for (const TrackItem& track : scene_.tracks) {
            need_body(track.hull, track.where("hull"));
            if (scene_.find_body(track.hull)) add_track(scene_, track, errors_);
        }
    }

    void add_raycast_vehicles() {
        unique_names(scene_.raycast_vehicles, "raycast_vehicle");
        for (RaycastVehicleItem& vehicle : scene_.raycast_vehicles) {
            need_body(vehicle.chassis, vehicle.where("chassis"));
            if (scene_.find_body(vehicle.chassis)) add_raycast_wheels(scene_, vehicle, errors_);
        }
    }

    void add_visuals(BodyItem& body) {
        for (const VisualItem& visual : body.visuals) {
            if (visual.solid.shape == "hull" && visual.solid.points_m.size() < 4) {
                error(visual.where("points_m"), "a hull needs at least 4 points");
            }
            if (visual.mirror && visual.solid.shape == "mesh") {
                error(visual.where("mirror"),
                      "a mesh has no mirror image here; write the second one out");
            }
            std::string path;
            if (visual.solid.shape == "mesh") {
                path = existing(visual.file, visual.where("file"));
                if (path.empty()) continue;
            }
            for (DrawnItem& item : drawn_items(visual, path)) body.drawn.push_back(std::move(item));
        }
    }

    void check_bodies() {
        unique_names(scene_.bodies, "body");
        for (BodyItem& body : scene_.bodies) {
            add_visuals(body);
            if (body.shape.shape == "compound" && body.parts.empty()) {
                error(body.at, "a compound needs at least one [[body.part]]");
            }
            size_t weighed = 0;
            double weighed_kg = 0;
            for (const ShapeItem& solid : body.solids()) {
                weighed += solid.mass_kg.has_value() ? 1u : 0u;
                weighed_kg += solid.mass_kg.value_or(0);
                if (solid.shape == "hull" && solid.points_m.size() < 4) {
                    error(solid.where("points_m"), "a hull needs at least 4 points");
                }
            }
            if (body.ignore_soil && (body.tool_friction || body.tool_adhesion_pa)) {
                error(
                    body.where("ignore_soil"),
                    "\"{}\" has a surface for soil that it does not meet; leave one of the two out",
                    body.name);
            }
            if (weighed != 0 && weighed != body.parts.size()) {
                error(body.at, "give `mass_kg` for all parts of \"{}\" or for none", body.name);
            }
            if (weighed != 0 && weighed_kg <= 0 && body.mass_kg > 0) {
                error(body.at, "no part of \"{}\" has a mass; give `mass_kg`", body.name);
            }
        }
    }

    void need_no_link(const std::string& name, SourcePosition at) {
        const BodyItem* body = scene_.find_body(name);
        if (body && !body->multibody.empty()) {
            error(at,
                  "\"{}\" is a link of a multibody, which a [[joint]] cannot hold; give the "
                  "[[robot]] `build = \"bodies\"`",
                  name);
        }
    }

    void check_joints() {
        unique_names(scene_.joints, "joint");
        for (const JointItem& joint : scene_.joints) {
            if (joint.parent != "world") need_body(joint.parent, joint.where("parent"));
            need_body(joint.child, joint.where("child"));
            if (joint.parent == joint.child) {
                error(joint.where("child"), "joins \"{}\" to itself; name two bodies", joint.child);
            }
            if (!joint.is_of_multibody) {
                need_no_link(joint.parent, joint.where("parent"));
                need_no_link(joint.child, joint.where("child"));
            }
            if (length(joint.axis) < 1e-6) {
                error(joint.where("axis"), "the axis must have a length");
            }
            if (joint.kind == "suspension" &&
                std::abs(dot(joint.axis, joint.spring_axis)) >
                    1e-3 * length(joint.axis) * length(joint.spring_axis)) {
                error(joint.where("spring_axis"), "`spring_axis` must be square to `axis`");
            }
            if (joint.lower_rad.has_value() != joint.upper_rad.has_value() ||
                joint.lower_m.has_value() != joint.upper_m.has_value()) {
                error(joint.at, "give both stops or none");
            }
            if (joint.lower_rad && *joint.lower_rad > *joint.upper_rad) {
                error(joint.where("lower_deg"), "the lower stop must not lie above the upper one");
            }
            if (joint.lower_m && *joint.lower_m > *joint.upper_m) {
                error(joint.where("lower_m"), "the lower stop must not lie above the upper one");
            }
        }
    }

    void check_motion(const MotionItem& motion) {
        if (motion.joint.empty() == motion.body.empty()) {
            return error(motion.at, "a [[motion]] must move a `joint` or a `body`, one of them");
        }
        const JointItem* joint = nullptr;
        if (!motion.joint.empty() && !robots_incomplete_) {
            joint = scene_.find_joint(motion.joint);
            if (!joint) {
                return error(motion.where("joint"),
                             "no [[joint]] is named \"{}\"; check the name, or add one",
                             motion.joint);
            }
            if (joint->motor_torque_n_m <= 0 && joint->motor_force_n <= 0) {
                error(motion.where("joint"),
                      "joint \"{}\" has no motor; give it `motor_force_n` or `motor_torque_n_m`",
                      motion.joint);
            }
        }
        if (!motion.body.empty()) {
            need_body(motion.body, motion.where("body"));
            const BodyItem* body = scene_.find_body(motion.body);
            if (body && !body->kinematic) {
                error(motion.where("body"), "\"{}\" is not kinematic; give it `kinematic = true`",
                      motion.body);
            }
        }
        for (SchemaError& found : motion_key_errors(motion, joint)) {
            errors_.push_back(std::move(found));
        }
    }

    void check_probes() {
        unique_names(scene_.probes, "probe");
        for (const ProbeItem& probe : scene_.probes) {
            if (!probe.body.empty()) need_body(probe.body, probe.where("body"));
            need_soil_material(probe.material, probe.where("material"));
        }
    }

    void check_check(const CheckItem& check) {
        if (!check.body.empty()) need_body(check.body, check.where("body"));
        if (!check.probe.empty()) {
            const ProbeItem* probe = scene_.find_probe(check.probe);
            if (!probe) {
                error(check.where("probe"),
                      "no [[probe]] is named \"{}\"; check the name, or add one", check.probe);
            } else if (probe->kind != "mass_inside") {
                error(check.where("probe"),
                      "probe \"{}\" does not measure a mass; name one that does", check.probe);
            }
        }
        if (check.kind == "mass_in_region" && (check.min_fraction || check.max_fraction) &&
            !check.has("reference_s")) {
            error(check.at, "fractions must have a `reference_s`");
        }
        for (const std::string& name : check.bodies) {
            const BodyItem* body = scene_.find_body(name);
            if (!robots_incomplete_ && !body) {
                error(check.where("bodies"),
                      "no [[body]] is named \"{}\"; check the name, or add one", name);
            } else if (body && (body->kinematic || body->mass_kg <= 0)) {
                error(check.where("bodies"), "\"{}\" has no mass and so no energy; leave it out",
                      name);
            }
        }
        if (!scene_.soil && check.needs_soil()) {
            error(check.where("kind"), "\"{}\" needs a [soil]", check.kind);
        }
    }

    Scene& scene_;
    std::vector<SchemaError>& errors_;
    bool robots_incomplete_ = false;  // bodies and joints of an absent robot cannot be looked up
};

void SceneChecker::check_soil() {
    unique_names(scene_.materials, "material");
    for (MaterialItem& material : scene_.materials) {
        const auto base = materials::find(material.base);
        if (!base) error(material.where("base"), "{}", base.error());
        if (material.bekker) translate_bekker(material);
    }
    if (!scene_.soil) {
        if (!scene_.fills.empty()) error(scene_.fills[0].at, "[[fill]] needs a [soil]");
        if (!scene_.terrains.empty()) error(scene_.terrains[0].at, "[[terrain]] needs a [soil]");
        if (!scene_.probes.empty()) error(scene_.probes[0].at, "[[probe]] needs a [soil]");
        return;
    }
    SoilItem& soil = *scene_.soil;
    if (!soil.material.empty() && !soil.materials.empty()) {
        error(soil.where("materials"), "`material` or `materials` must be given, not both");
    }
    const bool list = !soil.materials.empty();
    const std::vector<std::string> names =
        list ? soil.materials
             : std::vector<std::string>{soil.material.empty() ? "dry_sand" : soil.material};
    for (const std::string& name : names) {
        auto material = material_named(name);
        if (!material) {
            error(soil.where(list ? "materials" : "material"), "{}", material.error());
            continue;
        }
        soil.def.materials.push_back(*material);
        if (soil.def.contact_law.kind == ContactLawDef::Kind::bekker) add_bekker(soil, name);
    }
    soil.def = soil_def(scene_);
    if (!errors_.empty()) return;
    const Status valid = soil.def.validate();
    if (!valid) error(soil.at, "{}", valid.error());
    const double ratio = soil.def.step_s / scene_.world.substep_s;
    if (std::abs(ratio - std::round(ratio)) > 1e-3 || ratio < 0.5) {
        error(scene_.world.where("substep_s"), "`substep_s` {} must divide the soil's `step_s` {}",
              scene_.world.substep_s, soil.def.step_s);
    }
}

}  // namespace

void check_soil(Scene& scene, std::vector<SchemaError>& errors) {
    SceneChecker(scene, errors).check_soil();
}

Result<Scene> parse_scene(const std::string& text, const std::string& path) {
    Scene scene;
    scene.path = path;
    auto parsed = parse_toml(text, path);
    if (!parsed) return Error{parsed.error()};
    std::vector<SchemaError> errors;
    read_table(*parsed, scene_schema(), &scene, errors);
    if (errors.empty()) SceneChecker(scene, errors).run();
    if (errors.empty()) return scene;
    return Error{error_text(std::move(errors), path)};
}

std::map<std::string, std::string> values_of(const std::string& table, const SceneItem& item) {
    const std::vector<KeySpec>& keys = scene_schema().keys;
    const auto key = std::ranges::find(keys, table, &KeySpec::name);
    return key != keys.end() && key->table ? values_in(item, *key->table) : item.said;
}

Result<Scene> load_scene(const std::string& path) {
    const auto text = read_file(path, kTomlCapacity);
    if (!text) return Error{text.error()};
    return parse_scene(*text, path);
}

}  // namespace bsoil::scene
