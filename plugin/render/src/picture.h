/// What a renderer keeps on the device, and the passes that make a picture of it.
#pragma once

#include <epoxy/gl.h>

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "bsoil/render/renderer.h"
#include "dust_layer.h"
#include "frame.h"
#include "gpu_texture.h"
#include "gpu_volume.h"
#include "grain_layer.h"
#include "targets.h"

namespace bsoil::render {

struct Uniforms;

/// Times of the device at the borders between passes; read once the device is past them.
class PassTimer {
  public:
    enum Mark { kBegin, kShadow, kSurface, kOcclusion, kLight, kFinish, kMarkCount };
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
    std::vector<GpuTexture>& textures() { return textures_; }
    std::vector<GpuVolume>& volumes() { return volumes_; }

    /// Draws the view into the lower left corner of a framebuffer.
    Status draw(const View& view, GLuint framebuffer);
    Result<Image> take(const View& view);
    Result<Buffers> take_buffers(const View& view);

    PassTimer& timer() { return timer_; }

  private:
    void create_targets(int width, int height);
    void create_shadow_maps(size_t count);
    void draw_shadows(const Frame& frame);
    void draw_surface(const Frame& frame);
    void draw_mixed(const Frame& frame);
    void draw_textured(const Frame& frame);
    void draw_occlusion(const Frame& frame);
    void light(const Frame& frame);
    void set_shadows(const Uniforms& uniforms, const Frame& frame) const;
    void draw_sky(const Frame& frame) const;
    void draw_volumes(const View& view, const Frame& frame);
    void draw_dust(const View& view, const Frame& frame);
    void march(const Volume& placed, const GpuVolume& volume, const Frame& frame);
    void draw_lines(const View& view, const std::vector<Line>& lines, const Frame& frame);
    void finish() const;
    void draw_screen() const;
    void restore_state(const View& view, GLuint framebuffer) const;
    Frame make_frame(const View& view) {
        return Frame(view, {def_.shadow_map_size, cascades_most_}, meshes_, volumes_, floor_);
    }

    RendererDef def_;
    GlProgram depth_, surface_, occlusion_, smooth_, light_, sky_, line_, finish_, edges_, buffers_;
    GlProgram light_cascaded_, mixed_, textured_, march_, veil_, grain_, grain_depth_,
        grain_buffers_, dust_;
    GlVertexArray no_vertices_, line_layout_;
    GlBuffer line_ends_;
    std::vector<float> line_floats_;
    GlTexture3D grains_;
    GlTexture3D blend_map_;  ///< once something mixed is drawn
    GlTexture2D materials_;
    Target shadow_, seen_, rough_occlusion_, smooth_occlusion_, veiled_, dusty_, lit_, picture_;
    size_t cascades_most_ = 1, shadow_map_count_ = 0;
    int samples_aside_ = 1;  ///< along x and y: a pixel is lit as often as the square of it
    int width_ = 0, height_ = 0;
    std::vector<GpuMesh> meshes_;
    std::vector<GpuTexture> textures_;
    std::vector<GpuVolume> volumes_;
    GpuMesh floor_;
    GrainLayer grain_layer_;
    DustLayer dust_layer_;
    PassTimer timer_;
};

}  // namespace bsoil::render
