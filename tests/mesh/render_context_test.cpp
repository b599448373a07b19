// The renderer beside a caller's own GL context, and in it.
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "render_fixture.h"

namespace bsoil::render::render_context_test {
namespace {

TEST_F(Render, the_callers_context_is_current_again) {
    // Without a context before, none is left behind.
    ASSERT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
    View view = front_view();
    view.items = {item_of(renderer_->add_mesh(sphere_mesh(1, {1, 1, 1})), {})};
    draw(view);
    EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);

    const EGLDisplay display =
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) {
        GTEST_SKIP() << "no surfaceless EGL display for a caller's context";
    }
    const EGLint attributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                 EGL_OPENGL_ES2_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    ASSERT_TRUE(eglChooseConfig(display, attributes, &config, 1, &count) && count == 1);
    const EGLint size[] = {EGL_WIDTH, 4, EGL_HEIGHT, 4, EGL_NONE};
    const EGLSurface surface = eglCreatePbufferSurface(display, config, size);
    ASSERT_NE(surface, EGL_NO_SURFACE);
    ASSERT_TRUE(eglBindAPI(EGL_OPENGL_ES_API));
    const EGLint version[] = {EGL_CONTEXT_CLIENT_VERSION, 2, EGL_NONE};
    const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, version);
    ASSERT_NE(context, EGL_NO_CONTEXT);
    ASSERT_TRUE(eglMakeCurrent(display, surface, surface, context));
    EXPECT_FALSE(renderer_->draw(view, 0));  // the caller's framebuffer is another context's
    draw(view);
    renderer_->remove_mesh(view.items[0].mesh);
    EXPECT_TRUE(Renderer::create());
    renderer_.reset();
    EXPECT_EQ(eglGetCurrentContext(), context);
    EXPECT_EQ(eglGetCurrentSurface(EGL_DRAW), surface);
    EXPECT_EQ(eglQueryAPI(), static_cast<EGLenum>(EGL_OPENGL_ES_API));
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglBindAPI(EGL_OPENGL_API);
    eglDestroyContext(display, context);
    eglDestroySurface(display, surface);
}

/// An OpenGL core context with a small surface, current while it lives; null without one.
class CallersContext {
  public:
    CallersContext() {
        display_ =
            eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        if (display_ == EGL_NO_DISPLAY || !eglInitialize(display_, nullptr, nullptr)) return;
        const EGLint attributes[] = {EGL_SURFACE_TYPE,
                                     EGL_PBUFFER_BIT,
                                     EGL_RENDERABLE_TYPE,
                                     EGL_OPENGL_BIT,
                                     EGL_RED_SIZE,
                                     8,
                                     EGL_DEPTH_SIZE,
                                     24,
                                     EGL_NONE};
        EGLConfig config = nullptr;
        EGLint count = 0;
        if (!eglChooseConfig(display_, attributes, &config, 1, &count) || count != 1) return;
        const EGLint size[] = {EGL_WIDTH, 320, EGL_HEIGHT, 200, EGL_NONE};
        surface_ = eglCreatePbufferSurface(display_, config, size);
        eglBindAPI(EGL_OPENGL_API);
        const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                                  3,
                                  EGL_CONTEXT_MINOR_VERSION,
                                  3,
                                  EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                  EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                  EGL_NONE};
        context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, version);
        is_current_ = surface_ != EGL_NO_SURFACE && context_ != EGL_NO_CONTEXT &&
                      eglMakeCurrent(display_, surface_, surface_, context_);
    }
    ~CallersContext() {
        if (display_ == EGL_NO_DISPLAY) return;
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
        if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
    }
    bool is_current() const { return is_current_; }

  private:
    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLSurface surface_ = EGL_NO_SURFACE;
    EGLContext context_ = EGL_NO_CONTEXT;
    bool is_current_ = false;
};

