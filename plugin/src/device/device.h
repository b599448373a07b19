/// The device layer: integer buffers and kernels, on the CPU or on OpenGL compute. It knows no
/// soil: which buffers and kernels there are says the KernelSet that a device is made of.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bsoil/device_info.h"
#include "bsoil/result.h"

#pragma GCC visibility push(default)
namespace bsoil::device {

struct KernelSet;

/// A buffer by its place in KernelSet::buffers, which is its binding too (GL: storage block).
enum class BufferIndex : int {};

/// Work of one dispatch: group g runs kernel(g, lane 0..63). Groups are ordered by tile; on the CPU
/// all groups of a tile run in order on one thread, and tiles of different colour never at once.
/// With 2 x 2 colours (x and y of the tile odd or even) a kernel may so add to what belongs to its
/// own tile, and to the nearer half of each of the eight around it, without atomics: two tiles of
/// one colour reach different halves of the tile between them.
struct TileRange {
    int first_group = 0, group_count = 0;
};
struct WorkList {
    int group_count = 0;
    std::vector<TileRange> tiles_by_colour[4];
};

/// One part of a read: `words.size()` words of a buffer from `offset` on.
struct ReadRange {
    BufferIndex buffer;
    int64_t offset = 0;
    std::span<int32_t> words;
};

/// `count` words of a buffer that move from `from` to `to`.
struct WordMove {
    int64_t from = 0, to = 0, count = 0;
};

/// What counting kernels have touched. In a dispatch each word counts once as read and once as
/// written, however often it was, and each cell (of a soil: a voxel) once.
struct TouchCounts {
    int64_t read_words = 0, written_words = 0;
    int64_t visited_cells = 0;  ///< of which a word was read or written
    int64_t changed_cells = 0;  ///< of which a word was given another value
};

/// What a device has been asked to do since it was made.
struct DeviceCounters {
    int64_t dispatch_count = 0, group_count = 0;
    int64_t write_count = 0, write_bytes = 0;  ///< to the device
    int64_t write_call_count = 0;              ///< of OpenGL, for writes and fills together
    int64_t read_count = 0, read_bytes = 0;    ///< from it
    /// Reads that the host waited for, because the GPU was not known to be through. The CPU's
    /// kernels are through when dispatch() returns.
    int64_t wait_count = 0;
    int64_t read_copy_count = 0;  ///< that OpenGL made for them, several parts in one
    int64_t fill_count = 0;
    int64_t context_count = 0;  ///< times that an OpenGL context was made current
    /// By kernel: lanes that had work. OpenGL does not count them; they are the same as on the CPU.
    std::vector<int64_t> lane_counts;
    /// By kernel: how often it was dispatched, and how long that took the device [ms]. OpenGL tells
    /// the times of a session's dispatches by the GPU's clock, when later sessions begin.
    std::vector<int64_t> kernel_dispatch_counts;
    std::vector<double> kernel_ms;
    /// By kernel; empty where the device does not count (BULLETSOIL_CPU=counting in the
    /// environment, CPU only).
    std::vector<TouchCounts> kernel_touches;
};

/// A place where kernels run. Every call is in order.
class Device {
  public:
    virtual ~Device() = default;
    virtual std::string backend_name() const = 0;  ///< "cpu" or "gl"
    virtual std::string device_name() const = 0;
    virtual int thread_count() const = 0;
    /// What broke the device after its creation (context refused, GPU lost or out of memory); empty
    /// while all is well. Once set, calls do nothing and reads give zeros.
    const std::string& failure() const { return failure_; }
    /// Breaks the device, for who cannot go on without what it has refused.
    void give_up(const std::string& why);

    /// (Re)allocates a buffer of `words` 32-bit words, zero-filled. Old content is lost.
    Status allocate(BufferIndex buffer, int64_t words);
    /// Makes a buffer larger; what it holds stays, what is new is zero. OpenGL's name for it
    /// changes.
    Status grow(BufferIndex buffer, int64_t words);
    /// How many words a buffer that has none yet may come to have. True where it has room for all
    /// of them from now on, zero-filled, since what nobody has written costs nothing; use() names
    /// what is going to be written. Else it grows, and in OpenGL, where it outgrows a storage
    /// block, it gets as many as it will need: each change compiles all kernels anew.
    bool expect(BufferIndex buffer, int64_t words);
    void use(BufferIndex buffer, int64_t offset, int64_t count);
    /// Gives a buffer another size; the words that move stay, all others are zero. On the device
    /// alone. OpenGL's name for it changes. An error leaves it as it was.
    Status rearrange(BufferIndex buffer, int64_t words, std::span<const WordMove> moves);
    void write(BufferIndex buffer, int64_t offset, std::span<const int32_t> words);
    void fill_zero(BufferIndex buffer, int64_t offset, int64_t count);
    /// Waits for the device, once for all ranges.
    void read(std::span<const ReadRange> ranges);
    void read(BufferIndex buffer, int64_t offset, std::span<int32_t> words);
    /// The same in two: asks for ranges as they are behind all work so far, and takes them. The
    /// words must stay where they are in between. One such read at a time; read() may come between.
    /// @{
    void start_read(std::span<const ReadRange> ranges);
    void finish_read();
    /// @}
    /// Whether finish_read() would not wait.
    virtual bool is_read_done() { return true; }
    /// Runs kernel number `kernel` of the set over the list with these words as its uniform block
    /// (KernelSet::param_words of them), then makes its writes visible to what follows.
    void dispatch(int kernel, std::span<const int32_t> params, const WorkList& work);

