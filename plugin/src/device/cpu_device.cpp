/// The CPU backend: buffers in host memory, kernels as C++ over oneTBB.
#include <tbb/task_arena.h>
#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <algorithm>
#include <atomic>
#include <cassert>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <string_view>

#include "device/allocation_error.h"
#include "device/cpu_name.h"
#include "device/kernel_set.h"
#include "device/parallel_ranges.h"

namespace bsoil::device {

namespace {

/// Fewer groups than this are not worth waking threads for.
constexpr int kParallelGroupsMin = 8;
/// From so many words on several threads read. Ours: 1 MiB, a tenth of a millisecond for one.
/// Larger: one thread reads the tiles that fall asleep; smaller: sharing the work takes longer than
/// the work.
constexpr size_t kSharedWords = size_t{1} << 18;
/// A cache line: tiles, whose data are multiples of it, then never share one between threads.
constexpr size_t kAlignmentBytes = 64;

/// Two huge pages of x86-64: a buffer from this size on holds one, wherever it starts. Smaller:
/// buffers that hold none are asked for; larger: some go without that could have one.
constexpr size_t kHugePagesFromBytes = size_t{4} << 20;

/// Asks the system for huge pages: a voxel's words lie in as many planes, each on a page of its
/// own, and a buffer of 100 MB has 25,000 small pages to make and to look up. Without huge ones all
/// is the same, but slower.
void ask_for_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] size_t size) {
#if defined(MADV_HUGEPAGE)
    constexpr size_t kPage = 4096;  // where the system's are larger it refuses
    if (size < kHugePagesFromBytes) return;
    void* start = memory;
    size_t space = size;
    if (std::align(kPage, kPage, start, space)) madvise(start, space, MADV_HUGEPAGE);
#endif
}

/// Zero-filled words on a cache line boundary. Pages nobody writes cost no memory: calloc leaves
/// them to the system.
class AlignedWords {
  public:
    /// False when there is no memory; then it is empty.
    bool allocate(int64_t words, bool is_all_used) {
        memory_.reset();
        const auto size = static_cast<size_t>(words) * sizeof(int32_t) + kAlignmentBytes;
        memory_.reset(std::calloc(size, 1));
        if (!memory_) return false;
        if (is_all_used) ask_for_huge_pages(memory_.get(), size);
        void* start = memory_.get();
        size_t space = size;
        data_ = static_cast<int32_t*>(std::align(kAlignmentBytes, 1, start, space));
        return true;
    }
    int32_t* data() const { return memory_ ? data_ : nullptr; }

  private:
    struct Free {
        void operator()(void* memory) const { std::free(memory); }
    };
    std::unique_ptr<void, Free> memory_;
    int32_t* data_ = nullptr;
};

using Clock = std::chrono::steady_clock;

/// The kernels for this processor. All kinds give the same bits; BULLETSOIL_CPU=baseline in the
/// environment takes those that run on any, BULLETSOIL_CPU=counting those that count what they
/// touch, where the set has such.
std::span<const KernelInfo> kernels_for_this_cpu(const KernelSet& set) {
    const char* wanted = std::getenv("BULLETSOIL_CPU");
    if (wanted && std::string_view(wanted) == "counting" && !set.counting_kernels.empty()) {
        return set.counting_kernels;
    }
#if defined(__x86_64__)
    const bool is_wide = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                         __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
    if (is_wide && !set.wide_kernels.empty() &&
        !(wanted && std::string_view(wanted) == "baseline")) {
        return set.wide_kernels;
    }
#endif
    return set.kernels;
}

class CpuDevice final : public Device {
  public:
    CpuDevice(const KernelSet& set, int thread_count)
        : Device(set),
          arena_(thread_count > 0 ? thread_count : tbb::task_arena::automatic),
          kernels_(kernels_for_this_cpu(set)),
          name_(cpu_model_name()) {
        if (!set.counting_kernels.empty() && kernels_.data() == set.counting_kernels.data()) {
            notes_ = std::make_unique<TouchNotes>();
            memory_.notes = notes_.get();
            counters_.kernel_touches.resize(set.kernels.size());
        }
    }