/// Of the window, in rows from below.
std::vector<uint8_t> window_pixels() {
    std::vector<uint8_t> pixels(4 * 320 * 200);
    glReadPixels(0, 0, 320, 200, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    return pixels;
}

TEST_F(Render, a_hosts_window_gets_the_same_picture) {
    View view = front_view();
    const Mesh ball = sphere_mesh(1, {0.8f, 0.3f, 0.1f});
    view.items = {item_of(renderer_->add_mesh(ball), {})};
    view.floor_height_m = -1;
    const Image off_screen = draw(view);
    const CallersContext window;
    if (!window.is_current()) {
        GTEST_SKIP() << "no EGL surface that could be a host's window";
    }
    auto in_window = Renderer::create({.callers_context = true});
    ASSERT_TRUE(in_window) << in_window.error();
    view.items = {item_of((*in_window)->add_mesh(ball), {})};
    const Status drawn = (*in_window)->draw(view, 0);
    ASSERT_TRUE(drawn) << drawn.error();
    const std::vector<uint8_t> pixels = window_pixels();
    // A window may have more bits a colour than 8: each is rounded once more.
    int farthest = 0;
    for (int y = 0; y < 200; ++y) {
        for (int x = 0; x < 320; ++x) {
            for (int c = 0; c < 3; ++c) {
                farthest = std::max(farthest, std::abs(pixels[4 * ((199 - y) * 320 + x) + c] -
                                                       off_screen.pixel(x, y)[c]));
            }
        }
    }
    EXPECT_LE(farthest, 1);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    EXPECT_FALSE(glIsEnabled(GL_DEPTH_TEST));
}

TEST_F(Render, a_hosts_state_does_not_matter_and_is_there_again) {
    const CallersContext window;
    if (!window.is_current()) {
        GTEST_SKIP() << "no EGL surface that could be a host's window";
    }
    GLuint own = 0, sampler = 0;
    glGenFramebuffers(1, &own);
    glGenSamplers(1, &sampler);
    glSamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, GL_NEAREST_MIPMAP_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, own);
    const auto bound = [] {
        GLint name = 0;
        glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &name);
        return static_cast<GLuint>(name);
    };
    auto in_window = Renderer::create({.callers_context = true});
    ASSERT_TRUE(in_window) << in_window.error();
    EXPECT_EQ(bound(), own);
    View view = front_view();
    view.items = {item_of((*in_window)->add_mesh(sphere_mesh(1, {0.8f, 0.3f, 0.1f})), {})};
    ASSERT_TRUE((*in_window)->draw(view, 0));
    const std::vector<uint8_t> expected = window_pixels();

    glBindFramebuffer(GL_FRAMEBUFFER, own);
    const auto set_state = [&] {
        glEnable(GL_SCISSOR_TEST);
        glScissor(10, 10, 20, 20);
        glEnable(GL_STENCIL_TEST);
        glStencilFunc(GL_NEVER, 0, 0);
        glEnable(GL_FRAMEBUFFER_SRGB);
        glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
        glClearDepth(0);
        glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
        glBindSampler(0, sampler);
        glEnable(static_cast<GLenum>(~0u));  // an error that nobody has asked for
    };
    set_state();
    const Status drawn = (*in_window)->draw(view, 0);
    EXPECT_TRUE(drawn) << drawn.error();
    EXPECT_TRUE(glIsEnabled(GL_SCISSOR_TEST));
    EXPECT_TRUE(glIsEnabled(GL_STENCIL_TEST));
    GLboolean mask[4]{};
    glGetBooleanv(GL_COLOR_WRITEMASK, mask);
    EXPECT_FALSE(mask[0]);
    EXPECT_EQ(window_pixels(), expected);
    glBindFramebuffer(GL_FRAMEBUFFER, own);
    const auto buffers = (*in_window)->buffers(view);
    ASSERT_TRUE(buffers) << buffers.error();
    EXPECT_GT(buffers->depths_m[100 * 320 + 160], 0);
    EXPECT_TRUE((*in_window)->render(view));
    EXPECT_EQ(bound(), own);
}

EGLBoolean refuse(EGLDisplay, EGLSurface, EGLSurface, EGLContext) { return EGL_FALSE; }

TEST_F(Render, where_egl_refuses_the_callers_objects_stay) {
    const MeshId ball = renderer_->add_mesh(sphere_mesh(1, {1, 1, 1}));
    const auto texture = renderer_->add_texture({1, 1, std::vector<uint8_t>(4, 255)});
    ASSERT_TRUE(texture) << texture.error();
    const CallersContext window;
    if (!window.is_current()) {
        GTEST_SKIP() << "no EGL surface that could be a host's window";
    }
    // More than the renderer has: each context counts its names from one.
    std::vector<GLuint> buffers(100), textures(100);
    glGenBuffers(100, buffers.data());
    glGenTextures(100, textures.data());
    for (const GLuint name : buffers) glBindBuffer(GL_ARRAY_BUFFER, name);
    for (const GLuint name : textures) glBindTexture(GL_TEXTURE_2D, name);
    const auto make_current = std::exchange(epoxy_eglMakeCurrent, refuse);
    EXPECT_FALSE(renderer_->render(front_view()));
    renderer_->remove_mesh(ball);
    renderer_->remove_texture(*texture);
    const MeshId box = renderer_->add_mesh(box_mesh({1, 1, 1}, {1, 1, 1}));
    EXPECT_NE(renderer_->add_mesh(sphere_mesh(1, {1, 1, 1})).value, box.value);
    renderer_.reset();
    epoxy_eglMakeCurrent = make_current;
    EXPECT_TRUE(std::ranges::all_of(buffers, glIsBuffer));
    EXPECT_TRUE(std::ranges::all_of(textures, glIsTexture));
}

}  // namespace
}  // namespace bsoil::render::render_context_test
