#include "gl_context.h"

#include <dlfcn.h>
#include <epoxy/egl.h>

#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace bsoil::render {
namespace {

/// epoxy ends the process when it has to call into a library that is not there, so ask first. The
/// handle is never closed: epoxy opens the same library again and keeps it.
bool has_opengl() {
    const auto loads = [](const char* name) { return dlopen(name, RTLD_LAZY | RTLD_LOCAL); };
    return loads("libOpenGL.so.0") || loads("libGL.so.1");
}

/// Displays of the devices that are hardware, as EGL lists them. Mesa's surfaceless display may be
/// software beside another driver's GPU.
std::vector<EGLDisplay> hardware_displays() {
    const char* software = std::getenv("LIBGL_ALWAYS_SOFTWARE");
    if (software && *software && std::strcmp(software, "0") != 0 &&
        std::strcmp(software, "false") != 0) {
        return {};
    }
    const bool has_base = epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_base");
    const bool lists =
        has_base || (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") &&
                     epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_query"));
    if (!lists || !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device")) return {};
    EGLint count = 0;
    if (!eglQueryDevicesEXT(0, nullptr, &count) || count <= 0) return {};
    std::vector<EGLDeviceEXT> devices(static_cast<size_t>(count));
    if (!eglQueryDevicesEXT(count, devices.data(), &count)) return {};
    devices.resize(static_cast<size_t>(count));
    std::vector<EGLDisplay> displays;
    for (EGLDeviceEXT device : devices) {
        const char* text = eglQueryDeviceStringEXT(device, EGL_EXTENSIONS);
        if (text && std::strstr(text, "EGL_MESA_device_software")) continue;
        displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
    }
    return displays;
}

/// Displays that need no window system, those of GPUs first.
std::vector<EGLDisplay> find_displays() {
    std::vector<EGLDisplay> displays;
    if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base")) {
        displays = hardware_displays();
        if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
            displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA,
                                                        EGL_DEFAULT_DISPLAY, nullptr));
        }
    }
    displays.push_back(eglGetDisplay(EGL_DEFAULT_DISPLAY));
    std::erase(displays, EGL_NO_DISPLAY);
    return displays;
}

/// A context of OpenGL 3.3 core on a display that can be initialized. Displays are shared by the
/// whole process, so none is ever terminated here.
Result<EGLContext> make_context(EGLDisplay display) {
    if (!eglInitialize(display, nullptr, nullptr)) {
        return Error{
            "pictures need an EGL display without a window; none could be initialized, "
            "install a driver (Debian: libegl-mesa0)"};
    }
    if (!epoxy_has_egl_extension(display, "EGL_KHR_surfaceless_context")) {
        return Error{
            "pictures need EGL_KHR_surfaceless_context, which the driver lacks; install "
            "another"};
    }
    const EGLint config_attributes[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                        EGL_NONE};
    EGLConfig config = nullptr;
    EGLint config_count = 0;
    if (!eglChooseConfig(display, config_attributes, &config, 1, &config_count) ||
        config_count < 1) {
        return Error{
            "pictures need an EGL configuration for OpenGL; the driver has none, install "
            "another"};
    }
    const EGLint context_attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                         3,
                                         EGL_CONTEXT_MINOR_VERSION,
                                         3,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                         EGL_NONE};
    // The API is state of the thread and belongs to the caller.
    const EGLenum caller_api = eglQueryAPI();
    eglBindAPI(EGL_OPENGL_API);
    const EGLContext context =
        eglCreateContext(display, config, EGL_NO_CONTEXT, context_attributes);
    eglBindAPI(caller_api);
    if (context == EGL_NO_CONTEXT) {
        return Error{
            "pictures need OpenGL 3.3 core; the EGL driver offers no such context, install "
            "another"};
    }
    return context;
}

}  // namespace

Result<std::unique_ptr<GlContext>> GlContext::create() {
    if (!epoxy_has_egl()) {
        return Error{"pictures need EGL, which is not installed; install libegl1"};
    }
    if (!has_opengl()) {
        return Error{
            "pictures need OpenGL; neither libOpenGL.so.0 nor libGL.so.1 loads, install "
            "libopengl0"};
    }
    std::string reason =
        "pictures need an EGL display without a window; none could be initialized, "
        "install a driver (Debian: libegl-mesa0)";
    for (const EGLDisplay display : find_displays()) {
        const Result<EGLContext> context = make_context(display);
        if (!context) {
            reason = context.error();
            continue;
        }
        std::unique_ptr<GlContext> result(new GlContext);
        result->display_ = display;
        result->context_ = *context;
        return result;
    }
    return Error{reason};
}

GlContext::~GlContext() { eglDestroyContext(display_, context_); }

CurrentContext::CurrentContext(const GlContext& context)
    : own_display_(context.display_),
      display_(eglGetCurrentDisplay()),
      draw_surface_(eglGetCurrentSurface(EGL_DRAW)),
      read_surface_(eglGetCurrentSurface(EGL_READ)),
      context_(eglGetCurrentContext()),
      api_(eglQueryAPI()) {
    eglBindAPI(EGL_OPENGL_API);
    ok_ =
        eglMakeCurrent(own_display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context.context_) == EGL_TRUE;
}

CurrentContext::~CurrentContext() {
    if (ok_ && context_ == EGL_NO_CONTEXT) {
        eglMakeCurrent(own_display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
    eglBindAPI(api_);
    if (ok_ && context_ != EGL_NO_CONTEXT) {
        eglMakeCurrent(display_, draw_surface_, read_surface_, context_);
    }
}

}  // namespace bsoil::render
