#include "bsoil/shared_surface.h"

#include <fmt/format.h>

#include <vector>

#include "device/kernel_set.h"
#include "mesh/device_mesher.h"

namespace bsoil {

using mesh::kernels::Buffer;

static_assert(sizeof(SharedVertex) == mesh::kernels::kKeptWords * sizeof(int32_t));
static_assert(offsetof(SharedVertex, normal) == mesh::kernels::kKeptNormal * sizeof(int32_t));
static_assert(offsetof(SharedVertex, color) == mesh::kernels::kKeptLook * sizeof(int32_t));
static_assert(offsetof(SharedVertex, wetness) ==
              (mesh::kernels::kKeptLook + mesh::kernels::kLookWetness) * sizeof(int32_t));

struct SharedSurface::Impl {
    Impl(const TileSource& tile_source, const SharedSurfaceDef& def,
         std::unique_ptr<mesh::DeviceMesher> made)
        : source(tile_source),
          device_mesher(made.get()),
          mesher(source, def.mesh, std::move(made)) {
        const size_t tile_count =
            static_cast<size_t>(mesher.tile_count_x()) * static_cast<size_t>(mesher.tile_count_y());
        levels.assign(tile_count, static_cast<uint8_t>(def.level));
        device_mesher->keep_on_device(tile_count);
    }

    uint32_t name(device::BufferIndex buffer) const {
        return has_buffers ? device_mesher->device().buffer_name(buffer) : 0;
    }

    const TileSource& source;
    mesh::DeviceMesher* device_mesher;  ///< the mesher's; null after it has failed
    SurfaceMesher mesher;
    std::vector<uint8_t> levels;
    bool has_buffers = false;
    void* fence = nullptr;
};

SharedSurface::SharedSurface(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SharedSurface::~SharedSurface() = default;

Result<std::unique_ptr<SharedSurface>> SharedSurface::create(const TileSource& source,
                                                             const SharedSurfaceDef& def) {
    if (def.level < 0 || def.level > SurfaceMesher::kLevelMost) {
        return Error{fmt::format("SharedSurfaceDef::level is {}, allowed is 0..{}", def.level,
                                 SurfaceMesher::kLevelMost)};
    }
    auto device = device::create_shared_gl_device(device::mesh_kernel_set(), def.egl_display,
                                                  def.egl_context);
    if (!device) return Error{device.error()};
    auto made = std::make_unique<mesh::DeviceMesher>(std::move(*device), source, def.mesh);
    return std::unique_ptr<SharedSurface>(
        new SharedSurface(std::make_unique<Impl>(source, def, std::move(made))));
}

Result<SurfaceMeshReport> SharedSurface::update(void* hosts_fence) {
    Impl& d = *impl_;
    if (!d.device_mesher) return Error{d.mesher.backend_reason()};
    if (hosts_fence) d.device_mesher->device().wait_for(hosts_fence);
    const SurfaceMeshReport report = d.mesher.update(d.levels);
    if (d.mesher.backend_name() != "gl") {
        d.device_mesher = nullptr;
        d.has_buffers = false;
        d.fence = nullptr;
        return Error{d.mesher.backend_reason()};
    }
    d.fence = d.device_mesher->device().signal();
    d.has_buffers = true;
    return report;
}

uint32_t SharedSurface::vertex_buffer() const { return impl_->name(Buffer::kept_vertices); }
uint32_t SharedSurface::index_buffer() const { return impl_->name(Buffer::kept_indices); }
uint32_t SharedSurface::draw_buffer() const { return impl_->name(Buffer::kept_draws); }
void* SharedSurface::fence() const { return impl_->fence; }

int SharedSurface::tile_count_x() const { return impl_->mesher.tile_count_x(); }
int SharedSurface::tile_count_y() const { return impl_->mesher.tile_count_y(); }

SharedBlock SharedSurface::block(int tx, int ty) const {
    if (!impl_->has_buffers) return {};
    const auto tile = static_cast<size_t>(ty * tile_count_x() + tx);
    const mesh::KeptMeshes::Place& place = impl_->device_mesher->kept().places()[tile];
    return {place.vertex_at, place.vertex_count, place.index_at, place.index_count};
}

std::span<const int> SharedSurface::changed_tiles() const { return impl_->mesher.changed_tiles(); }

std::array<double, 16> SharedSurface::model() const {
    const GridFrame& frame = impl_->source.frame();
    const auto& [origin, rotation] = frame.grid_to_world;
    const Vec3 columns[] = {rotate(rotation, {frame.voxel_m, 0, 0}),
                            rotate(rotation, {0, frame.voxel_m, 0}),
                            rotate(rotation, {0, 0, frame.voxel_m}), origin};
    std::array<double, 16> model{};
    for (size_t column = 0; column < 4; ++column) {
        const Vec3 v = columns[column];
        model[4 * column] = v.x;
        model[4 * column + 1] = v.y;
        model[4 * column + 2] = v.z;
    }
    model[15] = 1;
    return model;
}

}  // namespace bsoil
