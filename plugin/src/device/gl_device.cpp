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
#include "device/gl_lane_list.h"
#include "device/gl_objects.h"
#include "device/gl_program.h"
#include "device/gl_read_back.h"
#include "device/gl_stage_times.h"
#include "device/gl_uploads.h"
#include "device/kernel_set.h"

namespace bsoil::device {

namespace {

constexpr GLsizeiptr kWordBytes = sizeof(int32_t);
/// std140 rounds blocks up to 16 bytes; a buffer must not be shorter than its block.
constexpr GLsizeiptr kBlockBytes = 16;

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

/// Software runs kernels by lists of lanes, unless BULLETSOIL_GL=hardware in the environment says
/// that it does what a GPU does. Both give the same bits.
bool lists_lanes(const GlCapabilities& gl) { return gl.is_software && !is_gl_asked("hardware"); }

/// Storage blocks that a device needs.
int storage_block_count(const KernelSet& set, const GlCapabilities& gl) {
    return static_cast<int>(set.buffers.size()) + (lists_lanes(gl) ? 1 : 0);
}

class GlDevice final : public Device {
  public:
    /// Compiles all kernels.
    static Result<std::unique_ptr<Device>> create(const KernelSet& set, EglContext context) {
        std::unique_ptr<GlDevice> device(new GlDevice(set, std::move(context)));
        const Status status = device->initialize();
        if (!status) return Error{status.error()};
        return std::unique_ptr<Device>(std::move(device));
    }

    ~GlDevice() override {
        const CurrentContext current(context_);
        if (current.error().empty()) {
            objects_.reset();
        } else {
            // They go with the context. Deleting them here would delete objects of the caller's
            // context.
            const LostGlObjects lost;
            objects_.reset();
        }
    }

    std::string backend_name() const override { return "gl"; }
    std::string device_name() const override { return context_.capabilities().renderer; }
    int thread_count() const override { return 1; }
    std::string failure() const override { return failure_; }

    uint32_t buffer_name(BufferIndex buffer) const override {
        return objects_->buffers[static_cast<size_t>(buffer)].name();
    }

    void* signal() override {
        const Use use(*this);
        if (!use.is_good()) return nullptr;
        flush_uploads();
        // Kernels wrote what another context reads, as whatever it is bound there.
        glMemoryBarrier(GL_ALL_BARRIER_BITS);
        objects_->fence = GlFence(glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0));
        glFlush();
        return objects_->fence.sync();
    }

    void wait_for(void* fence) override {
        const Use use(*this);
        if (use.is_good()) glWaitSync(static_cast<GLsync>(fence), 0, GL_TIMEOUT_IGNORED);
    }

    void mark_stage(int stage) override {
        assert(session_depth_ > 0 && stage >= 0 && stage < kStageCapacity);
        const Use use(*this);
        if (!use.is_good()) return;
        flush_uploads();
        objects_->times.mark(stage);
    }

    bool is_read_done() override {
        const Use use(*this);
        is_late_read_done_ =
            is_late_read_done_ || !use.is_good() || objects_->late_read_back.is_done();
        return is_late_read_done_;
    }

  protected:
    Status allocate_words(BufferIndex buffer, int64_t words) override {
        const Use use(*this);
        if (!use.is_good()) return Error{failure_};
        flush_uploads();
        return allocate_current(buffer, words);
    }

    Status rearrange_words(BufferIndex buffer, int64_t words,
                           std::span<const WordMove> moves) override {
        const Use use(*this);
        if (!use.is_good()) return Error{failure_};
        flush_uploads();
        GlBuffer old = std::move(object(buffer));
        object(buffer) = GlBuffer();
        const Status allocated = allocate_current(buffer, words);
        if (!allocated) {
            object(buffer) = std::move(old);
            glBindBufferBase(GL_SHADER_STORAGE_BUFFER, static_cast<GLuint>(buffer),
                             object(buffer).name());
            return allocated;
        }
        for (const WordMove& move : moves) {
            glCopyNamedBufferSubData(old.name(), object(buffer).name(), move.from * kWordBytes,
                                     move.to * kWordBytes, move.count * kWordBytes);
        }
        return Done{};
    }

