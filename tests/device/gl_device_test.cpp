/// What only the OpenGL backend has: reflection, limits, shader errors and a host with a context of
/// its own.
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <regex>

#include "device/egl_context.h"
#include "device/gl_program.h"
#include "device_fixture.h"
#include "soil/soil_kernels.h"

namespace bsoil::device::gl_device_test {
namespace {

/// Any OpenGL 4.5 context, as a host has one.
Result<EglContext> create_host_context() {
    const auto displays = find_egl_displays();
    if (!displays) return Error{displays.error()};
    std::string errors;
    for (const EglDisplay& display : *displays) {
        auto context = EglContext::create(display);
        if (context) return context;
        errors += context.error() + "; ";
    }
    return Error{errors};
}

#define SKIP_WITHOUT(result)              \
    if (!(result)) {                      \
        GTEST_SKIP() << (result).error(); \
    }

TEST(GlDevice, kernels_of_the_library_compile) {
    auto device = create_gl_device(soil_kernel_set(), true);
    SKIP_WITHOUT(find_egl_displays());
    ASSERT_TRUE(device) << device.error();
    EXPECT_EQ((*device)->backend_name(), "gl");
    EXPECT_NE((*device)->device_name(), "");
}

TEST(GlDevice, uniform_block_has_the_offsets_of_the_struct) {
    const auto context = create_host_context();
    SKIP_WITHOUT(context);
    const CurrentContext current(*context);
    const auto program = finish_program(begin_program(test_kernel_set(), probe_builtins));
    ASSERT_TRUE(program) << program.error();

    const auto file = std::ranges::find(test_kernel_set().files, std::string_view("test_params.h"),
                                        &ShaderFile::name);
    ASSERT_NE(file, test_kernel_set().files.end());
    const std::string text(file->text);
    const std::regex member("(?:^|\\n)int (\\w+);");
    int offset = 0;
    for (auto it = std::sregex_iterator(text.begin(), text.end(), member);
         it != std::sregex_iterator(); ++it) {
        const std::string name = fmt::format("ParamsBlock.{}", (*it)[1].str());
        const char* const name_text = name.c_str();
        GLuint index = GL_INVALID_INDEX;
        glGetUniformIndices(program->name(), 1, &name_text, &index);
        ASSERT_NE(index, GL_INVALID_INDEX) << name;
        GLint gl_offset = -1;
        glGetActiveUniformsiv(program->name(), 1, &index, GL_UNIFORM_OFFSET, &gl_offset);
        EXPECT_EQ(gl_offset, offset) << name;
        offset += static_cast<int>(sizeof(int32_t));
    }
    EXPECT_EQ(offset, static_cast<int>(sizeof(TestParams)));
}

TEST(GlDevice, storage_blocks_are_bound_in_the_order_of_the_buffers) {
    const auto context = create_host_context();
    SKIP_WITHOUT(context);
    const CurrentContext current(*context);
    const auto program = finish_program(begin_program(test_kernel_set(), touch_buffers));
    ASSERT_TRUE(program) << program.error();
    for (int i = 0; i < Buffer::count; ++i) {
        const char* const member = test_kernel_set().buffers[static_cast<size_t>(i)];
        const GLuint variable = glGetProgramResourceIndex(program->name(), GL_BUFFER_VARIABLE,
                                                          fmt::format("{}[0]", member).c_str());
        ASSERT_NE(variable, GL_INVALID_INDEX) << member;
        const GLenum block_and_stride[] = {GL_BLOCK_INDEX, GL_ARRAY_STRIDE};
        GLint values[2] = {};
        glGetProgramResourceiv(program->name(), GL_BUFFER_VARIABLE, variable, 2, block_and_stride,
                               2, nullptr, values);
        EXPECT_EQ(values[1], static_cast<GLint>(sizeof(int32_t)));
        const GLenum kBinding = GL_BUFFER_BINDING;
        GLint binding = -1;
        glGetProgramResourceiv(program->name(), GL_SHADER_STORAGE_BLOCK,
                               static_cast<GLuint>(values[0]), 1, &kBinding, 1, nullptr, &binding);
        EXPECT_EQ(binding, i) << member;
    }
}

TEST(GlDevice, too_large_a_buffer_is_an_error_that_names_the_size) {
    auto device = create_gl_device(test_kernel_set(), true);
    SKIP_WITHOUT(device);
    const auto context = create_host_context();
    const int64_t bytes_max = context->capabilities().storage_block_bytes;
    const Status status = (*device)->allocate(Buffer::inputs, bytes_max / 4 + 1);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().find("buffer inputs"), std::string::npos) << status.error();
    EXPECT_NE(status.error().find("MiB"), std::string::npos) << status.error();
    // The device goes on.
    EXPECT_TRUE((*device)->allocate(Buffer::inputs, 64));
    EXPECT_EQ((*device)->failure(), "");
}

TEST(GlDevice, faulty_shader_is_an_error_with_kernel_file_and_line) {
    std::vector<ShaderFile> files(test_kernel_set().files.begin(), test_kernel_set().files.end());
    for (ShaderFile& file : files) {
        if (file.name == "mark_groups.glsl") {
            file.text =
                "// first line\nvoid mark_groups(int group, int lane) {\n    missing = 1;\n}\n";
        }
    }
    KernelSet faulty = test_kernel_set();
    faulty.files = files;
    SKIP_WITHOUT(create_host_context());
    const auto device = create_gl_device(faulty, true);
    ASSERT_FALSE(device);
    EXPECT_NE(device.error().find("kernel mark_groups does not compile"), std::string::npos)
        << device.error();
    EXPECT_TRUE(std::regex_search(device.error(), std::regex("mark_groups\\.glsl:3\\D")))
        << device.error();
    EXPECT_NE(device.error().find("missing"), std::string::npos) << device.error();
}

TEST(GlDevice, driver_logs_name_files) {
    const std::vector<KernelSource::Line> lines{
        {"prelude.glsl", 1}, {"soil_params.h", 1}, {"prelude.glsl", 3}, {"kernel.glsl", 1}};
    EXPECT_EQ(name_files("0:4(5): error: no\n", lines), "kernel.glsl:1(5): error: no\n");
    EXPECT_EQ(name_files("0(3) : error C1: no", lines), "prelude.glsl:3 : error C1: no\n");
    EXPECT_EQ(name_files("ERROR: 0:2: no\nWARNING: 0:1: odd\n", lines),
              "ERROR: soil_params.h:1: no\nWARNING: prelude.glsl:1: odd\n");
    EXPECT_EQ(name_files("3 errors\n0:99: far\n", lines), "3 errors\n0:99: far\n");
}

/// A host's own context with a surface, and what it sees of it.
class HostContext {
  public:
    explicit HostContext(EGLenum api) {
        const auto displays = find_egl_displays();
        if (!displays) return;
        display_ = displays->back().handle;
        eglInitialize(display_, nullptr, nullptr);
        eglBindAPI(api);
        const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                 api == EGL_OPENGL_API ? EGL_OPENGL_BIT : EGL_OPENGL_ES2_BIT,
                                 EGL_NONE};
        EGLConfig config = nullptr;
        EGLint count = 0;
        if (eglChooseConfig(display_, wanted, &config, 1, &count) == EGL_FALSE || count == 0) {
            return;
        }
        const EGLint size[] = {EGL_WIDTH, 8, EGL_HEIGHT, 8, EGL_NONE};
        draw_ = eglCreatePbufferSurface(display_, config, size);
        read_ = eglCreatePbufferSurface(display_, config, size);
        const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 2, EGL_NONE};
        context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, version);
        is_usable_ = eglMakeCurrent(display_, draw_, read_, context_) == EGL_TRUE;
    }
    ~HostContext() {
        if (display_ != EGL_NO_DISPLAY) {
            eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
            eglDestroyContext(display_, context_);
            eglDestroySurface(display_, draw_);
            eglDestroySurface(display_, read_);
            eglBindAPI(EGL_OPENGL_ES_API);
        }
    }
    bool is_usable() const { return is_usable_; }
    void expect_current(const char* after) const {
        EXPECT_EQ(eglGetCurrentDisplay(), display_) << after;
        EXPECT_EQ(eglGetCurrentContext(), context_) << after;
        EXPECT_EQ(eglGetCurrentSurface(EGL_DRAW), draw_) << after;
        EXPECT_EQ(eglGetCurrentSurface(EGL_READ), read_) << after;
        EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR)) << after;
    }

  private:
    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
    EGLSurface draw_ = EGL_NO_SURFACE, read_ = EGL_NO_SURFACE;
    bool is_usable_ = false;
};

