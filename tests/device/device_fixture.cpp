#include "device_fixture.h"

#include <algorithm>
#include <cstdlib>

namespace bsoil::device {

WorkList plain_work(int group_count, int groups_per_tile) {
    WorkList work;
    work.group_count = group_count;
    for (int first = 0, tile = 0; first < group_count; first += groups_per_tile, ++tile) {
        work.tiles_by_colour[tile % 4].push_back(
            {first, std::min(groups_per_tile, group_count - first)});
    }
    return work;
}

std::span<const int32_t> words_of(const TestParams& params) {
    return {reinterpret_cast<const int32_t*>(&params), sizeof(params) / sizeof(int32_t)};
}

void dispatch(Device& device, TestKernel kernel, const WorkList& work, const TestParams& params) {
    device.dispatch(kernel, words_of(params), work);
}

std::vector<int32_t> read_words(Device& device, BufferIndex buffer, int64_t count) {
    std::vector<int32_t> words(static_cast<size_t>(count));
    device.read(buffer, 0, words);
    return words;
}

std::unique_ptr<Device> create_test_device(const std::string& name, std::string& reason) {
    if (name.starts_with("gl")) {
        if (name == "gl_as_hardware") setenv("BULLETSOIL_GL", "hardware", 1);
        if (name == "gl_in_small_blocks") setenv("BULLETSOIL_GL", "small_blocks", 1);
        auto device = create_gl_device(test_kernel_set(), true);
        unsetenv("BULLETSOIL_GL");
        reason = device.error();
        return device ? std::move(*device) : nullptr;
    }
    return create_cpu_device(test_kernel_set(), name == "cpu1" ? 1 : 2);
}

void AnyDevice::SetUp() {
    std::string reason;
    device_ = create_test_device(GetParam(), reason);
    if (!device_) {
        GTEST_SKIP() << reason;
    }
}

}  // namespace bsoil::device