    void write_words(BufferIndex buffer, int64_t offset, std::span<const int32_t> words) override {
        const Use use(*this);
        if (use.is_good()) {
            objects_->uploads.write(object(buffer).name(), offset * kWordBytes, words);
        }
    }

    void read_words(std::span<const ReadRange> ranges) override {
        const Use use(*this);
        ++counters_.wait_count;
        start(objects_->read_back, ranges);
        finish(objects_->read_back);
    }

    void start_reading(std::span<const ReadRange> ranges) override {
        const Use use(*this);
        start(objects_->late_read_back, ranges);
        is_late_read_done_ = false;
    }

    void finish_reading() override {
        const Use use(*this);
        if (!is_late_read_done_) ++counters_.wait_count;
        finish(objects_->late_read_back);
    }

    void clear_words(BufferIndex buffer, int64_t offset, int64_t count) override {
        const Use use(*this);
        if (use.is_good()) {
            objects_->uploads.clear(object(buffer).name(), offset * kWordBytes, count * kWordBytes);
        }
    }

    void run_kernel(int kernel, std::span<const int32_t> params, const WorkList& work) override {
        const Use use(*this);
        if (!use.is_good()) return;
        flush_uploads();
        upload_params(params);
        objects_->times.begin_kernel(kernel);
        if (objects_->listing_programs.empty()) {
            dispatch_groups(objects_->programs[static_cast<size_t>(kernel)], work.group_count,
                            work.group_count);
        } else {
            dispatch_listed(static_cast<size_t>(kernel), work.group_count);
        }
        // This kernel wrote storage blocks; the next one, and reads, writes and fills, come after
        // it.
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
        objects_->times.end_kernel();
        if (is_checked_) check_kernel(kernel);
    }

    void begin_session() override {
        begin_use();
        if (session_depth_++ == 0 && failure_.empty()) {
            objects_->times.begin(stage_ms_, counters_.kernel_ms);
        }
    }
    void end_session() override {
        if (--session_depth_ == 0 && failure_.empty()) objects_->times.end();
        end_use();
    }

  private:
    struct Objects {
        std::vector<GlProgram> programs, listing_programs;  ///< by kernel, or none
        GlLaneList lane_list;
        std::vector<GlBuffer> buffers;
        GlBuffer params;
        GlReadBack read_back, late_read_back;
        GlUploads uploads;
        GlStageTimes times;
        GlFence fence;
    };

    /// The device's context is current while one of these, or a session, is there.
    class Use {
      public:
        explicit Use(GlDevice& device) : device_(device) { device.begin_use(); }
        ~Use() { device_.end_use(); }
        Use(const Use&) = delete;
        Use& operator=(const Use&) = delete;
        /// Whether GL may be called.
        bool is_good() const { return device_.failure_.empty(); }

      private:
        GlDevice& device_;
    };

    GlDevice(const KernelSet& set, EglContext context)
        : Device(set), context_(std::move(context)) {}

    void begin_use() {
        if (use_depth_++ == 0) {
            current_.emplace(context_);
            ++counters_.context_count;
            if (failure_.empty()) failure_ = current_->error();
        }
    }
    void end_use() {
        if (--use_depth_ == 0) current_.reset();
    }

    void flush_uploads() {
        objects_->uploads.flush();
        counters_.write_call_count = objects_->uploads.call_count();
    }

    void start(GlReadBack& read_back, std::span<const ReadRange> ranges) {
        if (failure_.empty()) flush_uploads();
        read_back.begin();
        for (const ReadRange& range : ranges) {
            read_back.add(object(range.buffer).name(), range.offset * kWordBytes, range.words);
        }
        const int64_t before = read_back.copy_count();
        if (failure_.empty()) note_failure(read_back.start());
        counters_.read_copy_count += read_back.copy_count() - before;
    }

