/// Marching cubes on a device: many tiles at once, by the kernels of shaders/mesh.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bsoil/surface_mesh.h"
#include "bsoil/work_threads.h"
#include "mesh/display_field.h"
#include "mesh/kept_meshes.h"
#include "mesh/look_words.h"
#include "mesh/mesh_kernels.h"
#include "mesh/tile_levels.h"
#include "mesh/tile_meshers.h"
#include "mesh/vertex_writer.h"

#pragma GCC visibility push(default)
namespace bsoil::mesh {

/// Gives each tile the mesh that TileMesher gives it, bit for bit. The host makes the display field
/// and turns the vertices to the world; which edges are crossed, where, with which normals, and the
/// triangles are the device's. Cases are those of marching_cases(). Cells beside finer tiles are
/// TileMesher's.
class DeviceMesher {
  public:
    /// On OpenGL; software renderers only when `allow_software`. The error says what is missing.
    static Result<std::unique_ptr<DeviceMesher>> create(const TileSource& source,
                                                        const SurfaceMeshDef& def,
                                                        bool allow_software);
    /// On a device of mesh_kernel_set().
    DeviceMesher(std::unique_ptr<device::Device> device, const TileSource& source,
                 const SurfaceMeshDef& def);

    /// As VertexWriter::take_colors(), for what is built from now on.
    bool take_colors(const std::vector<MaterialDef>& materials) {
        return writer_.take_colors(materials);
    }

    /// Waits for the device twice for each kBatch of tiles. The error is the device's: it has lost
    /// its memory, or has too little. Meshes are undefined then.
    /// `threads`: for the host's part.
    Status build(const GridColumns& grid, const TileLevels& levels, std::span<const TileJob> jobs,
                 const WorkThreads* threads = nullptr);
    static constexpr size_t kBatch = 256;

    /// From now on meshes stay on the device, in its buffers kept_vertices and kept_indices, and
    /// kept_draws has a command for each tile. build() empties the meshes of its jobs. Tiles have
    /// to be at one level.
    void keep_on_device(size_t tile_count) { kept_.emplace(tile_count); }
    /// Where they are, if they stay there.
    const KeptMeshes& kept() const { return *kept_; }

    device::Device& device() const { return *device_; }

  private:
    void write_tile(const TileLevels& levels, const DisplayField& field);
    void write_column(const TileLevels& levels, const DisplayField& field, int i, int j);
    Status run(const GridColumns& grid);
    void dispatch_all();
    Status reserve(device::BufferIndex buffer, size_t word_count);
    Status upload(device::BufferIndex buffer, std::span<const int32_t> words);
    bool has_room() const;
    void take(const DisplayField& field, size_t tile, Mesh& mesh) const;
    void add_border(const GridColumns& grid, const TileLevels& levels, const TileJob& job,
                    size_t tile);
    void take_vertex(const DisplayField& field, const int32_t* tile, const int32_t* vertex,
                     Mesh& mesh) const;
    Status keep_batch(const GridColumns& grid, std::span<const TileJob> batch);
    Status grow(device::BufferIndex buffer, int64_t word_count);
    Status write_draws();
    Status failed() const;
    size_t capacity(device::BufferIndex buffer) const;

    std::unique_ptr<device::Device> device_;
    VertexWriter writer_;
    LookWords look_words_{writer_};
    std::optional<KeptMeshes> kept_;
    TileMesher border_mesher_;
    std::vector<TileMesher::Edge> edges_;  ///< of a tile's vertices
    std::vector<GridVector> places_;
    bool close_floor_;
    bool has_cases_ = false;
    std::vector<DisplayField> fields_;
    std::array<size_t, kernels::Buffer::count> words_in_{};  ///< of each buffer
    std::vector<int32_t> tiles_, columns_, runs_;            ///< as the device gets them
    kernels::Params params_{};                               ///< likewise, of the batch
    size_t work_words_ = 0;
    std::vector<int32_t> looks_, draws_;
    std::vector<int32_t> vertices_, copies_, triangles_;  ///< as it gives them back
};

}  // namespace bsoil::mesh
#pragma GCC visibility pop
