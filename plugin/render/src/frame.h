/// A view as the passes of a picture see it: everything about its eye.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "gpu_mesh.h"
#include "gpu_volume.h"
#include "shadow_cascades.h"

namespace bsoil::render {

/// Texels of the grain volume along each axis: grains in a period.
inline constexpr int kGrainPeriod = 32;

/// A mesh and its place in the picture, about the eye.
struct Placed {
    const GpuMesh* mesh = nullptr;
    const Item* item = nullptr;  ///< null: the floor
    glm::mat4 model{1};
    int material = 0;  ///< of the frame

    /// Whether it shows several materials side by side.
    bool is_mixed() const { return item && item->grain_m > 0 && mesh->palette.size() > 1; }

    bool is_textured() const { return !is_mixed() && !mesh->parts.empty(); }

    void set_culling() const { (item && item->is_closed ? glEnable : glDisable)(GL_CULL_FACE); }
    void draw() const {
        set_culling();
        mesh->draw();
    }

    glm::vec3 corner(int c) const {
        const glm::dvec4 at(c & 1 ? mesh->high.x : mesh->low.x, c & 2 ? mesh->high.y : mesh->low.y,
                            c & 4 ? mesh->high.z : mesh->low.z, 1);
        return glm::vec3(glm::dmat4(model) * at);
    }
    double distance() const {
        const glm::dvec3 middle = 0.5 * (mesh->low + mesh->high);
        return glm::length(glm::dvec3(glm::dmat4(model) * glm::dvec4(middle, 1)));
    }
    /// Whether some of its box may be within the clip space.
    bool is_seen(const std::array<glm::vec4, 6>& planes) const {
        for (const glm::vec4& plane : planes) {
            bool inside = false;
            for (int c = 0; c < 8 && !inside; ++c) {
                inside = glm::dot(plane, glm::vec4(corner(c), 1)) >= 0;
            }
            if (!inside) return false;
        }
        return true;
    }
};

/// How an item takes light, as light.frag reads it.
struct SurfaceMaterial {
    /// Periods of grains a metre (0: smooth), gloss, emission; 1 where it fades into the sky, below
    /// 0: how much of a film of water lies on it.
    glm::vec4 look{0};
    glm::vec4 origin{0};  ///< xyz: of the grains [periods]; w: share of the sun in full shadow
    friend bool operator==(const SurfaceMaterial&, const SurfaceMaterial&) = default;
};
/// Of an item that is wet: the rows of the table behind its dry one. surface.frag knows it too.
inline constexpr int kWetSteps = 8;
/// In a picture; what is beyond looks like the first.
inline constexpr size_t kMaterialCapacity = 256;

/// What there is room for.
struct ShadowMaps {
    int size = 0;  ///< texels a side, of each
    size_t count_most = 1;
};

/// Where everything of a view is, about its eye.
struct Frame {
    glm::dvec3 eye{0}, up{0}, to_sun{0};
    double sight_m = 1;
    std::vector<Placed> items;                 ///< near ones first
    std::vector<ShadowCascade> cascades;       ///< near ones first
    std::vector<std::vector<Placed>> casters;  ///< of the shadows in each
    std::vector<SurfaceMaterial> materials;
    int grain_material = 0;  ///< of grains
    glm::dmat4 projection{1}, look{1};
    glm::mat4 clip{1};
    glm::vec4 cut{0};  ///< above 0: left out of what is cut
    glm::dvec3 floor_center{0};
    double fade_begin_m = 0, fade_end_m = 0;

    /// floor: filled where the view has one, and kept by the caller as long as the frame.
    Frame(const View& view, const ShadowMaps& maps, std::span<const GpuMesh> meshes,
          std::span<const GpuVolume> volumes, GpuMesh& floor);
    /// distance = y / (x + 2 depth - 1), along the line of sight.
    glm::vec2 depth_to_distance() const;
    /// A point 1 m deep in view space: xy * screen + zw, screen in -1..1.
    glm::vec4 to_view() const;

  private:
    int material_of(const Item* item, bool is_wet);
};

}  // namespace bsoil::render