    void finish(GlReadBack& read_back) {
        if (failure_.empty()) note_failure(read_back.finish());
        if (failure_.empty()) check_errors();
        if (!failure_.empty()) read_back.fill_zero();
    }

    void note_failure(const std::string& error) {
        if (!error.empty()) failure_ = fmt::format("{} {}", device_name(), error);
    }

    GlBuffer& object(BufferIndex buffer) { return objects_->buffers[static_cast<size_t>(buffer)]; }

    Status initialize() {
        const Use use(*this);
        if (!use.is_good()) return Error{failure_};
        if (Status made = make_programs(); !made) return made;
        GLuint name = 0;
        glCreateBuffers(1, &name);
        objects_->params = GlBuffer(name);
        objects_->params.set_label("params");
        const GLsizeiptr param_bytes = kernel_set().param_words * kWordBytes;
        glNamedBufferStorage(name, (param_bytes + kBlockBytes - 1) / kBlockBytes * kBlockBytes,
                             nullptr, GL_DYNAMIC_STORAGE_BIT);
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, name);
        // A block without a buffer behind it is undefined behaviour even in a kernel that does not
        // read it.
        objects_->buffers.resize(kernel_set().buffers.size());
        for (int i = 0; i < std::ssize(objects_->buffers); ++i) {
            if (Status status = allocate_current(BufferIndex{i}, 0); !status) return status;
        }
        return Done{};
    }

    Status make_programs() {
        allow_compiler_threads();
        const bool is_listed = lists_lanes(context_.capabilities());
        std::vector<PendingProgram> pending;
        for (int kernel = 0; kernel < std::ssize(kernel_set().kernels); ++kernel) {
            if (is_listed) {
                pending.push_back(begin_program(kernel_set(), kernel, ProgramKind::lists_lanes));
            }
            pending.push_back(
                begin_program(kernel_set(), kernel,
                              is_listed ? ProgramKind::listed_lanes : ProgramKind::all_lanes));
        }
        for (size_t i = 0; i < pending.size(); ++i) {
            const bool lists = is_listed && i % 2 == 0;
            auto program = finish_program(std::move(pending[i]));
            if (!program) return Error{fmt::format("{}: {}", device_name(), program.error())};
            (lists ? objects_->listing_programs : objects_->programs)
                .push_back(std::move(*program));
        }
        return Done{};
    }

    /// Runs a program in so many work groups for a kernel's groups of lanes.
    void dispatch_groups(const GlProgram& program, int group_count, int work_group_count) {
        glUseProgram(program.name());
        glUniform1i(kGroupCountLocation, group_count);
        const int columns = std::min(work_group_count, kGroupsPerRow);
        const int rows = (work_group_count + kGroupsPerRow - 1) / kGroupsPerRow;
        glDispatchCompute(static_cast<GLuint>(columns), static_cast<GLuint>(rows), 1);
    }

    void dispatch_listed(size_t kernel, int group_count) {
        GlLaneList& list = objects_->lane_list;
        const auto binding = static_cast<GLuint>(kernel_set().buffers.size());
        if (const GLenum error = list.begin(binding, group_count); error != GL_NO_ERROR) {
            failure_ = fmt::format("{} reports {}", device_name(), gl_error_name(error));
            return;
        }
        dispatch_groups(objects_->listing_programs[kernel], group_count, list.listing_groups());
        glUseProgram(objects_->programs[kernel].name());
        list.dispatch();
    }

