/// The soil's surface in a host's own renderer, as OpenGL buffers: its mesh is made on the GPU and
/// stays there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "bsoil/limits.h"
#include "bsoil/result.h"
#include "bsoil/surface_mesh.h"

#pragma GCC visibility push(default)
namespace bsoil {

/// A vertex in SharedSurface::vertex_buffer(): what a host tells glVertexAttribPointer.
struct SharedVertex {
    float position[3];  ///< [voxels], grid axes; SharedSurface::model() turns it to the world
    float normal[3];    ///< unit, out of the soil, grid axes
    float color[3];     ///< linear RGB, 0..1
    float wetness;      ///< water in the soil's pores, 0..1
    uint8_t weights[limits::kMaterialCapacity];  ///< as MaterialWeights
};
static_assert(sizeof(SharedVertex) == 48 && offsetof(SharedVertex, weights) == 40);

/// Where the mesh of a tile lies. Counts are 0 where a tile has none.
struct SharedBlock {
    int64_t vertex_at = 0, vertex_count = 0;  ///< SharedVertex in vertex_buffer()
    int64_t index_at = 0, index_count = 0;    ///< uint32 in index_buffer(), three a triangle,
                                              ///< counted from vertex_at
};

/// What is meshed, and for whom.
struct SharedSurfaceDef {
    SurfaceMeshDef mesh;  ///< `backend` is not asked: it is OpenGL; nor is `origin_m`, see model()
    int level = 0;        ///< of all tiles, 0..SurfaceMesher::kLevelMost: cells of 2^level voxels
    /// The host's EGLDisplay and its EGLContext, of desktop OpenGL. Null: those that are current in
    /// the calling thread.
    void* egl_display = nullptr;
    void* egl_context = nullptr;
};

/// A SurfaceMesher whose meshes never leave the GPU. It has an OpenGL 4.5 context of its own that
/// shares buffers with the host's, and makes it current for as long as a call takes. The host binds
/// anew in each frame, because names may change, with attributes as in SharedVertex:
///
///     surface->update();
///     glWaitSync((GLsync)surface->fence(), 0, GL_TIMEOUT_IGNORED);
///     glBindBuffer(GL_ARRAY_BUFFER, surface->vertex_buffer());
///     glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(SharedVertex), nullptr);
///     glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, surface->index_buffer());
///     glBindBuffer(GL_DRAW_INDIRECT_BUFFER, surface->draw_buffer());
///     const int count = surface->draw_count();
///     glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr, count, 0);
///
/// A host with OpenGL below 4.3 draws block by block with glDrawElementsBaseVertex. Only the runs
/// of changed columns go to the GPU, and how long each mesh is comes back. The buffers live until
/// the surface is destroyed; a host that still draws from them finishes first.
class SharedSurface {
  public:
    /// The source must outlive the surface. The error says why the contexts cannot share (none is
    /// current, it is no context of that display, OpenGL ES, OpenGL below 4.5), or what is out of
    /// range. Leaves the current context as it was.
    static Result<std::unique_ptr<SharedSurface>> create(const TileSource& source,
                                                         const SharedSurfaceDef& def = {});
    ~SharedSurface();
    SharedSurface(const SharedSurface&) = delete;
    SharedSurface& operator=(const SharedSurface&) = delete;

    /// Meshes again the tiles that changed since the last call, and their neighbours. Waits for the
    /// GPU once for 256 of them. `hosts_fence`: a GLsync behind the host's last draw from the
    /// buffers, which the GPU waits for before it changes them; null where the host has finished.
    /// The error is the device's: its memory is lost, or too little. Then the surface has no
    /// buffers any more; create another one.
    Result<SurfaceMeshReport> update(void* hosts_fence = nullptr);

    /// OpenGL's names in the share group, of the last update(); 0 before the first one.
    uint32_t vertex_buffer() const;
    uint32_t index_buffer() const;  ///< likewise; uint32, three a triangle
    /// A DrawElementsIndirectCommand (five uint32) for each tile, draw_count() of them.
    uint32_t draw_buffer() const;
    /// The commands in draw_buffer(), one for each tile.
    int draw_count() const { return tile_count_x() * tile_count_y(); }
    /// A GLsync behind the last update(), for glWaitSync in the host's context. The surface deletes
    /// it with the next update().
    void* fence() const;

    int tile_count_x() const;  ///< tiles of 8 columns along grid x
    int tile_count_y() const;  ///< and along grid y
    /// Where the mesh of a tile lies, as of the last update().
    SharedBlock block(int tx, int ty) const;
    /// The tiles that the last update() has meshed, each as ty * tile_count_x() + tx.
    std::span<const int> changed_tiles() const;
    /// Turns positions to world metres: 4 x 4, column by column, as glUniformMatrix4dv takes it.
    std::array<double, 16> model() const;

  private:
    struct Impl;
    explicit SharedSurface(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace bsoil
#pragma GCC visibility pop
