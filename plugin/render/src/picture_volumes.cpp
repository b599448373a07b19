/// Volumes over what else a picture shows.
#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "picture.h"
#include "uniforms.h"

namespace bsoil::render {
namespace {

/// World axes about the eye -> voxels from the volume's corner.
glm::dmat4 to_voxels(const Volume& placed, const Frame& f) {
    const Quat& q = placed.pose.rotation;
    const Vec3& p = placed.pose.position;
    const glm::dmat4 model =
        glm::translate(glm::dmat4(1), glm::dvec3(p.x, p.y, p.z) - f.eye) *
        glm::scale(glm::mat4_cast(glm::dquat(q.w, q.x, q.y, q.z)), glm::dvec3(placed.voxel_m));
    return glm::inverse(model);
}

}  // namespace

/// What a ray meets last is drawn first.
void Picture::draw_volumes(const View& view, const Frame& f) {
    struct Drawn {
        const Volume* placed;
        const GpuVolume* volume;
        double away;
    };
    std::vector<Drawn> drawn;
    for (const Volume& placed : view.volumes) {
        const uint32_t id = placed.volume.value;
        if (id == 0 || id > volumes_.size() || !volumes_[id - 1].used) continue;
        const int* size = volumes_[id - 1].size;
        const glm::dvec3 middle = 0.5 * glm::dvec3(size[0], size[1], size[2]);
        const glm::dmat4 model = glm::inverse(to_voxels(placed, f));
        const double away = glm::length(glm::dvec3(model * glm::dvec4(middle, 1)));
        drawn.push_back({&placed, &volumes_[id - 1], away});
    }
    if (drawn.empty()) return;
    std::stable_sort(drawn.begin(), drawn.end(),
                     [](const Drawn& a, const Drawn& b) { return a.away > b.away; });
    if (veiled_.width != width_ || veiled_.height != height_) {
        veiled_ = create_color_target("volumes", width_, height_, GL_RGBA8);
    }
    glDisable(GL_DEPTH_TEST);
    for (const auto& [placed, volume, away] : drawn) {
        veiled_.bind();
        march(*placed, *volume, f);
        lit_.bind();
        const Uniforms uniforms(veil_);
        uniforms.set_unit("veil", kColorUnit);
        bind_texture(kColorUnit, GL_TEXTURE_2D, veiled_.color);
        glEnable(GL_BLEND);
        // The picture's alpha is a number of its faces.
        glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
        draw_screen();
        glBlendFunc(GL_ONE, GL_ZERO);
        glDisable(GL_BLEND);
    }
    glEnable(GL_DEPTH_TEST);
}

void Picture::march(const Volume& placed, const GpuVolume& volume, const Frame& f) {
    const Uniforms uniforms(march_);
    set_rays(uniforms, f);
    uniforms.set_unit("depth", kDepthUnit);
    uniforms.set_unit("voxels", kVolumeUnit);
    uniforms.set_unit("blocks", kBlockUnit);
    bind_texture(kDepthUnit, GL_TEXTURE_2D, seen_.depth);
    bind_texture(kVolumeUnit, GL_TEXTURE_3D, volume.voxels);
    bind_texture(kBlockUnit, GL_TEXTURE_3D, volume.blocks);
    uniforms.set("depth_texels", samples_aside_);
    uniforms.set("depth_to_distance", f.depth_to_distance());
    uniforms.set("pixel_m", 2 * f.to_view().y / static_cast<float>(height_));
    const glm::dmat4 voxels = to_voxels(placed, f);
    uniforms.set("to_voxels", glm::mat4(voxels));
    uniforms.set("to_sun", glm::vec3(glm::normalize(glm::dmat3(voxels) * f.to_sun)));
    uniforms.set("shading", placed.is_shaded ? 1.0f : 0.0f);
    uniforms.set("threshold", static_cast<float>(placed.threshold));
    uniforms.set("voxel_m", static_cast<float>(placed.voxel_m));
    uniforms.set("sight_m", static_cast<float>(placed.sight_m));
    draw_screen();
}

}  // namespace bsoil::render