    std::string backend_name() const override { return "cpu"; }
    std::string device_name() const override { return name_; }
    int thread_count() const override { return arena_.max_concurrency(); }

    // Kernels are done when dispatch returns, so the host's clock tells how long they took.
    void mark_stage(int stage) override {
        assert(session_depth_ > 0 && stage >= 0 && stage < kStageCapacity);
        end_stage();
        stage_ = stage;
    }

  protected:
    Status allocate_words(BufferIndex buffer, int64_t words) override {
        return allocate_words(buffer, words, true);
    }
    bool expect_words([[maybe_unused]] BufferIndex buffer,
                      [[maybe_unused]] int64_t words) override {
#if defined(__linux__) || defined(__APPLE__)
        // Counting kernels have a mark for each word.
        return sizeof(void*) > 4 && !notes_ && allocate_words(buffer, words, false);
#else
        return false;
#endif
    }
    void use_words(BufferIndex buffer, int64_t offset, int64_t count) override {
        ask_for_huge_pages(words_of(buffer).data() + offset,
                           static_cast<size_t>(count) * sizeof(int32_t));
    }
    Status allocate_words(BufferIndex buffer, int64_t words, bool are_used) {
        AlignedWords& target = words_of(buffer);
        const bool done = target.allocate(words, are_used);
        memory_.buffers[static_cast<int>(buffer)] = target.data();
        if (!done) {
            return allocation_error(kernel_set(), buffer, words,
                                    "the host has not that much memory free");
        }
        if (notes_) notes_->words[static_cast<int>(buffer)].assign(static_cast<size_t>(words), 0);
        return Done{};
    }

    Status rearrange_words(BufferIndex buffer, int64_t words,
                           std::span<const WordMove> moves) override {
        AlignedWords old = std::move(words_of(buffer));
        Status done = allocate_words(buffer, words);
        if (!done) {
            words_of(buffer) = std::move(old);
            memory_.buffers[static_cast<int>(buffer)] = words_of(buffer).data();
            return done;
        }
        // Most of what this takes is the system's: each page of the new buffer is made as it is
        // written.
        arena_.execute([&] {
            parallel_ranges(moves.size(), [&](size_t first, size_t last) {
                for (const WordMove& move : moves.subspan(first, last - first)) {
                    std::copy_n(old.data() + move.from, move.count,
                                words_of(buffer).data() + move.to);
                }
            });
        });
        return done;
    }

    void write_words(BufferIndex buffer, int64_t offset, std::span<const int32_t> words) override {
        std::ranges::copy(words, words_of(buffer).data() + offset);
    }

    void read_words(std::span<const ReadRange> ranges) override {
        size_t words = 0;
        for (const ReadRange& range : ranges) words += range.words.size();
        const auto copy = [&](size_t first, size_t last) {
            for (const ReadRange& range : ranges.subspan(first, last - first)) {
                std::copy_n(words_of(range.buffer).data() + range.offset, range.words.size(),
                            range.words.data());
            }
        };
        if (words < kSharedWords || thread_count() == 1) {
            copy(0, ranges.size());
        } else {
            arena_.execute([&] { parallel_ranges(ranges.size(), copy); });
        }
    }

    void clear_words(BufferIndex buffer, int64_t offset, int64_t count) override {
        std::fill_n(words_of(buffer).data() + offset, count, 0);
    }

