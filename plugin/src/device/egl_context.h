/// OpenGL 4.5 contexts without a window: EGL displays, a context of our own, and scopes in which it
/// is current.
#pragma once

#include <epoxy/egl.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "bsoil/result.h"

namespace bsoil::device {

/// An EGL display to try. Never terminated: EGL displays are shared in a process, and the host may
/// use the same one.
struct EglDisplay {
    EGLDisplay handle = EGL_NO_DISPLAY;
    std::string name;          ///< how it was found, for messages
    bool is_software = false;  ///< EGL says so (the renderer's name may say so later)
};

/// All EGL devices, hardware first; where EGL lists none, Mesa's surfaceless platform. The error
/// says what is missing.
Result<std::vector<EglDisplay>> find_egl_displays();

/// Whether BULLETSOIL_GL in the environment, words with commas between them, has this one:
///   hardware  software dispatches as a GPU does
///   checked   after each kernel the device is waited for and asked for errors, and what the driver
///             has to say goes to stderr: slow, to find what breaks a device
bool is_gl_asked(std::string_view word);

/// What the kernels need of an OpenGL context.
struct GlCapabilities {
    std::string renderer;  ///< GL_RENDERER
    std::string version;   ///< GL_VERSION
    bool is_software = false;
    int storage_block_count = 0;      ///< GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS
    int64_t storage_block_bytes = 0;  ///< GL_MAX_SHADER_STORAGE_BLOCK_SIZE

    /// Which limit is too low for kernels with that many buffers; empty when none is.
    std::string shortfall(int buffer_count) const;
};

/// An OpenGL 4.5 core context without a surface.
class EglContext {
  public:
    /// Leaves the caller's current context as it was.
    static Result<EglContext> create(const EglDisplay& display);
    /// The same, with buffers and fences that a host's context has too. Null: the display and the
    /// context that are current in this thread. The error says why they cannot be shared.
    static Result<EglContext> create_beside(EGLDisplay hosts_display, EGLContext hosts_context);
    EglContext(EglContext&& other) noexcept;
    EglContext& operator=(EglContext&& other) noexcept;
    ~EglContext();

    const GlCapabilities& capabilities() const { return capabilities_; }

  private:
    friend class CurrentContext;
    EglContext(EGLDisplay display, EGLContext context) : display_(display), context_(context) {}
    static Result<EglContext> create_in_group(const EglDisplay& display, EGLContext other);
    Status read_capabilities(bool display_is_software);

    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
    GlCapabilities capabilities_;
};

/// Binds an EGL client API for its lifetime, then the caller's again.
class BoundApi {
  public:
    explicit BoundApi(EGLenum api) : caller_api_(eglQueryAPI()) { eglBindAPI(api); }
    ~BoundApi() { eglBindAPI(caller_api_); }
    BoundApi(const BoundApi&) = delete;
    BoundApi& operator=(const BoundApi&) = delete;

  private:
    EGLenum caller_api_;
};

/// Makes a context current for its lifetime, then the caller's again, with its display and surfaces
/// (or none).
class CurrentContext {
  public:
    explicit CurrentContext(const EglContext& context);
    ~CurrentContext();
    CurrentContext(const CurrentContext&) = delete;
    CurrentContext& operator=(const CurrentContext&) = delete;

    /// Empty when the context is current, else why it is not; then no GL call may be made.
    const std::string& error() const { return error_; }

  private:
    // What the caller had. Read before our API is bound: EGL's "current context" is that of the
    // bound API.
    EGLDisplay caller_display_ = eglGetCurrentDisplay();
    EGLContext caller_context_ = eglGetCurrentContext();
    EGLSurface caller_draw_ = eglGetCurrentSurface(EGL_DRAW);
    EGLSurface caller_read_ = eglGetCurrentSurface(EGL_READ);
    BoundApi bound_api_{EGL_OPENGL_API};
    EGLDisplay display_;
    std::string error_;
};

}  // namespace bsoil::device