/// Runs every call of a device and checks the host's context after each.
template <typename Check>
void call_everything(const Check& check) {
    auto created = create_gl_device(test_kernel_set(), true);
    check("create_gl_device");
    ASSERT_TRUE(created) << created.error();
    std::unique_ptr<Device> device = std::move(*created);
    EXPECT_TRUE(device->allocate(Buffer::counts, 256));
    check("allocate");
    const std::vector<int32_t> words(256, 3);
    device->write(Buffer::counts, 0, words);
    check("write");
    device->fill_zero(Buffer::counts, 0, 256);
    check("fill_zero");
    EXPECT_TRUE(device->allocate(Buffer::entries, 4));
    dispatch(*device, mark_groups, plain_work(4));
    check("dispatch");
    EXPECT_EQ(read_words(*device, Buffer::counts, 1), std::vector<int32_t>{kLanesPerGroup});
    check("read");
    {
        const DeviceSession session(*device);
        device->mark_stage(0);
        dispatch(*device, mark_groups, plain_work(4));
    }
    check("a session");
    EXPECT_EQ(device->failure(), "");
    device.reset();
    check("~Device");
    list_devices(test_kernel_set());
    check("list_devices");
}

TEST(GlDevice, host_keeps_its_opengl_context) {
    const HostContext host(EGL_OPENGL_API);
    if (!host.is_usable()) {
        GTEST_SKIP() << "no OpenGL context with a surface here";
    }
    call_everything([&](const char* after) {
        host.expect_current(after);
        EXPECT_EQ(eglQueryAPI(), static_cast<EGLenum>(EGL_OPENGL_API)) << after;
    });
}

