/// Choice of a device, and what all of them share.
#include "device/device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <utility>

#include "device/allocation_error.h"
#include "device/cpu_name.h"
#include "device/egl_context.h"
#include "device/kernel_set.h"

namespace bsoil::device {

Error allocation_error(const KernelSet& kernel_set, BufferIndex buffer, int64_t words,
                       const std::string& reason) {
    constexpr double kWordsPerMebibyte = 1024.0 * 1024.0 / sizeof(int32_t);
    return {
        fmt::format("buffer {}: cannot allocate {:.1f} MiB: {}; take a smaller grid or larger "
                    "voxels",
                    kernel_set.buffers[static_cast<size_t>(buffer)],
                    static_cast<double>(words) / kWordsPerMebibyte, reason)};
}

namespace {

/// Whether the tiles of all colours together hold as many groups as the list.
[[maybe_unused]] bool covers_all_groups(const WorkList& work) {
    int group_count = 0;
    for (const auto& tiles : work.tiles_by_colour) {
        for (const TileRange& tile : tiles) group_count += tile.group_count;
    }
    return group_count == work.group_count;
}

int64_t bytes_of(int64_t words) { return words * static_cast<int64_t>(sizeof(int32_t)); }

void set_zero(std::span<const ReadRange> ranges) {
    for (const ReadRange& range : ranges) std::ranges::fill(range.words, 0);
}

}  // namespace

Device::Device(const KernelSet& kernel_set)
    : kernel_set_(kernel_set), words_(kernel_set.buffers.size(), 0) {
    assert(kernel_set.buffers.size() <= kBufferCapacity);
    counters_.kernel_dispatch_counts.resize(kernel_set.kernels.size());
    counters_.kernel_ms.resize(kernel_set.kernels.size());
}

void Device::give_up(const std::string& why) {
    if (failure_.empty()) failure_ = why;
}

void Device::assert_range([[maybe_unused]] BufferIndex buffer, [[maybe_unused]] int64_t offset,
                          [[maybe_unused]] int64_t count) const {
    assert(offset >= 0 && count >= 0 && offset + count <= words_in(buffer));
}

Status Device::allocate(BufferIndex buffer, int64_t words) {
    assert(words >= 0);
    if (!failure_.empty()) return Error{failure_};
    const Status status = allocate_words(buffer, words);
    words_[static_cast<size_t>(buffer)] = status ? words : 0;
    return status;
}

bool Device::expect(BufferIndex buffer, int64_t words) {
    assert(words_in(buffer) == 0);
    const bool has_room = expect_words(buffer, words);
    if (has_room) words_[static_cast<size_t>(buffer)] = words;
    return has_room;
}

void Device::use(BufferIndex buffer, int64_t offset, int64_t count) {
    if (!failure_.empty()) return;
    assert_range(buffer, offset, count);
    use_words(buffer, offset, count);
}

Status Device::grow(BufferIndex buffer, int64_t words) {
    assert(words >= words_in(buffer));
    const WordMove all{0, 0, words_in(buffer)};
    return rearrange(buffer, words, {&all, 1});
}

Status Device::rearrange(BufferIndex buffer, int64_t words, std::span<const WordMove> moves) {
    if (!failure_.empty()) return Error{failure_};
    for (const WordMove& move : moves) {
        assert_range(buffer, move.from, move.count);
        assert(move.to >= 0 && move.to + move.count <= words);
    }
    const Status status = rearrange_words(buffer, words, moves);
    if (status) words_[static_cast<size_t>(buffer)] = words;
    return status;
}

void Device::write(BufferIndex buffer, int64_t offset, std::span<const int32_t> words) {
    if (!failure_.empty()) return;
    assert_range(buffer, offset, std::ssize(words));
    if (words.empty()) return;
    ++counters_.write_count;
    counters_.write_bytes += bytes_of(std::ssize(words));
    write_words(buffer, offset, words);
}

void Device::fill_zero(BufferIndex buffer, int64_t offset, int64_t count) {
    if (!failure_.empty()) return;
    assert_range(buffer, offset, count);
    if (count == 0) return;
    ++counters_.fill_count;
    clear_words(buffer, offset, count);
}

/// Whether there is anything to read.
bool Device::count_read(std::span<const ReadRange> ranges) {
    int64_t word_count = 0;
    for (const ReadRange& range : ranges) {
        assert_range(range.buffer, range.offset, std::ssize(range.words));
        word_count += std::ssize(range.words);
    }
    if (word_count == 0) return false;
    ++counters_.read_count;
    counters_.read_bytes += bytes_of(word_count);
    return true;
}

void Device::read(std::span<const ReadRange> ranges) {
    if (!failure_.empty()) {
        set_zero(ranges);
    } else if (count_read(ranges)) {
        read_words(ranges);
    }
}

void Device::start_read(std::span<const ReadRange> ranges) {
    assert(!is_reading_);
    if (!failure_.empty()) {
        set_zero(ranges);
        return;
    }
    is_reading_ = count_read(ranges);
    if (is_reading_) start_reading(ranges);
}

void Device::finish_read() {
    if (std::exchange(is_reading_, false)) finish_reading();
}

void Device::read(BufferIndex buffer, int64_t offset, std::span<int32_t> words) {
    const ReadRange range{buffer, offset, words};
    read({&range, 1});
}

void Device::dispatch(int kernel, std::span<const int32_t> params, const WorkList& work) {
    assert(kernel >= 0 && kernel < std::ssize(kernel_set_.kernels));
    assert(std::ssize(params) == kernel_set_.param_words);
    assert(covers_all_groups(work));
    if (work.group_count == 0 || !failure_.empty()) return;
    ++counters_.dispatch_count;
    counters_.group_count += work.group_count;
    const auto index = static_cast<size_t>(kernel);
    ++counters_.kernel_dispatch_counts[index];
    run_kernel(kernel, params, work);
}

int64_t Device::memory_bytes() const {
    int64_t words = 0;
    for (int64_t count : words_) words += count;
    return bytes_of(words);
}

std::vector<DeviceInfo> list_devices(const KernelSet& kernel_set) {
    std::vector<DeviceInfo> devices{{.name = cpu_model_name(),
                                     .detail = fmt::format("CPU, {} threads", cpu_thread_count()),
                                     .usable = true,
                                     .hardware = true}};
    const auto displays = find_egl_displays();
    if (!displays) {
        devices.push_back({.name = "OpenGL", .detail = displays.error()});
        return devices;
    }
    for (const EglDisplay& display : *displays) {
        auto context = EglContext::create(display);
        if (!context) {
            devices.push_back({.name = display.name, .detail = context.error()});
            continue;
        }
        const GlCapabilities& gl = context->capabilities();
        const std::string shortfall = gl.shortfall(static_cast<int>(kernel_set.buffers.size()));
        devices.push_back(
            {.name = gl.renderer,
             .detail = fmt::format("OpenGL {}, {} storage blocks of {} MiB at most{}", gl.version,
                                   gl.storage_block_count, gl.storage_block_bytes >> 20,
                                   shortfall.empty() ? "" : "; unusable: " + shortfall),
             .usable = shortfall.empty(),
             .hardware = !gl.is_software});
    }
    return devices;
}

}  // namespace bsoil::device
