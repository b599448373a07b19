/// The meshes of a SurfaceMesher by the patch, and which of them have changed.
#pragma once

#include <functional>
#include <optional>

#include "bsoil/surface_mesh.h"
#include "world_picture.h"

namespace bsoil::viewer {

class SurfacePatches {
  public:
    /// No backend: that of the source, which must outlive it.
    SurfacePatches(const TileSource& source, SurfaceKind kind, std::optional<Backend> backend);
    /// Meshes what has changed and adds the patches concerned; `color` is called for each. With it
    /// patches are added as well whose soil has changed below the same surface, and for some steps
    /// more: soil comes to rest without a change. step_count: of the run.
    void collect(std::vector<SurfacePatch>& patches, const SurfaceDetail& detail,
                 const std::function<void(Mesh&)>& color, long long step_count);
    /// The loose soil of the last collect(), and its dust.
    void collect_grains(WorldPicture& picture) const {
        render::append_grains(mesher_, picture.grains);
        render::append_dust(mesher_, picture.dust);
    }
    /// The next collect() adds all patches.
    void touch_all();

  private:
    static constexpr int kSide = 4;  ///< tiles of a patch along each axis
    /// Ours: 30, half a second. Larger: more of the surface gets its colours anew in each picture;
    /// smaller: what stands still may keep the colour of its motion.
    static constexpr long long kSettleSteps = 30;

    /// What of a patch was added last.
    struct Known {
        uint64_t meshes = 0, soil = 0;  ///< sums of revisions
        long long changed_at = 0;       ///< step at which its soil had changed
    };

    const TileSource& source_;
    SurfaceKind kind_;
    SurfaceMesher mesher_;
    int count_x_, count_y_;
    std::vector<Known> known_;
    long long step_count_ = 0;  ///< of the last collect()
};

}  // namespace bsoil::viewer
