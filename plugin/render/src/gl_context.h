/// A GL context without a window, and its being current for a while.
#pragma once

#include <memory>

#include "bsoil/result.h"

namespace bsoil::render {

/// An OpenGL 3.3 core context on a surfaceless EGL display.
class GlContext {
  public:
    static Result<std::unique_ptr<GlContext>> create();
    ~GlContext();
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

  private:
    friend class CurrentContext;
    GlContext() = default;
    void* display_ = nullptr;
    void* context_ = nullptr;
};

/// Makes a context current; the one that was current before is so again at the end.
class CurrentContext {
  public:
    explicit CurrentContext(const GlContext& context);
    ~CurrentContext();
    CurrentContext(const CurrentContext&) = delete;
    CurrentContext& operator=(const CurrentContext&) = delete;
    /// False when EGL refused, as it does when another window system's context is current.
    bool ok() const { return ok_; }

  private:
    void* own_display_;
    void* display_;
    void* draw_surface_;
    void* read_surface_;
    void* context_;
    unsigned api_;
    bool ok_;
};

}  // namespace bsoil::render
