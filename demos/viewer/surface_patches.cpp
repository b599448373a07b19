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
    : source_(source),
      kind_(kind),
      mesher_(source, mesh_def(kind, backend)),
      count_x_((mesher_.tile_count_x() + kSide - 1) / kSide),
      count_y_((mesher_.tile_count_y() + kSide - 1) / kSide),
      known_(static_cast<size_t>(count_x_) * static_cast<size_t>(count_y_)) {}

void SurfacePatches::touch_all() { std::fill(known_.begin(), known_.end(), Known{}); }

void SurfacePatches::collect(std::vector<SurfacePatch>& patches, const SurfaceDetail& detail,
                             const std::function<void(Mesh&)>& color, long long step_count) {
    mesher_.update(detail);
    const bool has_stepped = step_count != step_count_;
    step_count_ = step_count;
    for (int p = 0; p < count_x_ * count_y_; ++p) {
        const int tx0 = p % count_x_ * kSide, ty0 = p / count_x_ * kSide;
        const int tx1 = std::min(tx0 + kSide, mesher_.tile_count_x());
        const int ty1 = std::min(ty0 + kSide, mesher_.tile_count_y());
        // Revisions only grow: so does their sum with any of them.
        Known& known = known_[static_cast<size_t>(p)];
        Known now{0, 0, known.changed_at};
        for (int ty = ty0; ty < ty1; ++ty) {
            for (int tx = tx0; tx < tx1; ++tx) {
                now.meshes += mesher_.tile_mesh_revision(tx, ty);
                now.soil += source_.tile_revision(tx, ty);
            }
        }
        if (now.soil != known.soil) now.changed_at = step_count;
        const bool settles = has_stepped && step_count - now.changed_at <= kSettleSteps;
        const bool is_due =
            now.meshes != known.meshes || (color && (now.soil != known.soil || settles));
        known = now;
        if (!is_due) continue;
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
