#include <algorithm>
#include <cmath>

#include "bsoil/render/renderer.h"

namespace bsoil::render {
namespace {

/// A coarse cell is no wider, unless its surface is off by no more than the second. That is little,
/// because shading shows slopes long before outlines show heights.
constexpr double kCellPixels = 3, kErrorPixels = 0.1;

int patch_count(int tile_count, int side) { return (tile_count + side - 1) / side; }

}  // namespace

SurfaceDetail surface_detail(const View& view) {
    const double pixel_rad = 2 * std::tan(view.camera.fov_rad / 2) / std::max(1, view.height);
    return {view.camera.eye, kCellPixels * pixel_rad, kErrorPixels * pixel_rad};
}

SurfaceItems::SurfaceItems(Renderer& renderer, const SurfaceMesher& mesher, float grain_m)
    : renderer_(renderer),
      mesher_(mesher),
      grain_m_(grain_m),
      patch_count_x_(patch_count(mesher.tile_count_x(), kPatchSide)) {
    patches_.resize(static_cast<size_t>(patch_count_x_) *
                    static_cast<size_t>(patch_count(mesher.tile_count_y(), kPatchSide)));
}

SurfaceItems::~SurfaceItems() {
    for (const Patch& patch : patches_) renderer_.remove_mesh(patch.mesh);
}

void SurfaceItems::update() {
    for (size_t p = 0; p < patches_.size(); ++p) {
        const int tx0 = static_cast<int>(p) % patch_count_x_ * kPatchSide;
        const int ty0 = static_cast<int>(p) / patch_count_x_ * kPatchSide;
        const int tx1 = std::min(tx0 + kPatchSide, mesher_.tile_count_x());
        const int ty1 = std::min(ty0 + kPatchSide, mesher_.tile_count_y());
        const auto for_each_tile = [&](auto visit) {
            for (int ty = ty0; ty < ty1; ++ty) {
                for (int tx = tx0; tx < tx1; ++tx) visit(tx, ty);
            }
        };
        uint64_t revision_sum = 0;  // revisions only grow: so does their sum with any of them
        for_each_tile([&](int tx, int ty) { revision_sum += mesher_.tile_mesh_revision(tx, ty); });
        Patch& patch = patches_[p];
        if (patch.revision_sum == revision_sum) continue;
        patch.revision_sum = revision_sum;
        gathered_.clear();
        for_each_tile([&](int tx, int ty) { gathered_.append(mesher_.tile_mesh(tx, ty)); });
        patch.empty = gathered_.indices.empty();
        if (patch.mesh.value != 0) {
            renderer_.set_mesh(patch.mesh, gathered_);
        } else if (!patch.empty) {
            patch.mesh = renderer_.add_mesh(gathered_);
        }
    }
}

void SurfaceItems::append_to(std::vector<Item>& items) const {
    for (const Patch& patch : patches_) {
        if (patch.empty) continue;
        Item item;
        item.mesh = patch.mesh;
        item.pose.position = mesher_.origin_m();
        item.grain_m = grain_m_;
        item.is_closed = true;
        items.push_back(item);
    }
}

}  // namespace bsoil::render
