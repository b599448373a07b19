/// Machines without OpenGL, or with too little of it: each test runs in a process of its own,
/// started with the environment that makes this machine look like that.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include "device_fixture.h"
#include "soil/soil_kernels.h"

namespace bsoil::device::gl_environment_test {
namespace {

/// An environment variable for the child process of a death test.
class EnvironmentVariable {
  public:
    EnvironmentVariable(const char* name, const std::string& value) : name_(name) {
        setenv(name, value.c_str(), 1);
        // Runs the child from the start of main, with this environment.
        testing::FLAGS_gtest_death_test_style = "threadsafe";
    }
    ~EnvironmentVariable() {
        if (before_) {
            setenv(name_, before_->c_str(), 1);
        } else {
            unsetenv(name_);
        }
    }
    EnvironmentVariable(const EnvironmentVariable&) = delete;
    EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

  private:
    static std::optional<std::string> value_of(const char* name) {
        const char* value = std::getenv(name);
        return value != nullptr ? std::optional<std::string>(value) : std::nullopt;
    }

    const char* name_;
    std::optional<std::string> before_ = value_of(name_);
};

constexpr const char* kMesaVersion = "MESA_GL_VERSION_OVERRIDE";

/// Whether OpenGL here is Mesa's, which alone can be told to be an older one. The child of a death
/// test asks too, and has been told.
bool is_mesa() {
    if (std::getenv(kMesaVersion) != nullptr) return true;
    const auto devices = list_devices(test_kernel_set());
    const auto is_other = [](const DeviceInfo& device) {
        return device.usable && device.detail.starts_with("OpenGL") &&
               device.detail.find("Mesa") == std::string::npos;
    };
    return std::ranges::none_of(devices, is_other);
}

/// In the child: exits with 0 when there is no GL device, and the CPU stands in for it.
[[noreturn]] void expect_no_gl() {
    const auto device = create_gl_device(test_kernel_set(), true);
    std::fputs(device.error().c_str(), stderr);
    std::string reason;
    const auto automatic = create_device(Backend::automatic, 1, reason);
    const bool fell_back = automatic && (*automatic)->backend_name() == "cpu" && !reason.empty();
    const auto devices = list_devices(test_kernel_set());
    const bool lists_why = devices.size() >= 2 && devices[0].usable && !devices[1].usable &&
                           !devices[1].detail.empty();
    std::exit(!device && fell_back && lists_why ? 0 : 1);
}

TEST(GlEnvironmentDeathTest, without_a_driver_the_error_says_so) {
    const EnvironmentVariable variable("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent");
    EXPECT_EXIT(expect_no_gl(), testing::ExitedWithCode(0), "no EGL driver is installed");
}

TEST(GlEnvironmentDeathTest, without_compute_shaders_the_error_says_so) {
    if (!is_mesa()) GTEST_SKIP() << "this OpenGL cannot be told to be an older one";
    const EnvironmentVariable variable(kMesaVersion, "3.3");
    EXPECT_EXIT(expect_no_gl(), testing::ExitedWithCode(0), "OpenGL 4.5");
}

TEST(GlEnvironmentDeathTest, without_egl_the_error_says_so) {
    const char* others = std::getenv("LD_LIBRARY_PATH");
    const EnvironmentVariable variable("LD_LIBRARY_PATH", std::string(BROKEN_EGL_DIR) +
                                                              (others != nullptr ? ":" : "") +
                                                              (others != nullptr ? others : ""));
    EXPECT_EXIT(expect_no_gl(), testing::ExitedWithCode(0), "EGL is not installed");
}

TEST(DeviceChoice, asked_for_backends_are_given) {
    std::string reason;
    const auto cpu = create_device(Backend::cpu, 2, reason);
    ASSERT_TRUE(cpu);
    EXPECT_EQ((*cpu)->backend_name(), "cpu");
    EXPECT_EQ((*cpu)->thread_count(), 2);
    EXPECT_EQ(reason, "the CPU backend was asked for");
    const auto gl = create_device(Backend::gl, 0, reason);
    if (gl) {
        EXPECT_EQ((*gl)->backend_name(), "gl");
    }
}

}  // namespace
}  // namespace bsoil::device::gl_environment_test