TEST(GlDevice, host_keeps_its_opengl_es_context) {
    const HostContext host(EGL_OPENGL_ES_API);
    if (!host.is_usable()) {
        GTEST_SKIP() << "no OpenGL ES context with a surface here";
    }
    call_everything([&](const char* after) {
        host.expect_current(after);
        EXPECT_EQ(eglQueryAPI(), static_cast<EGLenum>(EGL_OPENGL_ES_API)) << after;
    });
}

TEST(GlDevice, host_without_a_context_gets_none) {
    SKIP_WITHOUT(create_host_context());
    call_everything([&](const char* after) {
        EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT) << after;
        EXPECT_EQ(eglGetCurrentDisplay(), EGL_NO_DISPLAY) << after;
    });
}

TEST(GlDevice, a_session_makes_the_context_current_once) {
    auto device = create_gl_device(test_kernel_set(), true);
    SKIP_WITHOUT(device);
    ASSERT_TRUE((*device)->allocate(Buffer::inputs, 4));
    const int64_t before = (*device)->counters().context_count;
    {
        const DeviceSession session(**device);
        for (int i = 0; i < 10; ++i) {
            (*device)->fill_zero(Buffer::inputs, 0, 4);
            read_words(**device, Buffer::inputs, 4);
        }
    }
    EXPECT_EQ((*device)->counters().context_count - before, 1);
}

TEST(GlDevice, two_devices_do_not_meet) {
    auto first = create_gl_device(test_kernel_set(), true);
    SKIP_WITHOUT(first);
    auto second = create_gl_device(test_kernel_set(), true);
    ASSERT_TRUE(second) << second.error();
    for (Device* device : {first->get(), second->get()}) {
        ASSERT_TRUE(device->allocate(Buffer::inputs, 2));
    }
    const std::vector<int32_t> words{1, 2};
    (*first)->write(Buffer::inputs, 0, words);
    second->reset();
    EXPECT_EQ(read_words(**first, Buffer::inputs, 2), words);
}

}  // namespace
}  // namespace bsoil::device::gl_device_test
