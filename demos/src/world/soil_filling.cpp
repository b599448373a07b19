#include "soil_filling.h"

#include "scene/terrain_noise.h"

namespace bsoil::scene {
namespace {

Status put_in(const FillItem& item, const std::string& material, Soil& soil) {
    if (item.kind == "box") return soil.fill(BoxFill{{item.min_m, item.max_m}, material});
    if (item.kind == "cylinder") {
        return soil.fill(CylinderFill{item.base_center_m, item.radius_m, item.height_m, material});
    }
    if (item.kind == "height_map") {
        HeightMapFill fill = item.height_map;
        fill.material = material;
        return soil.fill(fill);
    }
    NoiseFill fill = item.noise;
    fill.material = material;
    return soil.fill(fill);
}

}  // namespace

Result<std::vector<int>> fill_soil(const Scene& scene, Soil& soil) {
    const auto refused = [&scene](const SceneItem& item, const std::string& error) {
        return Error{scene.message(item.at, error)};
    };
    for (const TerrainItem& terrain : scene.terrains) {
        const Status added = terrain.kind == "mesh"
                                 ? soil.add_terrain(terrain.mesh)
                                 : soil.add_terrain(terrain_density(terrain, soil.def().up,
                                                                    soil.def().floor_center_m));
        if (!added) return refused(terrain, added.error());
    }
    for (const FillItem& fill : scene.fills) {
        const std::string material =
            fill.material.empty() ? soil.materials().front().name : fill.material;
        const Status filled = put_in(fill, material, soil);
        if (!filled) return refused(fill, filled.error());
    }
    std::vector<int> source_ids;
    for (const SourceItem& source : scene.sources) {
        const auto added = soil.add_source(source.def);
        if (!added) return refused(source, added.error());
        source_ids.push_back(*added);
    }
    for (const SinkItem& sink : scene.sinks) {
        const auto added = soil.add_sink(sink.def());
        if (!added) return refused(sink, added.error());
    }
    return source_ids;
}

Status set_surfaces(const Scene& scene, const BulletScene& world, bullet::SoilAction& action) {
    for (const SceneBody& body : world.bodies()) {
        if (!body.item->tool_friction && !body.item->tool_adhesion_pa) continue;
        const SurfaceFriction as_material;
        bullet::BodyOptions options = action.options(*body.object);
        options.surface = {body.item->tool_friction.value_or(as_material.friction),
                           body.item->tool_adhesion_pa.value_or(as_material.adhesion_pa)};
        const Status set = action.set_options(*body.object, options);
        if (!set) return Error{scene.message(body.item->at, set.error())};
    }
    return Done{};
}

}  // namespace bsoil::scene
