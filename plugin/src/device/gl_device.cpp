/// The OpenGL backend: buffers as shader storage blocks, kernels as compute programs.
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "device/allocation_error.h"
#include "device/egl_context.h"
#include "device/gl_objects.h"
#include "device/gl_program.h"
#include "device/kernel_set.h"

namespace bsoil::device {

namespace {

constexpr GLsizeiptr kWordBytes = sizeof(int32_t);
/// std140 rounds blocks up to 16 bytes; a buffer must not be shorter than its block.
constexpr GLsizeiptr kParamBytes = (sizeof(KernelParams) + 15) / 16 * 16;

std::string gl_error_name(GLenum error) {
    switch (error) {
        case GL_INVALID_ENUM:
            return "GL_INVALID_ENUM";
        case GL_INVALID_VALUE:
            return "GL_INVALID_VALUE";
        case GL_INVALID_OPERATION:
            return "GL_INVALID_OPERATION";
        case GL_OUT_OF_MEMORY:
            return "GL_OUT_OF_MEMORY";
        case GL_CONTEXT_LOST:
            return "GL_CONTEXT_LOST";
        default:
            return fmt::format("GL error {:#x}", error);
    }
}

class GlDevice final : public Device {
  public:
    /// Compiles all kernels.
    static Result<std::unique_ptr<Device>> create(const KernelSet& kernel_set, EglContext context) {
        std::unique_ptr<GlDevice> device(new GlDevice(kernel_set, std::move(context)));
        const Status status = device->initialize();
        if (!status) {
            return Error{status.error()};
        }
        return std::unique_ptr<Device>(std::move(device));
    }

    ~GlDevice() override {
        const CurrentContext current(context_);
        if (current.error().empty()) {
            objects_.reset();
        } else {
            // They go with the context. Deleting them here would delete objects of the caller's
            // context.
            static_cast<void>(objects_.release());
        }
    }

    std::string backend_name() const override { return "gl"; }
    std::string device_name() const override { return context_.capabilities().renderer; }
    int thread_count() const override { return 1; }
    std::string failure() const override { return failure_; }

    Status allocate(Buffer buffer, int64_t words) override {
        assert(words >= 0);
        const CurrentContext current(context_);
        if (!check(current)) {
            return Error{failure_};
        }
        return allocate_current(buffer, words);
    }

    void write(Buffer buffer, int64_t offset, std::span<const int32_t> words) override {
        assert_range(buffer, offset, std::ssize(words));
        const CurrentContext current(context_);
        if (check(current) && !words.empty()) {
            glNamedBufferSubData(slot(buffer).object.name(), offset * kWordBytes,
                                 std::ssize(words) * kWordBytes, words.data());
        }
    }

    void read(Buffer buffer, int64_t offset, std::span<int32_t> words) override {
        assert_range(buffer, offset, std::ssize(words));
        const CurrentContext current(context_);
        if (check(current) && !words.empty()) {
            glGetNamedBufferSubData(slot(buffer).object.name(), offset * kWordBytes,
                                    std::ssize(words) * kWordBytes, words.data());
            check_errors();
        }
        if (!failure_.empty()) {
            std::ranges::fill(words, 0);
        }
    }

    void fill_zero(Buffer buffer, int64_t offset, int64_t count) override {
        assert_range(buffer, offset, count);
        const CurrentContext current(context_);
        if (check(current) && count > 0) {
            glClearNamedBufferSubData(slot(buffer).object.name(), GL_R32I, offset * kWordBytes,
                                      count * kWordBytes, GL_RED_INTEGER, GL_INT, nullptr);
        }
    }

    void set_params(std::span<const int32_t> words) override {
        assert(std::ssize(words) == kParamWords);
        std::memcpy(&params_, words.data(), words.size_bytes());
        params_changed_ = true;
    }

    void dispatch(int kernel, const WorkList& work) override {
        assert(kernel >= 0 && kernel < std::ssize(objects_->programs));
        assert(covers_all_groups(work));
        const CurrentContext current(context_);
        if (!check(current) || work.group_count == 0) {
            return;
        }
        upload_params(work);
        glUseProgram(objects_->programs[static_cast<size_t>(kernel)].name());
        const int columns = std::min(work.group_count, kGroupsPerRow);
        const int rows = (work.group_count + kGroupsPerRow - 1) / kGroupsPerRow;
        glDispatchCompute(static_cast<GLuint>(columns), static_cast<GLuint>(rows), 1);
        // This kernel wrote storage blocks; the next one, and read, write and fill_zero, come after
        // it.
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    }

    void finish() override {
        const CurrentContext current(context_);
        if (check(current)) {
            glFinish();
            check_errors();
        }
    }

    int32_t* host_view(Buffer) override { return nullptr; }

    int64_t memory_bytes() const override {
        int64_t bytes = 0;
        for (const Slot& slot : objects_->slots) {
            bytes += slot.words * kWordBytes;
        }
        return bytes;
    }

  private:
    struct Slot {
        GlBuffer object;
        int64_t words = 0;
    };
    struct Objects {
        std::vector<GlProgram> programs;
        Slot slots[kBufferCount];
        GlBuffer params;
    };

    GlDevice(const KernelSet& kernel_set, EglContext context)
        : kernel_set_(kernel_set), context_(std::move(context)) {}

