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
#include "device/gl_kernels.h"
#include "device/gl_objects.h"
#include "device/gl_read_back.h"
#include "device/gl_stage_times.h"
#include "device/gl_storage.h"
#include "device/gl_uploads.h"
#include "device/kernel_set.h"

namespace bsoil::device {

namespace {

constexpr GLsizeiptr kWordBytes = sizeof(int32_t);
/// Words of a storage block with BULLETSOIL_GL=small_blocks in the environment. Ours: 4 MiB, three
/// for the first 64 tiles of a soil of 40 voxels. Larger: small soils do not try what large ones
/// need; smaller: they need more than there are.
constexpr int64_t kSmallBlockWords = int64_t{1} << 20;
/// Words of one block of several. Ours: 2 GiB, so that where blocks end are numbers of 31 bits.
/// Larger: they are not; smaller: more blocks.
constexpr int64_t kLongBlockWordsMost = int64_t{1} << 29;
/// std140 rounds blocks up to 16 bytes; a buffer must not be shorter than its block.
constexpr GLsizeiptr kBlockBytes = 16;

/// Software runs kernels by lists of lanes, unless BULLETSOIL_GL=hardware in the environment says
/// that it does what a GPU does. Both give the same bits.
bool lists_lanes(const GlCapabilities& gl) { return gl.is_software && !is_gl_asked("hardware"); }

/// Storage blocks that a device needs at least.
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

