/// The CPU backend: buffers in host memory, kernels as C++ over oneTBB.
#include <tbb/task_arena.h>

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>

#include "device/allocation_error.h"
#include "device/kernel_set.h"
#include "device/parallel_ranges.h"

namespace bsoil::device {

namespace {

/// Fewer groups than this are not worth waking threads for.
constexpr int kParallelGroupsMin = 8;
/// A cache line: tiles, whose data are multiples of it, then never share one between threads.
constexpr size_t kAlignmentBytes = 64;

/// Zero-filled words on a cache line boundary. Pages nobody writes cost no memory: calloc leaves
/// them to the system.
class AlignedWords {
  public:
    /// False when there is no memory; then it is empty.
    bool allocate(int64_t words) {
        memory_.reset();
        count_ = 0;
        const auto size = static_cast<size_t>(words) * sizeof(int32_t) + kAlignmentBytes;
        memory_.reset(std::calloc(size, 1));
        if (!memory_) {
            return false;
        }
        void* start = memory_.get();
        size_t space = size;
        data_ = static_cast<int32_t*>(std::align(kAlignmentBytes, 1, start, space));
        count_ = words;
        return true;
    }
    int32_t* data() const { return memory_ ? data_ : nullptr; }
    int64_t count() const { return count_; }

  private:
    struct Free {
        void operator()(void* memory) const { std::free(memory); }
    };
    std::unique_ptr<void, Free> memory_;
    int32_t* data_ = nullptr;
    int64_t count_ = 0;
};

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

class CpuDevice final : public Device {
  public:
    CpuDevice(const KernelSet& kernel_set, int thread_count)
        : kernel_set_(kernel_set),
          arena_(thread_count > 0 ? thread_count : tbb::task_arena::automatic),
          name_(cpu_model_name()) {}

    std::string backend_name() const override { return "cpu"; }
    std::string device_name() const override { return name_; }
    int thread_count() const override { return arena_.max_concurrency(); }

    Status allocate(Buffer buffer, int64_t words) override {
        assert(words >= 0);
        AlignedWords& target = words_of(buffer);
        const bool done = target.allocate(words);
        memory_.buffers[static_cast<int>(buffer)] = target.data();
        if (!done) {
            return allocation_error(buffer, words, "the host has not that much memory free");
        }
        return Done{};
    }

    void write(Buffer buffer, int64_t offset, std::span<const int32_t> words) override {
        assert_range(buffer, offset, std::ssize(words));
        std::ranges::copy(words, words_of(buffer).data() + offset);
    }

    void read(Buffer buffer, int64_t offset, std::span<int32_t> words) override {
        assert_range(buffer, offset, std::ssize(words));
        std::copy_n(words_of(buffer).data() + offset, words.size(), words.data());
    }

    void fill_zero(Buffer buffer, int64_t offset, int64_t count) override {
        assert_range(buffer, offset, count);
        std::fill_n(words_of(buffer).data() + offset, count, 0);
    }

    void set_params(std::span<const int32_t> words) override {
        assert(std::ssize(words) == kParamWords);
        std::memcpy(&memory_.params, words.data(), words.size_bytes());
    }

    void dispatch(int kernel, const WorkList& work) override {
        assert(kernel >= 0 && kernel < std::ssize(kernel_set_.kernels));
        assert(covers_all_groups(work));
        const KernelInfo& info = kernel_set_.kernels[static_cast<size_t>(kernel)];
        memory_.params.list_offset = work.list_offset;
        memory_.params.list_count = work.group_count;
        if (thread_count() == 1 || work.group_count < kParallelGroupsMin) {
            run_serially(info, work);
        } else if (info.is_scatter) {
            for (const auto& tiles : work.tiles_by_colour) {
                run_parallel(info, {&tiles, 1});
            }
        } else {
            run_parallel(info, work.tiles_by_colour);
        }
    }

    void finish() override {}
    int32_t* host_view(Buffer buffer) override { return words_of(buffer).data(); }

    int64_t memory_bytes() const override {
        int64_t bytes = 0;
        for (const AlignedWords& words : buffers_) {
            bytes += words.count() * static_cast<int64_t>(sizeof(int32_t));
        }
        return bytes;
    }

  private:
    AlignedWords& words_of(Buffer buffer) { return buffers_[static_cast<int>(buffer)]; }

    void assert_range([[maybe_unused]] Buffer buffer, [[maybe_unused]] int64_t offset,
                      [[maybe_unused]] int64_t count) {
        assert(offset >= 0 && count >= 0 && offset + count <= words_of(buffer).count());
    }

    /// The same order of colours as in parallel, so that what is wrong on one thread is wrong in
    /// the same way.
    void run_serially(const KernelInfo& info, const WorkList& work) {
        for (const auto& tiles : work.tiles_by_colour) {
            for (const TileRange& tile : tiles) {
                info.run(memory_, tile.first_group, tile.group_count);
            }
        }
    }

    /// All tiles of these lists, in any order and at the same time.
    void run_parallel(const KernelInfo& info, std::span<const std::vector<TileRange>> tile_lists) {
        size_t tile_count = 0;
        for (const auto& tiles : tile_lists) {
            tile_count += tiles.size();
        }
        if (tile_count == 0) {
            return;
        }
        arena_.execute([&] {
            parallel_ranges(tile_count, [&](size_t first, size_t last) {
                for (size_t i = first; i < last; ++i) {
                    const TileRange tile = tile_at(tile_lists, i);
                    info.run(memory_, tile.first_group, tile.group_count);
                }
            });
        });
    }

    static TileRange tile_at(std::span<const std::vector<TileRange>> tile_lists, size_t i) {
        size_t list = 0;
        while (i >= tile_lists[list].size()) {
            i -= tile_lists[list++].size();
        }
        return tile_lists[list][i];
    }

    const KernelSet& kernel_set_;
    tbb::task_arena arena_;
    std::string name_;
    AlignedWords buffers_[kBufferCount];
    KernelMemory memory_;
};

}  // namespace

std::unique_ptr<Device> create_cpu_device(const KernelSet& kernel_set, int thread_count) {
    return std::make_unique<CpuDevice>(kernel_set, thread_count);
}

}  // namespace bsoil::device
