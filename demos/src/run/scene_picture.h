/// A run as a view of the renderer: soil, terrain and bodies as they are now.
#pragma once

#include <memory>

#include "bsoil/render/renderer.h"
#include "scene_run.h"

namespace bsoil::scene {

/// Labels of Buffers: what is no body. Body b of the run has kFirstBodyLabel + b.
inline constexpr uint32_t kSoilLabel = 1, kTerrainLabel = 2, kFirstBodyLabel = 3;

/// Both must outlive it. Made at the run's start: a camera that follows a body counts from there.
class ScenePicture {
  public:
    ScenePicture(const SceneRun& run, render::Renderer& renderer);
    ~ScenePicture();
    ScenePicture(const ScenePicture&) = delete;
    ScenePicture& operator=(const ScenePicture&) = delete;

    /// What there is now, by the scene's camera. Meshes and uploads what has changed.
    render::View view();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace bsoil::scene
