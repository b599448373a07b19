#include "callers_state.h"

namespace bsoil::render {
namespace {

/// GL keeps no more kinds of errors. Without a context some drivers report one for ever.
constexpr int kErrorKindsMost = 8;

GLint number_of(GLenum name) {
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
}

void bind_framebuffers(GLint draw, GLint read) {
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read));
}

}  // namespace

void set_first_state() {
    for (const GLenum capability : {GL_BLEND, GL_CULL_FACE, GL_DEPTH_TEST}) glDisable(capability);
    glBlendFunc(GL_ONE, GL_ZERO);
    glCullFace(GL_BACK);
    glFrontFace(GL_CCW);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glBindVertexArray(0);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    glBindRenderbuffer(GL_RENDERBUFFER, 0);
    glUseProgram(0);
    for (GLenum unit = 0; unit < kUnitCount; ++unit) {
        glActiveTexture(GL_TEXTURE0 + unit);
        glBindTexture(GL_TEXTURE_2D, 0);
        glBindTexture(GL_TEXTURE_3D, 0);
    }
    glActiveTexture(GL_TEXTURE0);
}

CallersState::CallersState(bool takes_target)
    : takes_target_(takes_target),
      has_clip_control_(epoxy_gl_version() >= 45 || epoxy_has_gl_extension("GL_ARB_clip_control")) {
    for (int i = 0; i < kErrorKindsMost && glGetError() != GL_NO_ERROR; ++i) {
    }
    for (size_t i = 0; i < are_enabled_.size(); ++i) {
        are_enabled_[i] = glIsEnabled(kCapabilities[i]);
    }
    for (size_t i = 0; i < pixel_sizes_.size(); ++i) pixel_sizes_[i] = number_of(kPixelSizes[i]);
    for (size_t unit = 0; unit < samplers_.size(); ++unit) {
        glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
        samplers_[unit] = number_of(GL_SAMPLER_BINDING);
    }
    draw_framebuffer_ = number_of(GL_DRAW_FRAMEBUFFER_BINDING);
    read_framebuffer_ = number_of(GL_READ_FRAMEBUFFER_BINDING);
    glGetIntegerv(GL_VIEWPORT, viewport_);
    glGetIntegerv(GL_SCISSOR_BOX, scissor_);
    pack_buffer_ = number_of(GL_PIXEL_PACK_BUFFER_BINDING);
    unpack_buffer_ = number_of(GL_PIXEL_UNPACK_BUFFER_BINDING);
    pack_alignment_ = number_of(GL_PACK_ALIGNMENT);
    unpack_alignment_ = number_of(GL_UNPACK_ALIGNMENT);
    blend_equation_[0] = number_of(GL_BLEND_EQUATION_RGB);
    blend_equation_[1] = number_of(GL_BLEND_EQUATION_ALPHA);
    glGetIntegerv(GL_POLYGON_MODE, polygon_mode_);
    glGetFloatv(GL_POLYGON_OFFSET_FACTOR, &polygon_offset_[0]);
    glGetFloatv(GL_POLYGON_OFFSET_UNITS, &polygon_offset_[1]);
    glGetDoublev(GL_DEPTH_CLEAR_VALUE, &clear_depth_);
    glGetDoublev(GL_DEPTH_RANGE, depth_range_);
    glGetBooleanv(GL_COLOR_WRITEMASK, color_mask_);
    if (has_clip_control_) {
        clip_origin_ = number_of(GL_CLIP_ORIGIN);
        clip_depth_ = number_of(GL_CLIP_DEPTH_MODE);
    }
    set_all();
}

void CallersState::set_all() const {
    for (const GLenum capability : kCapabilities) glDisable(capability);
    for (const GLenum size : kPixelSizes) glPixelStorei(size, 0);
    for (GLuint unit = 0; unit < samplers_.size(); ++unit) glBindSampler(unit, 0);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glBlendEquation(GL_FUNC_ADD);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glClearDepth(1);
    glDepthRange(0, 1);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    if (has_clip_control_) glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    set_first_state();
}

CallersState::~CallersState() {
    set_first_state();
    for (size_t i = 0; i < are_enabled_.size(); ++i) {
        (are_enabled_[i] ? glEnable : glDisable)(kCapabilities[i]);
    }
    for (size_t i = 0; i < pixel_sizes_.size(); ++i) glPixelStorei(kPixelSizes[i], pixel_sizes_[i]);
    for (GLuint unit = 0; unit < samplers_.size(); ++unit) {
        glBindSampler(unit, static_cast<GLuint>(samplers_[unit]));
    }
    if (!takes_target_) {
        bind_framebuffers(draw_framebuffer_, read_framebuffer_);
        glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    }
    glScissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(pack_buffer_));
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, static_cast<GLuint>(unpack_buffer_));
    glPixelStorei(GL_PACK_ALIGNMENT, pack_alignment_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, unpack_alignment_);
    glBlendEquationSeparate(static_cast<GLenum>(blend_equation_[0]),
                            static_cast<GLenum>(blend_equation_[1]));
    glPolygonMode(GL_FRONT_AND_BACK, static_cast<GLenum>(polygon_mode_[0]));
    glPolygonOffset(polygon_offset_[0], polygon_offset_[1]);
    glClearDepth(clear_depth_);
    glDepthRange(depth_range_[0], depth_range_[1]);
    glColorMask(color_mask_[0], color_mask_[1], color_mask_[2], color_mask_[3]);
    if (has_clip_control_) {
        glClipControl(static_cast<GLenum>(clip_origin_), static_cast<GLenum>(clip_depth_));
    }
}

}  // namespace bsoil::render