    Slot& slot(Buffer buffer) { return objects_->slots[static_cast<int>(buffer)]; }

    Status initialize() {
        const CurrentContext current(context_);
        if (!check(current)) {
            return Error{failure_};
        }
        for (int kernel = 0; kernel < std::ssize(kernel_set_.kernels); ++kernel) {
            auto program = create_program(kernel_set_, kernel);
            if (!program) {
                return Error{fmt::format("{}: {}", device_name(), program.error())};
            }
            objects_->programs.push_back(std::move(*program));
        }
        GLuint name = 0;
        glCreateBuffers(1, &name);
        objects_->params = GlBuffer(name);
        objects_->params.set_label("params");
        glNamedBufferStorage(name, kParamBytes, nullptr, GL_DYNAMIC_STORAGE_BIT);
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, name);
        // A block without a buffer behind it is undefined behaviour even in a kernel that does not
        // read it.
        for (int i = 0; i < kBufferCount; ++i) {
            if (Status status = allocate_current(static_cast<Buffer>(i), 0); !status) {
                return status;
            }
        }
        return Done{};
    }

    Status allocate_current(Buffer buffer, int64_t words) {
        const int64_t bytes_max = context_.capabilities().storage_block_bytes;
        if (words > bytes_max / kWordBytes) {
            return allocation_error(buffer, words,
                                    fmt::format("one storage block of {} has {} MiB at most "
                                                "(GL_MAX_SHADER_STORAGE_BLOCK_SIZE)",
                                                device_name(), bytes_max >> 20));
        }
        Slot& target = slot(buffer);
        target.object.reset();  // first, so that old and new are never there at once
        target.words = 0;
        check_errors();  // so that what glGetError says below is about this allocation
        if (!failure_.empty()) {
            return Error{failure_};
        }
        GLuint name = 0;
        glCreateBuffers(1, &name);
        GlBuffer object(name);
        object.set_label(buffer_name(buffer));
        glNamedBufferStorage(name, std::max<int64_t>(words, 1) * kWordBytes, nullptr,
                             GL_DYNAMIC_STORAGE_BIT);
        glClearNamedBufferData(name, GL_R32I, GL_RED_INTEGER, GL_INT, nullptr);
        if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
            return allocation_error(buffer, words,
                                    fmt::format("{} from {}", gl_error_name(error), device_name()));
        }
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, static_cast<GLuint>(buffer), name);
        target.object = std::move(object);
        target.words = words;
        return Done{};
    }

    void upload_params(const WorkList& work) {
        params_changed_ = params_changed_ || params_.list_offset != work.list_offset ||
                          params_.list_count != work.group_count;
        if (params_changed_) {
            params_.list_offset = work.list_offset;
            params_.list_count = work.group_count;
            glNamedBufferSubData(objects_->params.name(), 0, sizeof(params_), &params_);
            params_changed_ = false;
        }
    }

    /// Whether GL may be called.
    bool check(const CurrentContext& current) {
        if (failure_.empty()) {
            failure_ = current.error();
        }
        return failure_.empty();
    }

    /// Notes a lost GPU and errors of earlier calls. Only where the device is waited for anyway.
    void check_errors() {
        if (const GLenum reset = glGetGraphicsResetStatus(); reset != GL_NO_ERROR) {
            failure_ = fmt::format("{} was reset; its buffers are lost", device_name());
        } else if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
            failure_ = fmt::format("{} reports {}", device_name(), gl_error_name(error));
        }
    }

    void assert_range([[maybe_unused]] Buffer buffer, [[maybe_unused]] int64_t offset,
                      [[maybe_unused]] int64_t count) {
        assert(offset >= 0 && count >= 0 && offset + count <= slot(buffer).words);
    }

    const KernelSet& kernel_set_;
    EglContext context_;
    std::unique_ptr<Objects> objects_ = std::make_unique<Objects>();
    KernelParams params_{};
    bool params_changed_ = true;
    std::string failure_;
};

}  // namespace

Result<std::unique_ptr<Device>> create_gl_device(const KernelSet& kernel_set, bool allow_software) {
    const auto displays = find_egl_displays();
    if (!displays) {
        return Error{displays.error()};
    }
    std::optional<EglContext> software;  // taken only when no hardware is found
    std::string refusals;
    const auto refuse = [&](const std::string& why) {
        refusals += refusals.empty() ? why : "; " + why;
    };
    for (const EglDisplay& display : *displays) {
        if (display.is_software && !allow_software) {
            refuse(display.name + ": is a software renderer");
            continue;
        }
        auto context = EglContext::create(display);
        if (!context) {
            refuse(context.error());
            continue;
        }
        const GlCapabilities& gl = context->capabilities();
        if (const std::string shortfall = gl.shortfall(); !shortfall.empty()) {
            refuse(fmt::format("{}: {}", gl.renderer, shortfall));
        } else if (!gl.is_software) {
            return GlDevice::create(kernel_set, std::move(*context));
        } else if (!allow_software) {
            refuse(fmt::format("{}: is a software renderer", gl.renderer));
        } else if (!software) {
            software = std::move(*context);
        }
    }
    if (software) {
        return GlDevice::create(kernel_set, std::move(*software));
    }
    return Error{"no usable OpenGL 4.5 device: " + refusals};
}

}  // namespace bsoil::device
