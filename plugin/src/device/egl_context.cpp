#include "device/egl_context.h"

#include <dlfcn.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <string_view>
#include <utility>

namespace bsoil::device {

namespace {

/// Whether a list of words has one; null is an empty list.
bool has_word(const char* list, std::string_view word, char separator) {
    std::string_view rest = list != nullptr ? list : "";
    while (!rest.empty()) {
        const size_t end = std::min(rest.find(separator), rest.size());
        if (rest.substr(0, end) == word) return true;
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return false;
}

bool has_extension(const char* list, std::string_view extension) {
    return has_word(list, extension, ' ');
}

void APIENTRY print_message(GLenum, GLenum, GLuint, GLenum, GLsizei length, const GLchar* text,
                            const void*) {
    fmt::print(stderr, "OpenGL: {}\n", std::string_view(text, static_cast<size_t>(length)));
}

/// epoxy aborts the process when it has to call into a library that is not there, so ask first. The
/// handle is never closed: epoxy opens the same library again and keeps it.
bool has_library(const char* name) { return dlopen(name, RTLD_LAZY | RTLD_LOCAL) != nullptr; }

template <typename Function>
Function egl_function(const char* name) {
    return reinterpret_cast<Function>(eglGetProcAddress(name));
}

std::string egl_error_name() {
    switch (const EGLint error = eglGetError(); error) {
        case EGL_NOT_INITIALIZED:
            return "EGL_NOT_INITIALIZED";
        case EGL_BAD_ACCESS:
            return "EGL_BAD_ACCESS";
        case EGL_BAD_ALLOC:
            return "EGL_BAD_ALLOC";
        case EGL_BAD_ATTRIBUTE:
            return "EGL_BAD_ATTRIBUTE";
        case EGL_BAD_CONFIG:
            return "EGL_BAD_CONFIG";
        case EGL_BAD_CONTEXT:
            return "EGL_BAD_CONTEXT";
        case EGL_BAD_DISPLAY:
            return "EGL_BAD_DISPLAY";
        case EGL_BAD_MATCH:
            return "EGL_BAD_MATCH";
        case EGL_BAD_PARAMETER:
            return "EGL_BAD_PARAMETER";
        case EGL_CONTEXT_LOST:
            return "EGL_CONTEXT_LOST";
        default:
            return fmt::format("EGL error {:#x}", error);
    }
}

bool is_software_renderer(std::string name) {
    std::ranges::transform(name, name.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    constexpr std::array kSoftwareNames{"llvmpipe", "softpipe", "swiftshader", "swrast",
                                        "software"};
    return std::ranges::any_of(kSoftwareNames, [&](const char* software) {
        return name.find(software) != std::string::npos;
    });
}

std::vector<EglDisplay> find_device_displays(PFNEGLGETPLATFORMDISPLAYEXTPROC get_display) {
    const auto query_devices = egl_function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    const auto query_string =
        egl_function<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
    EGLint count = 0;
    if (query_devices == nullptr || query_devices(0, nullptr, &count) == EGL_FALSE) return {};
    std::vector<EGLDeviceEXT> devices(static_cast<size_t>(count));
    if (query_devices(count, devices.data(), &count) == EGL_FALSE) return {};
    std::vector<EglDisplay> displays;
    for (EGLint i = 0; i < count; ++i) {
        EGLDeviceEXT device = devices[static_cast<size_t>(i)];
        const char* extensions =
            query_string != nullptr ? query_string(device, EGL_EXTENSIONS) : nullptr;
        const bool is_software = has_extension(extensions, "EGL_MESA_device_software");
        const EGLDisplay handle = get_display(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
        if (handle != EGL_NO_DISPLAY) {
            displays.push_back({handle,
                                fmt::format("EGL device {}{}", i, is_software ? " (software)" : ""),
                                is_software});
        }
    }
    std::stable_partition(displays.begin(), displays.end(),
                          [](const EglDisplay& d) { return !d.is_software; });
    return displays;
}

}  // namespace

bool is_gl_asked(std::string_view word) {
    const char* words = std::getenv("BULLETSOIL_GL");
    return has_word(words, word, ',');
}

Result<std::vector<EglDisplay>> find_egl_displays() {
    if (!has_library("libEGL.so.1")) {
        return Error{
            "EGL is not installed (libEGL.so.1 cannot be loaded); install it (Debian: libegl1)"};
    }
    if (!has_library("libOpenGL.so.0") && !has_library("libGL.so.1")) {
        return Error{
            "OpenGL is not installed (neither libOpenGL.so.0 nor libGL.so.1 loads); install "
            "it (Debian: libopengl0)"};
    }
    const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    const auto get_display =
        egl_function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    if (!has_extension(extensions, "EGL_EXT_platform_base") || get_display == nullptr) {
        return Error{
            "no EGL driver is installed, or none offers EGL_EXT_platform_base; install one, or "
            "take "
            "the CPU backend"};
    }
    std::vector<EglDisplay> displays;
    if (has_extension(extensions, "EGL_EXT_platform_device") &&
        (has_extension(extensions, "EGL_EXT_device_base") ||
         has_extension(extensions, "EGL_EXT_device_enumeration"))) {
        displays = find_device_displays(get_display);
    }
    if (displays.empty() && has_extension(extensions, "EGL_MESA_platform_surfaceless")) {
        const EGLDisplay handle =
            get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        if (handle != EGL_NO_DISPLAY) {
            displays.push_back({handle, "EGL surfaceless platform", false});
        }
    }
    if (displays.empty()) {
        return Error{
            "EGL lists no device (no OpenGL driver is installed, or it is not allowed); install "
            "one, "
            "or take the CPU backend"};
    }
    return displays;
}

std::string GlCapabilities::shortfall(int buffer_count) const {
    if (storage_block_count < buffer_count) {
        return fmt::format("GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS is {}, the kernels need {}",
                           storage_block_count, buffer_count);
    }
    return {};
}

Result<EglContext> EglContext::create(const EglDisplay& display) {
    return create_in_group(display, EGL_NO_CONTEXT);
}

Result<EglContext> EglContext::create_beside(EGLDisplay hosts_display, EGLContext hosts_context) {
    if (!has_library("libEGL.so.1")) {
        return Error{
            "EGL is not installed (libEGL.so.1 cannot be loaded); install it (Debian: libegl1)"};
    }
    if (hosts_display == EGL_NO_DISPLAY) hosts_display = eglGetCurrentDisplay();
    if (hosts_context == EGL_NO_CONTEXT) hosts_context = eglGetCurrentContext();
    if (hosts_display == EGL_NO_DISPLAY || hosts_context == EGL_NO_CONTEXT) {
        return Error{
            "no EGL context is current in this thread; a context made by GLX cannot share, ask "
            "the window's library for one by EGL"};
    }
    const EglDisplay display{hosts_display, "the host's EGL display", false};
    EGLint client = 0;
    if (eglQueryContext(hosts_display, hosts_context, EGL_CONTEXT_CLIENT_TYPE, &client) ==
        EGL_FALSE) {
        return Error{
            fmt::format("the host's context is none of its EGL display ({}); give both of "
                        "one display",
                        egl_error_name())};
    }
    if (client != EGL_OPENGL_API) {
        return Error{
            "the host's context is OpenGL ES; make one of desktop OpenGL, others do not share with "
            "the soil's"};
    }
    return create_in_group(display, hosts_context);
}

Result<EglContext> EglContext::create_in_group(const EglDisplay& display, EGLContext other) {
    const auto failed = [&](const std::string& what) {
        return Error{fmt::format("{}: {} ({}); update its driver, or take the CPU backend",
                                 display.name, what, egl_error_name())};
    };
    if (eglInitialize(display.handle, nullptr, nullptr) == EGL_FALSE) {
        return failed("cannot be initialized");
    }
    const BoundApi bound_api(EGL_OPENGL_API);
    const char* extensions = eglQueryString(display.handle, EGL_EXTENSIONS);
    if (!has_extension(extensions, "EGL_KHR_surfaceless_context")) {
        return failed("needs a surface: EGL_KHR_surfaceless_context is missing");
    }
    EGLConfig config = EGL_NO_CONFIG_KHR;
    if (!has_extension(extensions, "EGL_KHR_no_config_context")) {
        const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0,
                                 EGL_NONE};
        EGLint count = 0;
        if (eglChooseConfig(display.handle, wanted, &config, 1, &count) == EGL_FALSE ||
            count == 0) {
            return failed("has no configuration for OpenGL");
        }
    }
    const std::vector<EGLint> core{
        EGL_CONTEXT_MAJOR_VERSION,       4,
        EGL_CONTEXT_MINOR_VERSION,       5,
        EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT};
    // Drivers refuse an attribute that they do not know: what is not needed is asked for first.
    using Pair = std::pair<EGLint, EGLint>;
    constexpr Pair kSaysResets{EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY,
                               EGL_LOSE_CONTEXT_ON_RESET};  // reports a GPU that was reset
    constexpr Pair kTalks{EGL_CONTEXT_OPENGL_DEBUG, EGL_TRUE};
    const auto create_with = [&](std::initializer_list<Pair> more) {
        std::vector<EGLint> wanted = core;
        for (const auto& [name, value] : more) wanted.insert(wanted.end(), {name, value});
        wanted.push_back(EGL_NONE);
        return eglCreateContext(display.handle, config, other, wanted.data());
    };
    EGLContext handle = EGL_NO_CONTEXT;
    if (is_gl_asked("checked")) handle = create_with({kSaysResets, kTalks});
    if (handle == EGL_NO_CONTEXT) handle = create_with({kSaysResets});
    if (handle == EGL_NO_CONTEXT) handle = create_with({});
    if (handle == EGL_NO_CONTEXT && other != EGL_NO_CONTEXT) {
        return failed("has no OpenGL 4.5 core context that shares with the host's");
    }
    if (handle == EGL_NO_CONTEXT) return failed("has no OpenGL 4.5 core context");
    EglContext context(display.handle, handle);
    const Status status = context.read_capabilities(display.is_software);
    if (!status) return Error{fmt::format("{}: {}", display.name, status.error())};
    return context;
}

Status EglContext::read_capabilities(bool display_is_software) {
    const CurrentContext current(*this);
    if (!current.error().empty()) return Error{current.error()};
    const auto text = [](GLenum name) {
        const GLubyte* value = glGetString(name);
        return std::string(value != nullptr ? reinterpret_cast<const char*>(value) : "unknown");
    };
    capabilities_.renderer = text(GL_RENDERER);
    capabilities_.version = text(GL_VERSION);
    capabilities_.is_software = display_is_software || is_software_renderer(capabilities_.renderer);
    constexpr int kVersionNeeded = 45;  // as epoxy counts
    if (!epoxy_is_desktop_gl() || epoxy_gl_version() < kVersionNeeded) {
        return Error{fmt::format("{} offers OpenGL {}, at least 4.5 is needed",
                                 capabilities_.renderer, capabilities_.version)};
    }
    if (is_gl_asked("checked")) {
        glEnable(GL_DEBUG_OUTPUT);
        glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        glDebugMessageCallback(print_message, nullptr);
    }
    glGetIntegerv(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS, &capabilities_.storage_block_count);
    GLint64 block_bytes = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block_bytes);
    capabilities_.storage_block_bytes = block_bytes;
    return Done{};
}

EglContext::EglContext(EglContext&& other) noexcept { *this = std::move(other); }

EglContext& EglContext::operator=(EglContext&& other) noexcept {
    std::swap(display_, other.display_);
    std::swap(context_, other.context_);
    std::swap(capabilities_, other.capabilities_);
    return *this;
}

EglContext::~EglContext() {
    if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
}

CurrentContext::CurrentContext(const EglContext& context) : display_(context.display_) {
    if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context.context_) == EGL_FALSE) {
        error_ = fmt::format(
            "the OpenGL context cannot be made current ({}); a GLX context may be current in this "
            "thread",
            egl_error_name());
    }
}

CurrentContext::~CurrentContext() {
    if (caller_context_ != EGL_NO_CONTEXT) {
        eglMakeCurrent(caller_display_, caller_draw_, caller_read_, caller_context_);
    } else if (error_.empty()) {
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    }
}

}  // namespace bsoil::device
