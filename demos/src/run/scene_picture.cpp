#include "scene_picture.h"

#include <optional>
#include <vector>

#include "scene_models.h"

namespace bsoil::scene {
struct ScenePicture::Impl {
    /// One layer of the soil's grid in the renderer.
    struct SurfaceLayer {
        SurfaceMesher mesher;
        render::SurfaceItems items;
        SurfaceLayer(const SoilTiles& tiles, const SurfaceMeshDef& def, render::Renderer& renderer,
                     float grain_m)
            : mesher(tiles, def), items(renderer, mesher, grain_m) {}
        void append_to(render::View& shown, ScenePicture::SurfaceCounts& sum) {
            const SurfaceMeshReport report = mesher.update(render::surface_detail(shown));
            items.update();
            items.append_to(shown.items);
            sum.tile_coarse_count += report.tile_coarse_count;
            sum.tile_built_count += report.tile_built_count;
            sum.tile_gl_count += report.tile_gl_count;
            for (int ty = 0; ty < mesher.tile_count_y(); ++ty) {
                for (int tx = 0; tx < mesher.tile_count_x(); ++tx) {
                    ++sum.tile_count;
                    sum.triangle_count += mesher.tile_mesh(tx, ty).triangle_count();
                }
            }
        }
    };

    const SceneRun& run;
    render::Renderer& renderer;
    std::optional<SoilVolume> volume;
    render::VolumeId volume_id;
    std::optional<SoilTiles> tiles;
    std::optional<SurfaceLayer> soil, terrain;
    std::vector<render::MeshId> bodies;  // in the order of the run's bodies
    render::View view;
    SurfaceCounts counts;
    std::vector<std::string> notes;

    Impl(const SceneRun& shown, render::Renderer& drawn_by) : run(shown), renderer(drawn_by) {}

    /// How far the body that the camera follows has gone since the run's start.
    Vec3 followed_way_m() const {
        const std::string& follow = run.scene().camera.follow;
        const std::vector<SceneBody>& all = run.bullet().bodies();
        for (size_t b = 0; b < all.size() && !follow.empty(); ++b) {
            if (all[b].name != follow) continue;
            return all[b].pose().position - run.start_poses()[b].position;
        }
        return {};
    }
};

ScenePicture::ScenePicture(const SceneRun& run, render::Renderer& renderer)
    : impl_(std::make_unique<Impl>(run, renderer)) {
    Impl& m = *impl_;
    const Scene& scene = run.scene();
    if (run.has_soil()) {
        m.tiles.emplace(run.soil());
        SurfaceMeshDef soil_def;
        soil_def.backend = run.mesh_backend();
        m.soil.emplace(*m.tiles, soil_def, renderer, kSoilGrainM);
        if (!scene.terrains.empty()) {
            SurfaceMeshDef terrain_def = soil_def;
            terrain_def.layer = SurfaceMeshDef::Layer::terrain;
            m.terrain.emplace(*m.tiles, terrain_def, renderer, kTerrainGrainM);
        }
    }
    m.bodies = add_body_meshes(scene, renderer, m.notes);
    m.view.camera = scene_camera(scene);
    if (scene.world.ground_plane) m.view.floor_height_m = scene.world.ground_height_m;
    m.view.to_sun = sun_beside(m.view.camera);
}

ScenePicture::~ScenePicture() { impl_->renderer.remove_volume(impl_->volume_id); }

Status ScenePicture::show_volume(const std::optional<SoilVolumeDef>& def) {
    Impl& m = *impl_;
    m.volume.reset();
    m.renderer.remove_volume(m.volume_id);
    m.volume_id = {};
    if (!def || !m.run.has_soil()) return Done{};
    m.volume.emplace(m.run.soil(), *def);
    m.volume->update();
    auto added = m.renderer.add_volume(m.volume->data());
    if (!added) return Error{added.error()};
    m.volume_id = *added;
    return Done{};
}

const std::vector<std::string>& ScenePicture::notes() const { return impl_->notes; }

ScenePicture::SurfaceCounts ScenePicture::surface_counts() const { return impl_->counts; }

render::View ScenePicture::view(const std::function<void(render::View&)>& adjust) {
    Impl& m = *impl_;
    render::View view = m.view;
    const Vec3 way = m.followed_way_m();
    view.camera.eye += way;
    view.camera.target += way;
    if (adjust) adjust(view);
    m.counts = {};
    const auto label_from = [&view](size_t first, uint32_t label) {
        for (size_t i = first; i < view.items.size(); ++i) view.items[i].label = label;
    };
    if (m.volume_id.value != 0) {
        // It was taken with this size: there is room.
        if (m.volume->update()) (void)m.renderer.set_volume(m.volume_id, m.volume->data());
        view.volumes.push_back(m.volume->placed());
        view.volumes.back().volume = m.volume_id;
        if (m.volume->is_soil()) m.soil->mesher.update(render::surface_detail(view));
    } else if (m.soil) {
        m.soil->append_to(view, m.counts);
    }
    const bool has_grains = m.volume_id.value == 0 || m.volume->is_soil();
    if (m.soil && has_grains) {
        render::append_grains(m.soil->mesher, view.grains);
        render::append_dust(m.soil->mesher, view.dust);
    }
    label_from(0, kSoilLabel);
    view.grain_label = kSoilLabel;
    view.time_s = m.run.time_s();
    const size_t soil_count = view.items.size();
    if (m.terrain) m.terrain->append_to(view, m.counts);
    label_from(soil_count, kTerrainLabel);
    for (size_t b = 0; b < m.bodies.size(); ++b) {
        render::Item item;
        item.mesh = m.bodies[b];
        item.pose = m.run.bullet().bodies()[b].pose();
        item.gloss = kBodyGloss;
        item.label = kFirstBodyLabel + static_cast<uint32_t>(b);
        view.items.push_back(item);
    }
    return view;
}

}  // namespace bsoil::scene
