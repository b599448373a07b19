/// PictureCache: the picture as it was last drawn.
#pragma once

#include <epoxy/gl.h>

namespace bsoil::viewer {

/// Panels change without it. A context must be current in every call.
class PictureCache {
  public:
    ~PictureCache() { clear(); }
    void resize(int width, int height) {
        if (width == width_ && height == height_) return;
        clear();
        width_ = width;
        height_ = height;
        glGenRenderbuffers(1, &color_);
        glBindRenderbuffer(GL_RENDERBUFFER, color_);
        glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
        glGenFramebuffers(1, &framebuffer_);
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color_);
    }
    bool has_size(int width, int height) const { return width == width_ && height == height_; }
    GLuint framebuffer() const { return framebuffer_; }
    void show() const {
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
        glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT,
                          GL_NEAREST);
    }

  private:
    void clear() {
        if (framebuffer_ != 0) glDeleteFramebuffers(1, &framebuffer_);
        if (color_ != 0) glDeleteRenderbuffers(1, &color_);
        framebuffer_ = color_ = 0;
    }
    int width_ = 0, height_ = 0;
    GLuint framebuffer_ = 0, color_ = 0;
};

}  // namespace bsoil::viewer
