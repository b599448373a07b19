/// A run as a view of the renderer: soil, terrain and bodies as they are now.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bsoil/render/renderer.h"
#include "scene_run.h"
#include "soil_volume.h"

namespace bsoil::scene {

/// Labels of Buffers: what is no body. Body b of the run has kFirstBodyLabel + b.
inline constexpr uint32_t kSoilLabel = 1, kTerrainLabel = 2, kFirstBodyLabel = 3;

/// Both must outlive it. A camera that follows a body counts from where that was at the run's
/// start.
class ScenePicture {
  public:
    ScenePicture(const SceneRun& run, render::Renderer& renderer);
    ~ScenePicture();
    ScenePicture(const ScenePicture&) = delete;
    ScenePicture& operator=(const ScenePicture&) = delete;

    /// What the picture lacks, one line each: textures that are missing or cannot be read.
    const std::vector<std::string>& notes() const;

    /// From now on the soil is a volume to look into, and has no surface; none: as at first. The
    /// error says what the device has no room for.
    Status show_volume(const std::optional<SoilVolumeDef>& def);

    /// What there is now, by the scene's camera. `adjust` may set camera and size of the picture:
    /// the surfaces' level of detail follows them. Meshes and uploads what has changed.
    render::View view(const std::function<void(render::View&)>& adjust = {});

    /// Of the surfaces of the last view().
    struct SurfaceCounts {
        int tile_count = 0, tile_coarse_count = 0;
        int tile_built_count = 0;  ///< meshed for this view
        int tile_gl_count = 0;     ///< of those, the ones that OpenGL has meshed
        size_t triangle_count = 0;
    };
    SurfaceCounts surface_counts() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace bsoil::scene
