/// State of a caller's OpenGL context that pictures depend on.
#pragma once

#include <epoxy/gl.h>

#include <array>

#include "uniforms.h"

namespace bsoil::render {

/// Depth, blending, culling, textures, vertex arrays and program as GL has them at first.
void set_first_state();

/// While it lives, that state is as in a new context, and errors of before are forgotten. At its
/// end the caller's is there again, but for what set_first_state() sets. The context must be
/// current.
class CallersState {
  public:
    /// `takes_target`: the framebuffers and the viewport stay what they are at the end.
    explicit CallersState(bool takes_target);
    ~CallersState();
    CallersState(const CallersState&) = delete;
    CallersState& operator=(const CallersState&) = delete;

  private:
    static constexpr GLenum kCapabilities[] = {
        GL_CLIP_DISTANCE0,      GL_CLIP_DISTANCE0 + 1, GL_CLIP_DISTANCE0 + 2,
        GL_CLIP_DISTANCE0 + 3,  GL_CLIP_DISTANCE0 + 4, GL_CLIP_DISTANCE0 + 5,
        GL_CLIP_DISTANCE0 + 6,  GL_CLIP_DISTANCE0 + 7, GL_COLOR_LOGIC_OP,
        GL_DEPTH_CLAMP,         GL_FRAMEBUFFER_SRGB,   GL_POLYGON_OFFSET_FILL,
        GL_POLYGON_SMOOTH,      GL_PRIMITIVE_RESTART,  GL_RASTERIZER_DISCARD,
        GL_SAMPLE_ALPHA_TO_ONE, GL_SAMPLE_COVERAGE,    GL_SAMPLE_ALPHA_TO_COVERAGE,
        GL_SAMPLE_MASK,         GL_SCISSOR_TEST,       GL_STENCIL_TEST};
    static constexpr GLenum kPixelSizes[] = {
        GL_PACK_ROW_LENGTH,     GL_PACK_SKIP_ROWS,    GL_PACK_SKIP_PIXELS,   GL_PACK_SWAP_BYTES,
        GL_UNPACK_ROW_LENGTH,   GL_UNPACK_SKIP_ROWS,  GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SWAP_BYTES,
        GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_IMAGES};
    void set_all() const;

    bool takes_target_;
    bool has_clip_control_;
    std::array<GLboolean, std::size(kCapabilities)> are_enabled_{};
    std::array<GLint, std::size(kPixelSizes)> pixel_sizes_{};
    std::array<GLint, kUnitCount> samplers_{};
    GLint draw_framebuffer_ = 0, read_framebuffer_ = 0, viewport_[4]{}, scissor_[4]{};
    GLint pack_buffer_ = 0, unpack_buffer_ = 0, pack_alignment_ = 4, unpack_alignment_ = 4;
    GLint blend_equation_[2]{}, polygon_mode_[2]{}, clip_origin_ = 0, clip_depth_ = 0;
    GLfloat polygon_offset_[2]{};
    GLdouble clear_depth_ = 1, depth_range_[2]{};
    GLboolean color_mask_[4]{};
};

}  // namespace bsoil::render