    void run_kernel(int kernel, std::span<const int32_t> params, const WorkList& work) override {
        const KernelInfo& info = kernels_[static_cast<size_t>(kernel)];
        memory_.params = params.data();
        lane_count_ = 0;
        if (notes_) begin_count();
        const Clock::time_point start = Clock::now();
        if (notes_ || thread_count() == 1 || work.group_count < kParallelGroupsMin) {
            run_serially(info, work);
        } else if (info.is_scatter) {
            for (const auto& tiles : work.tiles_by_colour) run_parallel(info, {&tiles, 1});
        } else {
            run_parallel(info, work.tiles_by_colour);
        }
        counters_.kernel_ms[static_cast<size_t>(kernel)] += ms_since(start);
        counters_.lane_counts.resize(kernel_set().kernels.size());
        counters_.lane_counts[static_cast<size_t>(kernel)] += lane_count_;
        if (notes_) add_counts(counters_.kernel_touches[static_cast<size_t>(kernel)]);
    }

    void begin_session() override {
        if (session_depth_++ == 0) {
            std::ranges::fill(stage_ms_, 0);
            stage_ = -1;
            stage_start_ = Clock::now();
        }
    }
    void end_session() override {
        if (--session_depth_ == 0) end_stage();
    }

  private:
    AlignedWords& words_of(BufferIndex buffer) { return buffers_[static_cast<int>(buffer)]; }

    static double ms_since(Clock::time_point start) {
        return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    }

    void end_stage() {
        if (stage_ >= 0) stage_ms_[stage_] += ms_since(stage_start_);
        stage_start_ = Clock::now();
        stage_ = -1;
    }

    void begin_count() {
        notes_->dispatch += TouchNotes::kBits + 1;
        notes_->counts = {};
    }
    void add_counts(TouchCounts& all) const {
        all.read_words += notes_->counts.read_words;
        all.written_words += notes_->counts.written_words;
        all.visited_cells += notes_->counts.visited_cells;
        all.changed_cells += notes_->counts.changed_cells;
    }

    /// The same order of colours as in parallel, so that what is wrong on one thread is wrong in
    /// the same way.
    void run_serially(const KernelInfo& info, const WorkList& work) {
        for (const auto& tiles : work.tiles_by_colour) {
            for (const TileRange& tile : tiles) {
                lane_count_ += info.run(memory_, tile.first_group, tile.group_count);
            }
        }
    }

    /// All tiles of these lists, in any order and at the same time.
    void run_parallel(const KernelInfo& info, std::span<const std::vector<TileRange>> tile_lists) {
        size_t tile_count = 0;
        for (const auto& tiles : tile_lists) tile_count += tiles.size();
        if (tile_count == 0) return;
        arena_.execute([&] {
            parallel_ranges(tile_count, [&](size_t first, size_t last) {
                int64_t lane_count = 0;
                for (size_t i = first; i < last; ++i) {
                    const TileRange tile = tile_at(tile_lists, i);
                    lane_count += info.run(memory_, tile.first_group, tile.group_count);
                }
                lane_count_ += lane_count;
            });
        });
    }

    static TileRange tile_at(std::span<const std::vector<TileRange>> tile_lists, size_t i) {
        size_t list = 0;
        while (i >= tile_lists[list].size()) i -= tile_lists[list++].size();
        return tile_lists[list][i];
    }

    tbb::task_arena arena_;
    std::span<const KernelInfo> kernels_;
    std::string name_;
    AlignedWords buffers_[kBufferCapacity];
    KernelMemory memory_;
    std::unique_ptr<TouchNotes> notes_;    ///< where kernels count
    std::atomic<int64_t> lane_count_ = 0;  ///< of the dispatch in progress
    int session_depth_ = 0;
    int stage_ = -1;  ///< that runs; -1: none
    Clock::time_point stage_start_;
};

}  // namespace

std::string cpu_model_name() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);) {
        const size_t colon = line.find(": ");
        if (line.starts_with("model name") && colon != std::string::npos) {
            return line.substr(colon + 2);
        }
    }
    return "CPU";
}

int cpu_thread_count() { return tbb::task_arena(tbb::task_arena::automatic).max_concurrency(); }

std::unique_ptr<Device> create_cpu_device(const KernelSet& kernel_set, int thread_count) {
    return std::make_unique<CpuDevice>(kernel_set, thread_count);
}

}  // namespace bsoil::device
