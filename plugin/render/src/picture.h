/// What a renderer keeps on the device, and the passes that make a picture of it.
#pragma once

#include <epoxy/gl.h>

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "bsoil/render/renderer.h"
#include "gl_objects.h"

namespace bsoil::render {

struct GpuMesh {
    GlVertexArray layout;
    GlBuffer positions, normals, colors, indices;
    GLsizei index_count = 0;
    glm::dvec3 low{0}, high{0};  ///< bounds in the mesh's frame
    bool used = false;
};

/// One target of a size: depth, and colour where wanted.
struct Target {
    GlFramebuffer framebuffer;
    GlTexture2D color, depth;
    int width = 0, height = 0;
};

/// Times of the device at the borders between passes; read once the device is past them.
class PassTimer {
  public:
    enum Mark { kBegin, kShadow, kOcclusion, kSurface, kLines, kMarkCount };
    void create();
    void mark(Mark at);
    /// Takes the times of the pictures that are finished.
    void poll();
    const PassTimes& times() const { return times_; }

  private:
    static constexpr int kInFlight = 4;  ///< pictures whose times may be outstanding
    std::array<std::array<GlQuery, kMarkCount>, kInFlight> queries_;
    std::array<bool, kInFlight> is_out_{};
    int next_ = 0, oldest_ = 0;
    bool is_open_ = false;  ///< this picture is being timed
    PassTimes times_;
};

/// All GL objects of a renderer and what is drawn with them. Made, used and destroyed with the
/// context current.
class Picture {
  public:
    explicit Picture(const RendererDef& def) : def_(def) {}
    /// Compiles the shaders and makes what has no size. The error has the compiler's text.
    Status create();

    GpuMesh& mesh(size_t index) { return meshes_[index]; }
    std::vector<GpuMesh>& meshes() { return meshes_; }
    void fill(GpuMesh& mesh, const Mesh& source, const char* label);

    /// Draws the view into the lower left corner of a framebuffer.
    Status draw(const View& view, GLuint framebuffer);
    Result<Image> take(const View& view);
    Result<Buffers> take_buffers(const View& view);

    PassTimer& timer() { return timer_; }

  private:
    struct Placed;
    struct Frame;
    Frame prepare(const View& view);
    void create_targets(int width, int height);
    void draw_shadows(const Frame& frame);
    void draw_occlusion(const Frame& frame);
    void draw_surface(const View& view, const Frame& frame);
    void draw_sky(const Frame& frame);
    void draw_lines(const View& view, const std::vector<Line>& lines, const Frame& frame);
    void draw_screen() const;
    void restore_state(const View& view, GLuint framebuffer) const;

    RendererDef def_;
    GlProgram surface_, depth_, sky_, occlusion_, smooth_, buffers_, line_;
    GlVertexArray no_vertices_, line_layout_;
    GlBuffer line_ends_;
    std::vector<float> line_floats_;
    GlTexture3D grains_;
    Target shadow_, view_depth_, rough_occlusion_, smooth_occlusion_;
    GlFramebuffer samples_, picture_;
    GlRenderbuffer samples_color_, samples_depth_, picture_color_;
    int width_ = 0, height_ = 0;
    std::vector<GpuMesh> meshes_;
    GpuMesh floor_;
    PassTimer timer_;
};

}  // namespace bsoil::render