    Status allocate_current(BufferIndex buffer, int64_t words) {
        const int64_t bytes_max = context_.capabilities().storage_block_bytes;
        if (words > bytes_max / kWordBytes) {
            return allocation_error(kernel_set(), buffer, words,
                                    fmt::format("one storage block of {} has {} MiB at most "
                                                "(GL_MAX_SHADER_STORAGE_BLOCK_SIZE)",
                                                device_name(), bytes_max >> 20));
        }
        object(buffer).reset();  // first, so that old and new are never there at once
        check_errors();          // so that what glGetError says below is about this allocation
        if (!failure_.empty()) return Error{failure_};
        GLuint name = 0;
        glCreateBuffers(1, &name);
        GlBuffer made(name);
        made.set_label(kernel_set().buffers[static_cast<size_t>(buffer)]);
        glNamedBufferStorage(name, std::max<int64_t>(words, 1) * kWordBytes, nullptr,
                             GL_DYNAMIC_STORAGE_BIT);
        glClearNamedBufferData(name, GL_R32I, GL_RED_INTEGER, GL_INT, nullptr);
        if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
            return allocation_error(kernel_set(), buffer, words,
                                    fmt::format("{} from {}", gl_error_name(error), device_name()));
        }
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, static_cast<GLuint>(buffer), name);
        object(buffer) = std::move(made);
        return Done{};
    }

    void upload_params(std::span<const int32_t> params) {
        if (!std::ranges::equal(params, params_)) {
            params_.assign(params.begin(), params.end());
            glNamedBufferSubData(objects_->params.name(), 0,
                                 static_cast<GLsizeiptr>(params.size_bytes()), params.data());
        }
    }

    /// Notes a lost GPU and errors of earlier calls. Only where the device is waited for anyway.
    void check_errors() {
        if (const GLenum reset = glGetGraphicsResetStatus(); reset != GL_NO_ERROR) {
            failure_ = fmt::format("{} was reset; its buffers are lost", device_name());
        } else if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
            failure_ = fmt::format("{} reports {}", device_name(), gl_error_name(error));
        }
    }

    /// Waits, and names the kernel behind which something is wrong.
    void check_kernel(int kernel) {
        glFinish();
        check_errors();
        if (!failure_.empty()) {
            failure_ +=
                fmt::format(" (kernel {})", kernel_set().kernels[static_cast<size_t>(kernel)].name);
            fmt::print(stderr, "{}\n", failure_);
        }
    }

    EglContext context_;
    const bool is_checked_ = is_gl_asked("checked");
    std::unique_ptr<Objects> objects_ = std::make_unique<Objects>();
    std::optional<CurrentContext> current_;
    int use_depth_ = 0, session_depth_ = 0;
    bool is_late_read_done_ = true;
    std::vector<int32_t> params_;  ///< that the uniform block holds
    std::string failure_;
};

}  // namespace

Result<std::unique_ptr<Device>> create_gl_device(const KernelSet& kernel_set, bool allow_software) {
    const auto displays = find_egl_displays();
    if (!displays) return Error{displays.error()};
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
        if (const std::string shortfall = gl.shortfall(storage_block_count(kernel_set, gl));
            !shortfall.empty()) {
            refuse(fmt::format("{}: {}", gl.renderer, shortfall));
        } else if (!gl.is_software) {
            return GlDevice::create(kernel_set, std::move(*context));
        } else if (!allow_software) {
            refuse(fmt::format("{}: is a software renderer", gl.renderer));
        } else if (!software) {
            software = std::move(*context);
        }
    }
    if (software) return GlDevice::create(kernel_set, std::move(*software));
    return Error{"no usable OpenGL 4.5 device: " + refusals};
}

Result<std::unique_ptr<Device>> create_shared_gl_device(const KernelSet& kernel_set,
                                                        void* egl_display, void* egl_context) {
    auto context = EglContext::create_beside(egl_display, egl_context);
    if (!context) return Error{context.error()};
    const GlCapabilities& gl = context->capabilities();
    if (const std::string shortfall = gl.shortfall(storage_block_count(kernel_set, gl));
        !shortfall.empty()) {
        return Error{fmt::format("{}: {}", gl.renderer, shortfall)};
    }
    return GlDevice::create(kernel_set, std::move(*context));
}

}  // namespace bsoil::device