    uint32_t buffer_name(BufferIndex buffer) const override {
        const std::vector<GlBuffer>& blocks =
            objects_->buffers[static_cast<size_t>(buffer)].blocks();
        return blocks.empty() ? 0 : blocks.front().name();
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

    bool expect_words(BufferIndex buffer, int64_t words) override {
        expected_words_[static_cast<size_t>(buffer)] = words;
        return false;
    }

    Status rearrange_words(BufferIndex buffer, int64_t words,
                           std::span<const WordMove> moves) override {
        const Use use(*this);
        if (!use.is_good()) return Error{failure_};
        flush_uploads();
        GlStorage old = std::exchange(object(buffer), GlStorage());
        const Status allocated = allocate_current(buffer, words);
        if (!allocated) {
            object(buffer) = std::move(old);
            if (const Status kept = bind(buffer); !kept) return kept;
            return allocated;
        }
        for (const WordMove& move : moves) {
            object(buffer).copy_from(old, move.from, move.to, move.count);
        }
        return Done{};
    }

    void write_words(BufferIndex buffer, int64_t offset, std::span<const int32_t> words) override {
        const Use use(*this);
        if (!use.is_good()) return;
        object(buffer).for_parts(
            offset, std::ssize(words), [&](GLuint name, int64_t at, int64_t first, int64_t count) {
                objects_->uploads.write(
                    name, at * kWordBytes,
                    words.subspan(static_cast<size_t>(first), static_cast<size_t>(count)));
            });
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
        if (!use.is_good()) return;
        object(buffer).for_parts(
            offset, count, [&](GLuint name, int64_t at, int64_t, int64_t part) {
                objects_->uploads.clear(name, at * kWordBytes, part * kWordBytes);
            });
    }

    void run_kernel(int kernel, std::span<const int32_t> params, const WorkList& work) override {
        const Use use(*this);
        if (!use.is_good()) return;
        flush_uploads();
        upload_params(params);
        objects_->times.begin_kernel(kernel);
        if (const GLenum error = objects_->kernels.run(kernel, work.group_count);
            error != GL_NO_ERROR) {
            note_failure(fmt::format("reports {}", gl_error_name(error)));
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
        Objects(const KernelSet& set, bool by_lists) : kernels(set, by_lists) {}
        GlKernels kernels;
        std::vector<GlStorage> buffers;
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
        : Device(set),
          context_(std::move(context)),
          objects_(std::make_unique<Objects>(set, lists_lanes(context_.capabilities()))) {}

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
        if (objects_->uploads.has_failed()) {
            note_failure("has no memory for what is written, or does not answer");
        }
    }

    void start(GlReadBack& read_back, std::span<const ReadRange> ranges) {
        if (failure_.empty()) flush_uploads();
        read_back.begin();
        for (const ReadRange& range : ranges) {
            object(range.buffer)
                .for_parts(range.offset, std::ssize(range.words),
                           [&](GLuint name, int64_t at, int64_t first, int64_t count) {
                               read_back.add(name, at * kWordBytes,
                                             range.words.subspan(static_cast<size_t>(first),
                                                                 static_cast<size_t>(count)));
                           });
        }
        sent_bytes_ = objects_->uploads.sent_bytes();
        const int64_t before = read_back.copy_count();
        if (failure_.empty()) note_failure(read_back.start());
        counters_.read_copy_count += read_back.copy_count() - before;
    }

    void finish(GlReadBack& read_back) {
        if (failure_.empty()) note_failure(read_back.finish());
        if (failure_.empty()) objects_->uploads.note_done(sent_bytes_);
        if (failure_.empty()) check_errors();
        if (!failure_.empty()) read_back.fill_zero();
    }

    void note_failure(const std::string& error) {
        if (!error.empty()) failure_ = fmt::format("{} {}", device_name(), error);
    }

    GlStorage& object(BufferIndex buffer) { return objects_->buffers[static_cast<size_t>(buffer)]; }

    Status initialize() {
        const Use use(*this);
        if (!use.is_good()) return Error{failure_};
        const int64_t words_most = context_.capabilities().storage_block_bytes / kWordBytes;
        blocks_ = {words_most,
                   is_gl_asked("small_blocks") ? kSmallBlockWords
                                               : std::min(words_most, kLongBlockWordsMost),
                   std::vector<int>(kernel_set().buffers.size(), 1),
                   objects_->kernels.has_lists() ? 1 : 0};
        expected_words_.resize(kernel_set().buffers.size());
        if (Status made = compile(blocks_); !made) return made;
        objects_->buffers.resize(kernel_set().buffers.size());
        GLuint name = 0;
        glCreateBuffers(1, &name);
        objects_->params = GlBuffer(name);
        objects_->params.set_label("params");
        const GLsizeiptr param_bytes = kernel_set().param_words * kWordBytes;
        glNamedBufferStorage(name, (param_bytes + kBlockBytes - 1) / kBlockBytes * kBlockBytes,
                             nullptr, GL_DYNAMIC_STORAGE_BIT);
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, name);
        for (int i = 0; i < std::ssize(objects_->buffers); ++i) {
            if (Status status = allocate_current(BufferIndex{i}, 0); !status) return status;
        }
        return Done{};
    }

    Status compile(const StorageBlocks& blocks) {
        Status compiled = objects_->kernels.compile(blocks);
        return compiled ? compiled : Error{fmt::format("{}: {}", device_name(), compiled.error())};
    }

    Status allocate_current(BufferIndex buffer, int64_t words) {
        if (Status has_blocks = make_blocks(buffer, words); !has_blocks) return has_blocks;
        object(buffer) = GlStorage();  // first, so that old and new are never there at once
        check_errors();                // so that an error below is about this allocation
        if (!failure_.empty()) return Error{failure_};
        const auto number = static_cast<size_t>(buffer);
        const GLenum error = object(buffer).allocate(kernel_set().buffers[number], words,
                                                     blocks_.words_most(kernel_set(), number),
                                                     blocks_.count(number));
        if (error != GL_NO_ERROR) {
            return allocation_error(kernel_set(), buffer, words,
                                    fmt::format("{} from {}", gl_error_name(error), device_name()));
        }
        return bind(buffer);
    }

    /// Binds all blocks of a buffer, those that it does not need with a word in each.
    Status bind(BufferIndex buffer) {
        const auto number = static_cast<size_t>(buffer);
        GlStorage& storage = object(buffer);
        const GLenum error =
            storage.add_blocks(kernel_set().buffers[number], blocks_.count(number));
        if (error != GL_NO_ERROR) {
            return allocation_error(kernel_set(), buffer, blocks_.count(number),
                                    fmt::format("{} from {}", gl_error_name(error), device_name()));
        }
        for (int block = 0; block < blocks_.count(number); ++block) {
            glBindBufferBase(GL_SHADER_STORAGE_BUFFER, blocks_.binding(kernel_set(), number, block),
                             storage.blocks()[static_cast<size_t>(block)].name());
        }
        return Done{};
    }

    /// Lets the kernels address as many blocks as so many words of a buffer take. That compiles
    /// them anew, for seconds: the blocks are those that all buffers are expected to need, if there
    /// are as many.
    Status make_blocks(BufferIndex buffer, int64_t words) {
        const auto number = static_cast<size_t>(buffer);
        if (words <= blocks_.words_most(kernel_set(), number) * blocks_.count(number)) {
            return Done{};
        }
        const int capacity = block_capacity();
        std::vector<int64_t> expected = expected_words_;
        expected[number] = std::max(expected[number], words);
        StorageBlocks blocks = blocks_.grown(kernel_set(), expected);
        if (blocks.total(kernel_set()) > capacity) {
            expected.assign(expected.size(), 0);
            expected[number] = words;
            blocks = blocks_.grown(kernel_set(), expected);
        }
        if (!kernel_set().are_long[number] || blocks.total(kernel_set()) > capacity) {
            return allocation_error(
                kernel_set(), buffer, words,
                fmt::format("of {}, {} storage blocks have {} MiB at most "
                            "(GL_MAX_SHADER_STORAGE_BLOCK_SIZE)",
                            device_name(), kernel_set().are_long[number] ? capacity : 1,
                            (blocks_.words_most(kernel_set(), number) * kWordBytes) >> 20));
        }
        if (!blocks_refusal_.empty()) return Error{blocks_refusal_};
        if (const Status made = compile(blocks); !made) {
            blocks_refusal_ = made.error();  // for good: each try takes seconds
            return made;
        }
        blocks_ = std::move(blocks);
        for (int i = 0; i < std::ssize(objects_->buffers); ++i) {
            if (i == static_cast<int>(buffer)) continue;
            if (const Status bound = bind(BufferIndex{i}); !bound) {
                note_failure(bound.error());  // the kernels reach for what is not bound
                return bound;
            }
        }
        return Done{};
    }

    /// Storage blocks that the kernels' buffers may have, and places to bind them.
    int block_capacity() const {
        GLint binding_count = 0;
        glGetIntegerv(GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS, &binding_count);
        return std::min(context_.capabilities().storage_block_count, int{binding_count}) -
               (objects_->kernels.has_lists() ? 1 : 0);
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
            failure_ = fmt::format(
                "{} was reset and its buffers are lost; load an earlier snapshot into a "
                "new soil",
                device_name());
        } else if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
            failure_ = fmt::format("{} reports {}; load an earlier snapshot into a new soil",
                                   device_name(), gl_error_name(error));
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
    std::unique_ptr<Objects> objects_;
    std::optional<CurrentContext> current_;
    int use_depth_ = 0, session_depth_ = 0;
    bool is_late_read_done_ = true;
    std::vector<int32_t> params_;  ///< that the uniform block holds
    StorageBlocks blocks_;
    std::vector<int64_t> expected_words_;  ///< by buffer
    std::string blocks_refusal_;           ///< why there can be no more blocks
    int64_t sent_bytes_ = 0;  ///< GlUploads::sent_bytes() when the last read was asked for
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
            refuse(display.name + ": is a software renderer; ask for the GL backend to take it");
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
            refuse(fmt::format("{}: is a software renderer; ask for the GL backend to take it",
                               gl.renderer));
        } else if (!software) {
            software = std::move(*context);
        }
    }
    if (software) return GlDevice::create(kernel_set, std::move(*software));
    return Error{"no usable OpenGL 4.5 device, take the CPU backend: " + refusals};
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