    /// OpenGL's name of a buffer; 0 on the CPU.
    virtual uint32_t buffer_name(BufferIndex /*buffer*/) const { return 0; }
    /// A fence (GLsync) behind all work so far, handed to the GPU; null on the CPU. The device owns
    /// it until the next call.
    virtual void* signal() { return nullptr; }
    /// Lets the GPU wait for a fence of a context that shares with the device's.
    virtual void wait_for(void* /*fence*/) {}

    /// Work from here on counts for stage number `stage`, 0 <= stage < kStageCapacity. Between
    /// begin_session() and end_session().
    virtual void mark_stage(int stage) = 0;
    /// Time of each stage [ms] of the last session whose times are known: on the CPU the last one,
    /// by the host's clock; on OpenGL one or two before it, by the device's own clock, because
    /// asking for them never waits.
    std::span<const double> stage_ms() const { return stage_ms_; }
    static constexpr int kStageCapacity = 8;

    const DeviceCounters& counters() const { return counters_; }
    /// Bytes allocated on the device.
    int64_t memory_bytes() const;

  protected:
    explicit Device(const KernelSet& kernel_set);
    const KernelSet& kernel_set() const { return kernel_set_; }
    int64_t words_in(BufferIndex buffer) const { return words_[static_cast<size_t>(buffer)]; }

    // What a backend does, with arguments that have been checked: ranges lie inside of their
    // buffers and hold at least one word, lists at least one group.
    virtual Status allocate_words(BufferIndex buffer, int64_t words) = 0;
    virtual void use_words(BufferIndex /*buffer*/, int64_t /*offset*/, int64_t /*count*/) {}
    virtual bool expect_words(BufferIndex buffer, int64_t words) = 0;
    virtual Status rearrange_words(BufferIndex buffer, int64_t words,
                                   std::span<const WordMove> moves) = 0;
    virtual void write_words(BufferIndex buffer, int64_t offset,
                             std::span<const int32_t> words) = 0;
    virtual void clear_words(BufferIndex buffer, int64_t offset, int64_t count) = 0;
    virtual void read_words(std::span<const ReadRange> ranges) = 0;
    virtual void start_reading(std::span<const ReadRange> ranges) { read_words(ranges); }
    virtual void finish_reading() {}
    virtual void run_kernel(int kernel, std::span<const int32_t> params, const WorkList& work) = 0;
    virtual void begin_session() {}
    virtual void end_session() {}

    DeviceCounters counters_;
    double stage_ms_[kStageCapacity] = {};
    std::string failure_;

  private:
    friend class DeviceSession;
    void assert_range(BufferIndex buffer, int64_t offset, int64_t count) const;
    bool count_read(std::span<const ReadRange> ranges);

    const KernelSet& kernel_set_;
    std::vector<int64_t> words_;  ///< of each buffer
    bool is_reading_ = false;     ///< between start_read() and finish_read()
};

/// Many calls of a device in a row: an OpenGL context is made current once for all of them, and the
/// caller's again at the end. No other context may be made current in this thread meanwhile.
class DeviceSession {
  public:
    explicit DeviceSession(Device& device) : device_(&device) { device.begin_session(); }
    ~DeviceSession() { end(); }
    DeviceSession(const DeviceSession&) = delete;
    DeviceSession& operator=(const DeviceSession&) = delete;
    /// Before its scope does.
    void end() {
        if (device_) std::exchange(device_, nullptr)->end_session();
    }

  private:
    Device* device_;
};

/// The CPU backend. `thread_count` 0 = all cores. The kernel set must outlive the device.
std::unique_ptr<Device> create_cpu_device(const KernelSet& kernel_set, int thread_count);
/// OpenGL 4.5 compute through EGL, surfaceless; software renderers only when `allow_software`.
/// The error says what is missing (no EGL, no 4.5, no compute). Leaves the caller's current context
/// as it was.
Result<std::unique_ptr<Device>> create_gl_device(const KernelSet& kernel_set, bool allow_software);
/// The same in a context that shares its buffers with a host's: an EGLDisplay and an EGLContext of
/// it, or null for those that are current in this thread. The error says why they cannot be shared.
Result<std::unique_ptr<Device>> create_shared_gl_device(const KernelSet& kernel_set,
                                                        void* egl_display, void* egl_context);
/// The CPU, and what EGL lists, as far as these kernels can run there.
std::vector<DeviceInfo> list_devices(const KernelSet& kernel_set);

}  // namespace bsoil::device
#pragma GCC visibility pop
