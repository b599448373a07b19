#include "surface_patches.h"

#include <algorithm>

namespace bsoil::viewer {
namespace {

SurfaceMeshDef mesh_def(SurfaceKind kind, std::optional<Backend> backend) {
    SurfaceMeshDef def;
    def.backend = backend;
    if (kind == SurfaceKind::terrain) def.layer = SurfaceMeshDef::Layer::terrain;
    return def;
}

}  // namespace

SurfacePatches::SurfacePatches(const TileSource& source, SurfaceKind kind,
                               std::optional<Backend> backend)
    : kind_(kind),
      mesher_(source, mesh_def(kind, backend)),
      count_x_((mesher_.tile_count_x() + kSide - 1) / kSide),
      count_y_((mesher_.tile_count_y() + kSide - 1) / kSide),
      revision_sums_(static_cast<size_t>(count_x_) * static_cast<size_t>(count_y_)) {}

void SurfacePatches::touch_all() { std::fill(revision_sums_.begin(), revision_sums_.end(), 0); }

void SurfacePatches::collect(std::vector<SurfacePatch>& patches, const SurfaceDetail& detail,
                             const std::function<void(Mesh&)>& color) {
    mesher_.update(detail);
    for (int p = 0; p < count_x_ * count_y_; ++p) {
        const int tx0 = p % count_x_ * kSide, ty0 = p / count_x_ * kSide;
        const int tx1 = std::min(tx0 + kSide, mesher_.tile_count_x());
        const int ty1 = std::min(ty0 + kSide, mesher_.tile_count_y());
        uint64_t sum = 0;  // revisions only grow: so does their sum with any of them
        for (int ty = ty0; ty < ty1; ++ty) {
            for (int tx = tx0; tx < tx1; ++tx) sum += mesher_.tile_mesh_revision(tx, ty);
        }
        if (sum == revision_sums_[static_cast<size_t>(p)]) continue;
        revision_sums_[static_cast<size_t>(p)] = sum;
        SurfacePatch patch;
        patch.kind = kind_;
        patch.index = p;
        for (int ty = ty0; ty < ty1; ++ty) {
            for (int tx = tx0; tx < tx1; ++tx) patch.mesh.append(mesher_.tile_mesh(tx, ty));
        }
        if (color) color(patch.mesh);
        patches.push_back(std::move(patch));
    }
}

}  // namespace bsoil::viewer
