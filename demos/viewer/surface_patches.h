/// The meshes of a SurfaceMesher by the patch, and which of them have changed.
#pragma once

#include <functional>
#include <optional>

#include "bsoil/surface_mesh.h"
#include "world_picture.h"

namespace bsoil::viewer {

class SurfacePatches {
  public:
    /// No backend: that of the source.
    SurfacePatches(const TileSource& source, SurfaceKind kind, std::optional<Backend> backend);
    /// Meshes what has changed and adds the patches concerned; `color` is called for each.
    void collect(std::vector<SurfacePatch>& patches, const SurfaceDetail& detail,
                 const std::function<void(Mesh&)>& color);
    /// The loose soil of the last collect(), and its dust.
    void collect_grains(WorldPicture& picture) const {
        render::append_grains(mesher_, picture.grains);
        render::append_dust(mesher_, picture.dust);
    }
    /// The next collect() adds all patches.
    void touch_all();

  private:
    static constexpr int kSide = 4;  ///< tiles of a patch along each axis
    SurfaceKind kind_;
    SurfaceMesher mesher_;
    int count_x_, count_y_;
    std::vector<uint64_t> revision_sums_;
};

}  // namespace bsoil::viewer
